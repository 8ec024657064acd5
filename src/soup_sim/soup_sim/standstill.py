"""Whether a run stands still for good, and what stands in its way as far as the world can see."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from soup_msgs_py.codes import BotState
from soup_msgs_py.messages import Snapshot, Word
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.tiles import tile_name

STALLED = "nothing has been moved since"
LEAST_S = 60.0
CROSSINGS = 4  # of the floor: a bot fetches a bucket, brings it to be filled and then to where it is wanted, and some
MOST_NAMED = 5


def patience_s(scenario: Scenario) -> float:
    """So long no letter may be moved while words wait, until the run counts as stalled (s)."""
    bot, floor = scenario.bot, scenario.floor
    crossing_s = (floor.width_m + floor.height_m) / bot.max_speed_mps
    stations_s = scenario.word_station.transfer_s + scenario.letter_station.transfer_s + scenario.word_station.clear_s
    return LEAST_S + CROSSINGS * (crossing_s + bot.grab_s + bot.release_s) + stations_s + bot.collision_penalty_s


def reasons(scenario: Scenario, layout: Layout, snapshot: Snapshot) -> list[str]:
    """What stands in the way of a stalled run, one sentence each.

    Args:
        scenario: The warehouse.
        layout: Its floor.
        snapshot: How everything is now.
    """
    stock: Counter[int] = Counter()
    for content in snapshot.contents:
        stock.update(content)
    staged = [bundle for station in snapshot.letter_stations for bundle in station.staged_bundles]
    coming: Counter[int] = Counter()
    for bundle in staged:
        coming[bundle.tile] += bundle.count
    room = scenario.buckets * scenario.bucket.capacity - stock.total()
    found = [
        *_no_word_open(scenario, snapshot, stock + coming, room - coming.total()),
        *_starving(layout, snapshot, stock, coming),
    ]
    if staged and room == 0:
        found.append(f"{len(staged)} bundles are on letter stations, and all buckets are full")
    elif staged:
        found.append(f"{coming.total()} letters are on letter stations, and the buckets have room for {room}")
    states = Counter(snapshot.bots.state.tolist())
    found.append(f"of {scenario.bots} bots {states[BotState.FREE]} do nothing")
    return found


def _no_word_open(scenario: Scenario, snapshot: Snapshot, there: Mapping[int, int], room: int) -> Iterable[str]:
    waiting = snapshot.waiting_words
    if not waiting or any(station.open_words for station in snapshot.word_stations):
        return
    if scenario.bundles.kind == "none":
        short = min(len(_lacking(word, there)) for word in waiting)
        yield f"no word is open: each of the {len(waiting)} that wait lacks {short} letters or more, and none come in"
        return
    bundles = min(len(set(_lacking(word, there))) for word in waiting)
    needed = bundles * scenario.bundle_size
    if scenario.bundles.kind == "chosen" and needed > room:
        yield (
            f"no word is open: each of the {len(waiting)} that wait needs {bundles} bundles of {scenario.bundle_size} "
            f"or more, and the buckets have room for {room} letters: they are full of what no word asks for"
        )
        return
    yield f"no word is open, {len(waiting)} wait: the word manager opens none"


def _lacking(word: Word, there: Mapping[int, int]) -> list[int]:
    """The letters of a word that are not there."""
    return list((Counter(word.tiles) - Counter(there)).elements())


def _starving(layout: Layout, snapshot: Snapshot, stock: Mapping[int, int], coming: Mapping[int, int]) -> Iterable[str]:
    """What word stations starve for."""
    starving = []
    for station in snapshot.word_stations:
        missing = Counter(
            tile
            for word in station.open_words
            for tile, filled in zip(word.tiles, word.filled or (False,) * len(word.tiles), strict=True)
            if not filled
        )
        if missing:
            starving.append((station.station, missing))
    for station, missing in starving[:MOST_NAMED]:
        kinds = sorted(missing, key=lambda tile: (stock.get(tile, 0) > 0, tile))
        named = ", ".join(f"{tile_name(tile)} ({_where(tile, snapshot, coming)})" for tile in kinds[:MOST_NAMED])
        more = f" and {len(kinds) - MOST_NAMED} more kinds" if len(kinds) > MOST_NAMED else ""
        yield f"{layout.station_name(station)} starves for {named}{more}"
    if len(starving) > MOST_NAMED:
        yield f"{len(starving) - MOST_NAMED} more word stations starve"


def _where(tile: int, snapshot: Snapshot, coming: Mapping[int, int]) -> str:
    """Where a kind of letter is."""
    holders = [bucket for bucket, content in enumerate(snapshot.contents) if content.get(tile, 0) > 0]
    if holders:
        resting = sum(snapshot.buckets.bot[bucket] < 0 for bucket in holders)
        return f"in {len(holders)} buckets, {resting} of them at rest"
    return "on a letter station" if coming.get(tile, 0) else "nowhere"
