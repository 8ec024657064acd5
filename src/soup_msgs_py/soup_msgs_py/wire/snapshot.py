"""The contents of buckets and the paths under way in a snapshot: flat lists, and where the part of each begins."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from itertools import accumulate, pairwise

import numpy as np

from soup_msgs_py.messages import FollowPath
from soup_msgs_py.wire.basics import MalformedMessage, pack, to_ints, to_times, unpack
from soup_msgs_py.wire.codec import Way


def _from_contents(contents: Sequence[dict[int, int]]) -> tuple[array[int], ...]:
    return (
        pack("i", list(accumulate(map(len, contents), initial=0))),
        pack("i", [tile for content in contents for tile in content]),
        pack("H", [count for content in contents for count in content.values()]),
    )


def _to_contents(starts: Sequence[int], tiles: Sequence[int], counts: Sequence[int]) -> tuple[dict[int, int], ...]:
    start = to_ints(starts)
    if not start or start[0] != 0 or any(a > b for a, b in pairwise(start)):
        raise MalformedMessage("contents that do not fit the buckets")
    if not start[-1] == len(tiles) == len(counts):
        raise MalformedMessage(f"contents of {start[-1]} kinds, {len(tiles)} kinds and {len(counts)} counts")
    return tuple(dict(zip(tiles[a:b], counts[a:b], strict=True)) for a, b in pairwise(start))


def _from_paths(paths: Sequence[FollowPath]) -> tuple[array[int] | array[float], ...]:
    return (
        pack("i", [path.bot for path in paths]),
        pack("q", [path.request for path in paths]),
        pack("i", list(accumulate((len(path.points) for path in paths), initial=0))),
        pack("d", [x for path in paths for x, _ in path.points]),
        pack("d", [y for path in paths for _, y in path.points]),
        pack("d", [time for path in paths for time in path.stamps]),
    )


def _to_paths(
    path_bots: Sequence[int],
    path_requests: Sequence[int],
    starts: Sequence[int],
    path_xs: Sequence[float],
    path_ys: Sequence[float],
    path_times: Sequence[float],
) -> tuple[FollowPath, ...]:
    bots, requests, start = to_ints(path_bots), to_ints(path_requests), to_ints(starts)
    if not bots and not start:
        return ()  # as nobody has filled it in
    rises = all(a < b for a, b in pairwise(start))
    if not len(start) == len(bots) + 1 == len(requests) + 1 or start[0] != 0 or not rises:
        raise MalformedMessage("paths that do not fit their bots")
    xs, ys, stamps = (unpack(values, np.float64, start[-1]).tolist() for values in (path_xs, path_ys, path_times))
    points, stamps = tuple(zip(xs, ys, strict=True)), to_times(stamps)
    paths = tuple(
        FollowPath(bot, request, points[a:b], stamps[a:b])
        for bot, request, (a, b) in zip(bots, requests, pairwise(start), strict=True)
    )
    if any(later < earlier for path in paths for earlier, later in pairwise(path.stamps)):
        raise MalformedMessage("a path back in time")
    return paths


CONTENTS = Way("content_start", "content_tile", "content_count", out=_from_contents, back=_to_contents)
PATHS = Way("path_bot", "path_request", "path_start", "path_x", "path_y", "path_time", out=_from_paths, back=_to_paths)
