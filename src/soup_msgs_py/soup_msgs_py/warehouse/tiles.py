"""Letter tiles: a letter and a colour, numbered as one tile kind.

A tile kind is `26 * colour + letter` with A = 0. Written out it is the letter and the number of the colour: `E0`.
"""

from __future__ import annotations

import re

LETTERS = 26
ANY = -1
_NAME = re.compile(r"([A-Za-z])(\d{1,6})")


def tile_kind(letter: str, colour: int) -> int:
    """The tile kind of a letter (A to Z) in a colour (from 0)."""
    return LETTERS * colour + ord(letter) - ord("A")


def tile_letter(kind: int) -> str:
    """The letter of a tile kind."""
    return chr(ord("A") + kind % LETTERS)


def tile_colour(kind: int) -> int:
    """The colour of a tile kind."""
    return kind // LETTERS


def tile_name(kind: int) -> str:
    """A tile kind written out, for instance `E0`; empty for ANY."""
    return "" if kind == ANY else f"{tile_letter(kind)}{tile_colour(kind)}"


def parse_tile(name: str) -> int:
    """The tile kind of a written-out name; the empty name is ANY.

    Raises:
        ValueError: The name is not a letter followed by the number of a colour.
    """
    if not name:
        return ANY
    match = _NAME.fullmatch(name)
    if match is None:
        raise ValueError(f"{name!r} is not a letter tile; a tile is a letter and the number of its colour, as E0")
    return tile_kind(match[1].upper(), int(match[2]))
