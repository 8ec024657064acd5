"""The policies that come with the warehouse, by the names that a policies file uses."""

from __future__ import annotations

from soup_managers.policies.coordinated import Coordinated
from soup_managers.policies.fleet import AnyFleet
from soup_managers.policies.fleet import Minimal as MinimalFleet
from soup_managers.policies.letter import Ahead, Drawn, LetterPolicy
from soup_managers.policies.letter import Minimal as MinimalLetter
from soup_managers.policies.planned import Planned
from soup_managers.policies.word import InStock, Served, WordPolicy
from soup_managers.policies.word import Minimal as MinimalWord

WORD: dict[str, type[WordPolicy]] = {"minimal": MinimalWord, "in_stock": InStock, "served": Served}
LETTER: dict[str, type[LetterPolicy]] = {"minimal": MinimalLetter, "ahead": Ahead, "drawn": Drawn}
FLEET: dict[str, type[AnyFleet]] = {"minimal": MinimalFleet, "coordinated": Coordinated, "planned": Planned}
