"""How fast a run in one process is, and how its cost grows with the number of bots."""

from __future__ import annotations

import math
import resource
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from soup_lab.headless.pool import share_out
from soup_lab.headless.simulation import Headless
from soup_msgs_py.policies import Policies
from soup_sim.scenario_loader import Warehouse, load_warehouse

WARM_S = 60.0  # simulated seconds before the clock starts: bots are on their way
RUNS = 5  # after one in which kernels are compiled or loaded; whatever else the machine does only makes them slower


@dataclass(frozen=True)
class Measured:
    """How fast one scenario ran with one set of policies.

    Attributes:
        name: What ran.
        bots: How many bots.
        compile_s: Wall seconds by which a first run was slower than a second one: compiling or loading kernels.
        real_time_factor: Simulated seconds a wall second, with all kernels there.
        memory_mb: Most memory that the process ever had resident.
    """

    name: str
    bots: int
    compile_s: float
    real_time_factor: float
    memory_mb: float

    @property
    def cost(self) -> float:
        """Wall milliseconds a simulated second."""
        return 1000.0 / self.real_time_factor


def measure(name: str, scenario: Path, overrides: tuple[str, ...], policies: Policies, seconds: float) -> Measured:
    """Run a scenario in this process for some simulated seconds, a few times, and time it; the fastest counts."""
    warehouse = load_warehouse(scenario, overrides)
    first, *others = [_timed(warehouse, policies, seconds) for _ in range(1 + RUNS)]
    begun_s, wall_s = (min(times) for times in zip(*others, strict=True))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return Measured(name, warehouse.scenario.bots, max(0.0, sum(first) - begun_s - wall_s), seconds / wall_s, memory)


def _timed(warehouse: Warehouse, policies: Policies, seconds: float) -> tuple[float, float]:
    """Wall seconds until bots are on their way, and for the simulated `seconds` after that."""
    started = time.perf_counter()
    run = Headless(warehouse.world(1), policies, 1)
    run.run(WARM_S)
    begun = time.perf_counter()
    run.run(WARM_S + seconds)
    return begun - started, time.perf_counter() - begun


def measure_apart(*arguments: object) -> Measured:
    """The same in a process of its own, so that memory is that of one run."""
    [(_, measured)] = share_out(measure, [arguments])
    return measured


def at_constant_density(bots: int) -> tuple[str, ...]:
    """Overrides of paper.yaml that scale everything with the number of bots."""
    size = math.sqrt(bots / 250.0)
    return (
        f"floor={{width_m: {250.0 * size:.1f}, height_m: {350.0 * size:.1f}}}",
        f"bots={bots}",
        f"buckets={round(3.4 * bots)}",
        f"word_stations={bots // 10}",
        f"letter_stations={bots // 10}",
    )


def growth(measured: Iterable[Measured]) -> list[float]:
    """Cost relative to n log n, the first one being 1; no worse than n log n where it does not rise."""
    scaled = [one.cost / (one.bots * math.log(one.bots)) for one in measured]
    return [value / scaled[0] for value in scaled]
