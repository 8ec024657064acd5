"""The policies that come with the warehouse, by the names that a policies file uses."""

from __future__ import annotations

from soup_managers.policies.coordinated import Coordinated
from soup_managers.policies.fleet import AnyFleet
from soup_managers.policies.fleet import Minimal as MinimalFleet
from soup_managers.policies.letter import Ahead, LetterPolicy
from soup_managers.policies.letter import Minimal as MinimalLetter
from soup_managers.policies.word import Minimal as MinimalWord
from soup_managers.policies.word import Served, WordPolicy

WORD: dict[str, type[WordPolicy]] = {"minimal": MinimalWord, "served": Served}
LETTER: dict[str, type[LetterPolicy]] = {"minimal": MinimalLetter, "ahead": Ahead}
FLEET: dict[str, type[AnyFleet]] = {"minimal": MinimalFleet, "coordinated": Coordinated}
