"""Sets of small numbers (buckets, bots) as the bits of a Python integer: ordered, and fast to intersect."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray


def bits(mask: NDArray[np.bool_]) -> int:
    """The numbers at which a mask is true."""
    return int.from_bytes(np.packbits(mask, bitorder="little").tobytes(), "little")


def first(members_of: int) -> int:
    """The smallest member, or -1 of the empty set."""
    return (members_of & -members_of).bit_length() - 1


def members(members_of: int) -> Iterator[int]:
    """All members, the smallest first."""
    while members_of:
        lowest = members_of & -members_of
        yield lowest.bit_length() - 1
        members_of ^= lowest
