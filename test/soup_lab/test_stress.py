"""Random warehouses whose bots die and come back: nobody ever touches anybody, and work never stands still for long."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from soup_lab.headless.simulation import Headless
from soup_managers.fleets.coordinated.fleet import CoordinatedFleet
from soup_msgs_py import messages as m
from soup_msgs_py.codes import BotState, EventType
from soup_msgs_py.policies import load_policies
from soup_sim.scenario_loader import load_warehouse
from soup_sim.validate import Judge

CONFIG = Path(__file__).resolve().parents[2] / "config"
LONGEST_S = 60.0  # simulated: nothing useful happens for longer only where nothing can
WORK = frozenset({EventType.GRABBED, EventType.RELEASED, EventType.TRANSFERRED})
COLLISIONS = frozenset({EventType.BOT_COLLISION, EventType.BUCKET_COLLISION})


class Stress:
    """A run that is watched."""

    def __init__(self, overrides: list[str], seed: int) -> None:
        warehouse = load_warehouse(CONFIG / "scenarios/demo.yaml", overrides)
        world = warehouse.world(seed)
        self.scenario, self.layout = warehouse.scenario, warehouse.layout
        self.judge = Judge(warehouse.scenario, warehouse.layout, world.snapshot())
        self.worked_at = 0.0
        self.collisions = 0
        self.run = Headless(world, load_policies(CONFIG / "policies/best.yaml", {}), seed, self._on_event)
        fleet = self.run.fleet
        assert isinstance(fleet, CoordinatedFleet)
        self.fleet = fleet

    def _on_event(self, event: m.Event) -> None:
        self.judge.event(event)
        self.collisions += event.type in COLLISIONS
        if event.type in WORK:
            self.worked_at = event.time

    def go_on(self, seconds: float, *, must_work: bool) -> None:
        """Run on; fails where two touch, or where nobody works though somebody must."""
        world = self.run.world
        end = world.now + seconds
        while world.now < end:
            self.run.run(min(end, world.now + 5.0))
            self.judge.poses(world.bots(), world.buckets())
            assert self.collisions == 0
            if must_work:
                assert world.now - self.worked_at <= LONGEST_S, self.why()
            else:
                self.worked_at = world.now
        assert self.judge.count == 0

    def why(self) -> str:
        """What everybody waits for."""
        bots = [f"{r.number}: {r.activity.value} {r.purpose.value} {r.note}" for r in self.fleet.state.robots]
        return "\n".join([*bots, *(task.message for task in self.fleet.tasks())])


LAYOUTS = {
    "rows": "layout={kind: rows, pitch_m: 1.5, block_columns: 2, block_rows: 4, aisle_lanes: 2, margin_columns: 3}",
    "one lane": "layout={kind: rows, pitch_m: 1.5, block_columns: 2, block_rows: 3, aisle_lanes: 1, margin_columns: 2}",
    "dense": "layout={kind: dense, pitch_m: 1.5, block_columns: 4, block_rows: 4, aisle_lanes: 2, margin_columns: 3}",
    "hexagonal": "layout={kind: hexagonal, pitch_m: 1.5, block_rows: 5, aisle_lanes: 2, margin_columns: 3}",
}
deaths = st.lists(
    st.tuples(
        st.floats(0.1, 40.0),  # how long after the last one (s)
        st.sets(st.integers(0, 11), min_size=1, max_size=4),  # who dies
        st.floats(0.5, 50.0),  # how long they are dead (s)
        st.booleans(),  # whether anybody is told
    ),
    min_size=1,
    max_size=4,
)


def stress(layout: str, seed: int, bots: int, fill: float, stations: tuple[int, int], dying: list) -> None:
    """Run a random warehouse, with bots that die and come back."""
    width, height = 34.0 + 4.0 * (seed % 4), 24.0 + 3.0 * (seed % 3)
    base = [
        f"floor={{width_m: {width}, height_m: {height}}}", LAYOUTS[layout],
        f"word_stations={stations[0]}", f"letter_stations={stations[1]}",
    ]  # fmt: skip
    spots = len(load_warehouse(CONFIG / "scenarios/demo.yaml", [*base, "bots=1", "buckets=4"]).layout.storage_spots)
    run = Stress([*base, f"bots={bots}", f"buckets={max(4, int(fill * spots))}"], seed)
    run.go_on(20.0, must_work=True)
    for after_s, who, dead_s, noticed in dying:
        run.go_on(after_s, must_work=True)
        who = [bot for bot in who if bot < bots]
        run.run.kill(who, noticed=noticed)
        run.go_on(dead_s, must_work=False)
        run.run.revive(who)
    run.go_on(200.0, must_work=True)
    states = run.run.world.bots().state
    assert (states != BotState.PENALISED).all()


@pytest.mark.parametrize("layout", LAYOUTS)
@settings(max_examples=12, derandomize=True, phases=(Phase.explicit, Phase.generate))  # shrinking takes for ever
@given(
    seed=st.integers(0, 10_000), bots=st.integers(1, 12), fill=st.floats(0.3, 0.85),
    stations=st.tuples(st.integers(1, 3), st.integers(1, 3)), dying=deaths,
)  # fmt: skip
def test_nobody_touches_anybody_and_work_goes_on_whoever_dies(layout, seed, bots, fill, stations, dying):
    stress(layout, seed, bots, fill, stations, dying)
