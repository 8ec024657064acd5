"""What the world tells while it runs: events, poses, stations, snapshots."""

from __future__ import annotations

from array import array
from itertools import pairwise
from typing import Any

import numpy as np
from soup_msgs import msg

from soup_msgs_py.codes import BotState, EventType
from soup_msgs_py.messages import (
    Bots,
    Buckets,
    Bundle,
    Event,
    FollowPath,
    LetterStationState,
    Snapshot,
    Stations,
    Word,
    WordStationState,
    WorldState,
)
from soup_msgs_py.wire.basics import (
    TYPECODES,
    MalformedMessage,
    check_finite,
    check_times,
    from_ros,
    from_stamp,
    header_at,
    member,
    not_absurd,
    pack,
    to_ints,
    to_ros,
    to_ros_of,
    to_stamp,
    unpack,
)

# the arrays of a message and what their elements travel as
_BOTS = {"x": "d", "y": "d", "heading": "f", "vx": "f", "vy": "f", "bucket": "i", "state": "B"}
_BUCKETS = {"x": "f", "y": "f", "bot": "i", "tiles": "H"}


@to_ros.register
def _(event: Event) -> msg.Event:
    return msg.Event(
        stamp=to_stamp(event.time),
        sequence=event.sequence,
        type=event.type.value,
        bot=event.bot,
        bucket=event.bucket,
        station=event.station,
        tile=event.tile,
        job=event.job,
        count=event.count,
        x=float(event.x),
        y=float(event.y),
        bots=event.bots,
        buckets=event.buckets,
        tiles=event.tiles,
        text=event.text,
        waypoint=event.waypoint,
    )


@from_ros.register
def _(event: msg.Event) -> Event:
    check_finite(event.x, event.y)
    return Event(
        time=from_stamp(event.stamp),
        sequence=event.sequence,
        type=member(EventType, event.type),
        bot=event.bot,
        bucket=event.bucket,
        station=event.station,
        tile=event.tile,
        job=event.job,
        count=event.count,
        x=event.x,
        y=event.y,
        bots=to_ints(event.bots),
        buckets=to_ints(event.buckets),
        tiles=to_ints(event.tiles),
        text=event.text,
        waypoint=event.waypoint,
    )


@to_ros.register
def _(bots: Bots) -> msg.Bots:
    return _pack_arrays(msg.Bots(header=header_at(bots.time)), bots, _BOTS)


@from_ros.register
def _(bots: msg.Bots) -> Bots:
    arrays = _unpack_arrays(bots, _BOTS)
    state = arrays["state"]
    if len(state) and state.max() > max(BotState):
        raise MalformedMessage(f"{state.max()} is no state of a bot")
    return Bots(from_stamp(bots.header.stamp), **arrays)


@to_ros.register
def _(buckets: Buckets) -> msg.Buckets:
    return _pack_arrays(msg.Buckets(header=header_at(buckets.time)), buckets, _BUCKETS)


@from_ros.register
def _(buckets: msg.Buckets) -> Buckets:
    return Buckets(from_stamp(buckets.header.stamp), **_unpack_arrays(buckets, _BUCKETS))


def _pack_arrays(message: Any, values: Bots | Buckets, typecodes: dict[str, str]) -> Any:
    for name, typecode in typecodes.items():
        setattr(message, name, pack(typecode, getattr(values, name)))
    return message


def _unpack_arrays(message: Any, typecodes: dict[str, str]) -> dict[str, Any]:
    """The arrays of a message, all as long as the first one; whatever a number travels as, it is a float64 here."""
    size = len(getattr(message, next(iter(typecodes))))
    return {
        name: unpack(getattr(message, name), np.float64 if typecode in "df" else TYPECODES[typecode], size)
        for name, typecode in typecodes.items()
    }


@to_ros.register
def _(word: Word) -> msg.Word:
    return msg.Word(word=word.word, text=word.text, tiles=word.tiles, filled=[bool(f) for f in word.filled])


@from_ros.register
def _(word: msg.Word) -> Word:
    tiles, filled = to_ints(word.tiles), tuple(word.filled)
    if len(filled) not in (0, len(tiles)):
        raise MalformedMessage(f"a word of {len(tiles)} letters with {len(filled)} marks")
    return Word(word.word, word.text, tiles, filled)


@to_ros.register
def _(bundle: Bundle) -> msg.Bundle:
    return msg.Bundle(bundle=bundle.bundle, tile=bundle.tile, count=bundle.count)


@from_ros.register
def _(bundle: msg.Bundle) -> Bundle:
    return Bundle(bundle.bundle, bundle.tile, bundle.count)


@to_ros.register
def _(station: WordStationState) -> msg.WordStation:
    words = [to_ros(word) for word in station.open_words]
    return msg.WordStation(
        station=station.station, x=float(station.x), y=float(station.y), bot=station.bot, open_words=words
    )


@from_ros.register
def _(station: msg.WordStation) -> WordStationState:
    check_finite(station.x, station.y)
    words = tuple(map(from_ros, not_absurd(station.open_words)))
    return WordStationState(station.station, station.x, station.y, station.bot, words)


@to_ros.register
def _(station: LetterStationState) -> msg.LetterStation:
    bundles = [to_ros(bundle) for bundle in station.staged_bundles]
    return msg.LetterStation(
        station=station.station,
        x=float(station.x),
        y=float(station.y),
        bot=station.bot,
        staged_bundles=bundles,
    )


@from_ros.register
def _(station: msg.LetterStation) -> LetterStationState:
    check_finite(station.x, station.y)
    bundles = tuple(map(from_ros, not_absurd(station.staged_bundles)))
    return LetterStationState(station.station, station.x, station.y, station.bot, bundles)


@to_ros.register
def _(stations: Stations) -> msg.Stations:
    return msg.Stations(
        header=header_at(stations.time),
        word_stations=[to_ros(station) for station in stations.word_stations],
        letter_stations=[to_ros(station) for station in stations.letter_stations],
    )


@from_ros.register
def _(stations: msg.Stations) -> Stations:
    return Stations(
        from_stamp(stations.header.stamp),
        tuple(map(from_ros, not_absurd(stations.word_stations))),
        tuple(map(from_ros, not_absurd(stations.letter_stations))),
    )


@to_ros.register
def _(snapshot: Snapshot) -> msg.Snapshot:
    sizes = [len(content) for content in snapshot.contents]
    message = msg.Snapshot(
        header=header_at(snapshot.time),
        sequence=snapshot.sequence,
        bots=to_ros_of(snapshot.run, snapshot.bots),
        buckets=to_ros_of(snapshot.run, snapshot.buckets),
        word_stations=[to_ros(station) for station in snapshot.word_stations],
        letter_stations=[to_ros(station) for station in snapshot.letter_stations],
        waiting_words=[to_ros(word) for word in snapshot.waiting_words],
        waiting_bundles=[to_ros(bundle) for bundle in snapshot.waiting_bundles],
        words_completed=snapshot.words_completed,
        run=snapshot.run,
    )
    message.storage_spots = pack("i", snapshot.storage_spots)
    paths = snapshot.paths
    message.path_bot = pack("i", [path.bot for path in paths])
    message.path_request = pack("q", [path.request for path in paths])
    message.path_start = pack("i", np.concatenate([[0], np.cumsum([len(path.points) for path in paths])]))
    message.path_x = pack("d", [x for path in paths for x, _ in path.points])
    message.path_y = pack("d", [y for path in paths for _, y in path.points])
    message.path_time = pack("d", [time for path in paths for time in path.stamps])
    message.content_start = pack("i", np.concatenate([[0], np.cumsum(sizes)]))
    message.content_tile = pack("i", [tile for content in snapshot.contents for tile in content])
    message.content_count = pack("H", [count for content in snapshot.contents for count in content.values()])
    return message


@from_ros.register
def _(snapshot: msg.Snapshot) -> Snapshot:
    return Snapshot(
        time=from_stamp(snapshot.header.stamp),
        sequence=snapshot.sequence,
        bots=from_ros(snapshot.bots),
        buckets=from_ros(snapshot.buckets),
        contents=_read_contents(snapshot),
        word_stations=tuple(map(from_ros, not_absurd(snapshot.word_stations))),
        letter_stations=tuple(map(from_ros, not_absurd(snapshot.letter_stations))),
        waiting_words=tuple(map(from_ros, not_absurd(snapshot.waiting_words))),
        waiting_bundles=tuple(map(from_ros, not_absurd(snapshot.waiting_bundles))),
        words_completed=snapshot.words_completed,
        storage_spots=to_ints(snapshot.storage_spots),
        run=snapshot.run,
        paths=_read_paths(snapshot),
    )


def _read_paths(snapshot: msg.Snapshot) -> tuple[FollowPath, ...]:
    bots, requests, start = (to_ints(a) for a in (snapshot.path_bot, snapshot.path_request, snapshot.path_start))
    if not bots and not start:
        return ()  # as nobody has filled it in
    rises = all(a < b for a, b in pairwise(start))
    if not len(start) == len(bots) + 1 == len(requests) + 1 or start[0] != 0 or not rises:
        raise MalformedMessage("paths that do not fit their bots")
    arrays = (snapshot.path_x, snapshot.path_y, snapshot.path_time)
    xs, ys, stamps = (unpack(values, np.float64, start[-1]).tolist() for values in arrays)
    points = list(zip(xs, ys, strict=True))
    check_times(*stamps)
    paths = tuple(
        FollowPath(bot, request, tuple(points[a:b]), tuple(stamps[a:b]))
        for bot, request, (a, b) in zip(bots, requests, pairwise(start), strict=True)
    )
    if any(later < earlier for path in paths for earlier, later in pairwise(path.stamps)):
        raise MalformedMessage("a path back in time")
    return paths


def _read_contents(snapshot: msg.Snapshot) -> tuple[dict[int, int], ...]:
    start = to_ints(snapshot.content_start)
    tiles, counts = list(snapshot.content_tile), list(snapshot.content_count)
    rises = all(a <= b for a, b in pairwise(start))
    if len(start) != len(snapshot.buckets.x) + 1 or start[0] != 0 or not rises:
        raise MalformedMessage("contents that do not fit the buckets")
    if not start[-1] == len(tiles) == len(counts):
        raise MalformedMessage(f"contents of {start[-1]} kinds, {len(tiles)} kinds and {len(counts)} counts")
    return tuple(dict(zip(tiles[a:b], counts[a:b], strict=True)) for a, b in pairwise(start))


@to_ros.register
def _(state: WorldState) -> msg.WorldState:
    message = msg.WorldState(header=header_at(state.time), run=state.run, sequence=state.sequence)
    message.checkpoint = array("B", state.checkpoint)
    return message


@from_ros.register
def _(state: msg.WorldState) -> WorldState:
    return WorldState(from_stamp(state.header.stamp), state.run, state.sequence, bytes(state.checkpoint))
