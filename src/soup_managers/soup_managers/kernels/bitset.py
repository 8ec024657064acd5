"""Sets of small numbers (buckets, bots) as the bits of a Python integer: ordered, and fast to intersect."""

from __future__ import annotations

from collections.abc import Iterator


def first(members_of: int) -> int:
    """The smallest member, or -1 of the empty set."""
    return (members_of & -members_of).bit_length() - 1


def members(members_of: int) -> Iterator[int]:
    """All members, the smallest first."""
    while members_of:
        lowest = members_of & -members_of
        yield lowest.bit_length() - 1
        members_of ^= lowest
