"""Doing things by hand in a world: putting bots somewhere, asking for something and waiting for the answer."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from soup_msgs_py import messages as m
from soup_msgs_py.codes import Code, EventType
from soup_sim.world import World


@contextmanager
def changed(world: World) -> Iterator[dict[str, Any]]:
    """The state of a world as a checkpoint has it; what one makes of it is true afterwards."""
    state = world.capture()
    yield state
    world.restore(state)


def place(world: World, **where: tuple[float, float]) -> None:
    """Put bots somewhere: `bot_3=(x, y)`."""
    with changed(world) as state:
        for name, xy in where.items():
            state["bodies"]["_state"][int(name.removeprefix("bot_"))][1:3] = xy


def clear(world: World) -> None:
    """Put all bots out of the way, along the lower edge."""
    place(world, **{f"bot_{k}": (2.0 + 2.0 * k, 1.0) for k in range(world.scenario.bots)})


def do(world: World, request, wait_s: float = 60.0) -> m.BotReply:
    """Ask the world and wait for its answer."""
    said = world.handle(request)
    if not any(isinstance(s, m.BotReply) for s in said):
        said += world.advance(world.now + wait_s, pause=True)
        while not any(isinstance(s, m.BotReply) and s.request == request.request for s in said):
            said += world.advance(world.now + wait_s, pause=True)
    return next(s for s in said if isinstance(s, m.BotReply))


def bucket_at_hand(world: World, bot: int, bucket: int) -> tuple[float, float]:
    """Put a bot under a bucket; where that is."""
    clear(world)
    buckets = world.buckets()
    x, y = float(buckets.x[bucket]), float(buckets.y[bucket])
    place(world, **{f"bot_{bot}": (x, y)})
    return x, y


def codes(said) -> list[Code]:
    """How a manager's requests ended."""
    return [s.code for s in said if isinstance(s, m.Reply)]


def types(said) -> list[EventType]:
    return [s.type for s in said if isinstance(s, m.Event)]


def loaded_at(world: World, station: int, bot: int = 0, bucket: int = 3) -> None:
    """Put a bot with a bucket on a station."""
    bucket_at_hand(world, bot, bucket)
    assert do(world, m.Grab(bot, 1)).success
    place(world, **{f"bot_{bot}": world.layout.station_xy(station)})
