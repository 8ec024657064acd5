"""A binary heap in two arrays, for compiled searches: the smallest key first, of equal keys any."""

from __future__ import annotations

from soup_msgs_py.kernel import kernel


@kernel
def push(keys, items, size, key, item):
    """Put an item into a heap of some size; the arrays must have room."""
    hole = size
    while hole > 0:
        parent = (hole - 1) >> 1
        if keys[parent] <= key:
            break
        keys[hole], items[hole] = keys[parent], items[parent]
        hole = parent
    keys[hole], items[hole] = key, item


@kernel
def drop_first(keys, items, size):
    """Take the first item away from a heap of some size."""
    last = size - 1
    key, item = keys[last], items[last]
    hole = 0
    while True:
        child = 2 * hole + 1
        if child >= last:
            break
        if child + 1 < last and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[hole], items[hole] = keys[child], items[child]
        hole = child
    keys[hole], items[hole] = key, item
