"""Room for the letters that words lack: one that is opened without it may block its station, and others, for good.

Letters come in bundles of one kind, and what a word leaves over of them stays in the buckets. These can fill up with
what nobody asks for, until no bundle of a kind that open words lack goes in any more. That cannot happen while words
are opened only where there is room for all that open words lack.
"""

from __future__ import annotations

import numpy as np

from soup_managers.view import WarehouseView
from soup_msgs_py.warehouse.layout import Ints


def kept(view: WarehouseView) -> int:
    """The room that is kept free of what no open word lacks (tiles): for the longest waiting word, from nothing."""
    return view.scenario.bundle_size * max((len(word.tiles) for word in view.waiting_words.values()), default=0)


def left(view: WarehouseView, tiles: Ints, before: Ints, starts: Ints) -> Ints:
    """The room that is left if a word is opened, when there is least of it: as the last bundle has come in (tiles).

    All letters that open words lack are in place by then, but those of the last bundle. Below 0 it may never come in.

    Args:
        view: The warehouse.
        tiles: The letters of all waiting words, one word after the other, shape (letters,).
        before: How many of the same kind come before each in its word, shape (letters,).
        starts: Where each word begins, shape (words,).

    Returns:
        For each waiting word, shape (words,).
    """
    size = view.scenario.bundle_size
    shortage = view.wanted - view.stock
    short = shortage[shortage > 0]
    bundles = int((-(-short // size)).sum())
    # with this letter open words lack so many of its kind; each first one of a bundle needs one more bundle
    lacks = shortage[tiles] + before + 1
    more = np.add.reduceat(((lacks > 0) & (lacks % size == 1 % size)).astype(np.int64), starts)
    last = np.maximum(np.maximum.reduceat(lacks, starts), short.max(initial=0)).clip(0, size)
    lengths = np.diff(np.append(starts, len(tiles)))
    return view.room + int(view.wanted.sum()) + lengths - size * (bundles + more) - last
