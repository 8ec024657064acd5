"""The program behind `scripts/benchmark.py`: speeds, where they belong; tests never assert a time."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console
from rich.table import Table

from soup_lab.engine_benchmark import at_constant_density, growth, measure_apart
from soup_msgs_py import arguments as args
from soup_msgs_py.policies import load_policies
from soup_sim.summary import write_summary

ROOT = Path(__file__).resolve().parents[3]
SCENARIOS = ROOT / "config/scenarios"
FLEETS = (125, 250, 500, 1000)


def main(argv: list[str] | None = None) -> int:
    """Measure what the command line names; the exit status."""
    parser = args.Parser("Measure how fast the warehouse runs in one process, on one core.")
    parser.add_argument("what", choices=["engine"], help="engine: paper.yaml and large.yaml with minimal policies")
    parser.add_argument("--seconds", type=args.positive, default=300.0, metavar="S", help="simulated seconds a run")
    parser.add_argument("--summary", type=args.output_file, metavar="FILE", help="write the figures as JSON")
    options = parser.parse_args(argv)
    policies = load_policies(ROOT / "config/policies/minimal.yaml")
    paper, large = SCENARIOS / "paper.yaml", SCENARIOS / "large.yaml"
    console = Console(width=max(Console().width, 110))  # a file or pipe is as wide as the table needs
    runs = [("paper.yaml", paper, ()), ("large.yaml", large, ())]
    runs += [(f"paper.yaml with {n} bots", paper, at_constant_density(n)) for n in FLEETS]
    measured = []
    with console.status("measuring"):
        for name, scenario, overrides in runs:
            measured.append(measure_apart(name, scenario, overrides, policies, options.seconds))
    scaled = [None, None, *growth(measured[2:])]
    shown = Table("run", "bots", "compile and load s", "real-time factor", "ms a sim s", "cost / n log n", "memory MB")
    for one, relative in zip(measured, scaled, strict=True):
        shown.add_row(
            one.name, str(one.bots), f"{one.compile_s:.1f}", f"{one.real_time_factor:.0f}", f"{one.cost:.2f}",
            "" if relative is None else f"{relative:.2f}", f"{one.memory_mb:.0f}",
        )  # fmt: skip
    console.print(shown)
    if options.summary is not None:
        figures = [{**vars(one), "cost_relative_to_n_log_n": r} for one, r in zip(measured, scaled, strict=True)]
        write_summary(options.summary, json.loads(json.dumps({"engine": figures})))
    return 0
