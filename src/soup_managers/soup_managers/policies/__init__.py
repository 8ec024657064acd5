"""The policies that come with the warehouse, by the names that a policies file uses."""

from __future__ import annotations

from soup_managers.policies.fleet import FleetPolicy
from soup_managers.policies.fleet import Minimal as MinimalFleet
from soup_managers.policies.letter import LetterPolicy
from soup_managers.policies.letter import Minimal as MinimalLetter
from soup_managers.policies.word import Minimal as MinimalWord
from soup_managers.policies.word import WordPolicy

WORD: dict[str, type[WordPolicy]] = {"minimal": MinimalWord}
LETTER: dict[str, type[LetterPolicy]] = {"minimal": MinimalLetter}
FLEET: dict[str, type[FleetPolicy]] = {"minimal": MinimalFleet}
