"""The policies of the word and the letter manager that come with the warehouse, by the names in a policies file."""

from __future__ import annotations

from soup_managers.policies.letter import Ahead, Drawn, LetterPolicy
from soup_managers.policies.letter import Minimal as MinimalLetter
from soup_managers.policies.word import InStock, Served, WordPolicy
from soup_managers.policies.word import Minimal as MinimalWord

WORD: dict[str, type[WordPolicy]] = {"minimal": MinimalWord, "in_stock": InStock, "served": Served}
LETTER: dict[str, type[LetterPolicy]] = {"minimal": MinimalLetter, "ahead": Ahead, "drawn": Drawn}
