"""The command lines of what plans, compares, measures and tries. They load nothing that takes long."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from soup_managers.planners.plan import RULES
from soup_msgs_py.command_line import arguments as args
from soup_msgs_py.command_line.part_arguments import parse_bots, parse_manager
from soup_msgs_py.policies import MANAGERS

PLANNERS = ("optimal", "anytime", "multi-action", "single-action")  # said here, too, since to load them takes seconds
PICTURES = (".png", ".gif")
ENGINE, POLICIES, PLANNER = "engine", "policies", "planner"


def parse_plan(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line of the joint planner."""
    parser = args.Parser("Plan for all robots of a world at once: boxes to empty shelves, in as few steps as possible.")
    parser.add_argument("world", type=Path, metavar="WORLD.txt", help="@ robot, * box, | empty shelf, # full, _ floor")
    parser.add_argument("--planner", choices=PLANNERS, default="optimal", help="how to plan (default: optimal)")
    parser.add_argument(
        "--rules",
        choices=RULES,
        default="default",
        help="paper: no waiting, and no robot on a shelf at the end; fleet: no box is carried over another",
    )
    parser.add_argument(
        "--weight",
        type=args.not_negative,
        default=1.0,
        metavar="W",
        help="weight of the heuristic of the paper's planners (default: 1)",
    )
    parser.add_argument(
        "--time-limit", type=args.positive, default=60.0, metavar="S", help="wall seconds of search (default: 60)"
    )
    parser.add_argument("--summary", type=args.output_file, metavar="F", help="write the figures and the plan as JSON")
    parser.add_argument("--show", action="store_true", help="play the plan as text")
    parser.add_argument(
        "--picture", type=args.output_file, metavar="F", help="draw the paths (.png) or play the plan (.gif)"
    )
    options = parser.parse_args(argv)
    if options.picture is not None and options.picture.suffix not in PICTURES:
        parser.error(f"--picture: found {options.picture}; allowed: a name that ends in {' or '.join(PICTURES)}")
    if options.weight != 1.0 and options.planner not in ("single-action", "multi-action"):
        parser.error(f"--weight: found {options.weight:g} with {options.planner}; allowed: single-action, multi-action")
    return options


def parse_compare(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line of a sweep."""
    parser = args.Parser(
        "Compare policies: run all variants of an experiment; show confidence intervals and write a report."
    )
    parser.add_argument(
        "experiment", type=Path, metavar="EXPERIMENT.yaml", help="the experiment, as in config/experiments"
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder of the results (default: results/ and the name of the file)"
    )
    parser.add_argument(
        "--replications", type=args.replications, metavar="N", help="runs of each variant, each with its own seed"
    )
    parser.add_argument(
        "--processes", type=args.processes, metavar="N", help="runs at the same time (default: one for each core)"
    )
    parser.add_argument("--scheduler", metavar="ADDRESS", help="run on the dask cluster at this address")
    parsed = parser.parse_args(argv)
    if parsed.scheduler is not None and parsed.processes is not None:
        parser.error("--processes: found --scheduler too; allowed: one of them, a cluster has its own processes")
    parsed.out = parsed.out or Path("results") / parsed.experiment.stem
    return parsed


def parse_benchmark(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line of what measures speeds."""
    parser = args.Parser("Measure how fast the warehouse runs in one process, on one core.")
    parser.add_argument(
        "what",
        choices=[ENGINE, POLICIES, PLANNER],
        help="engine: paper.yaml, large.yaml and scaled versions of paper.yaml, with minimal policies; "
        "policies: both scenarios with minimal and with best policies; planner: the figures of the 2023 paper",
    )
    parser.add_argument(
        "--seconds", type=args.positive, default=300.0, metavar="S", help="simulated seconds of each run (default: 300)"
    )
    parser.add_argument("--summary", type=args.output_file, metavar="FILE", help="write the figures as JSON")
    parser.add_argument(
        "--time-limit",
        type=args.positive,
        default=60.0,
        metavar="S",
        help="planner: wall seconds of each search (default: 60)",
    )
    parser.add_argument("--picture", type=args.output_file, metavar="FILE", help="planner: draw plots (.png or .svg)")
    return parser.parse_args(argv)


def parse_chaos(argv: Sequence[str] | None, scripts: Path) -> argparse.Namespace:
    """Read the command line of chaos.

    Args:
        argv: The arguments; None for those of this process.
        scripts: The folder of the programs.
    """
    parser = args.Parser(
        "Run a warehouse and do to it whatever can happen: kill and restart managers, bots and the world, swap "
        "managers, stop processes for a while. Prints what was done and how long no word was completed after it."
    )
    parser.add_argument(
        "--minutes", type=args.positive, default=5.0, metavar="M", help="wall time in minutes (default: 5)"
    )
    parser.add_argument("--seed", type=args.seed, default=0, help="of what is done, and when (default: 0)")
    parser.add_argument("--scenario", type=Path, metavar="FILE", help="the scenario (default: the demo)")
    parser.add_argument("--policies", type=Path, metavar="FILE", help="the policies file (default: the best policies)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="override one scenario value")
    parser.add_argument(
        "--event-log", type=Path, metavar="FILE", help="write all events of the warehouse as JSON lines"
    )
    parser.add_argument("--record", type=Path, metavar="DIR", help="record all topics of the warehouse")
    args.add_speed(parser)
    parser.set_defaults(scripts=scripts)
    return parser.parse_args(argv)


def parse_swap(argv: Sequence[str] | None, policies: Path | None = None) -> tuple[str, list[str]]:
    """Read the command line of a swap: the role of a manager, or bots, and the command line of the part.

    Args:
        argv: The arguments; None for those of this process.
        policies: The policies file where the command line names none.
    """
    parser = args.Parser(
        "Have a new part take over from the one that is running: as soon as it is ready, the old one hands over. It "
        "runs in this terminal until Ctrl-C. All other options are those of run_word_manager.py and its siblings, or "
        "of run_bots.py. Examples: swap_manager.py fleet --policy minimal; swap_manager.py 7 --policy evade."
    )
    parser.add_argument("part", metavar="word|letter|fleet|BOTS", help="which manager, or which bots: 7 or 0-19")
    options, further = parser.parse_known_args(argv)
    if options.part in MANAGERS:
        further = [*further, "--take-over"]
        parse_manager(further, options.part, policies)
    elif options.part[:1].isdecimal():
        further = [options.part, *further]
        parse_bots(further, policies)
    else:
        parser.error(f"part: found {options.part!r}; allowed: word, letter, fleet, or bots like 0-5,8")
    return options.part, further


def parse_reference(argv: Sequence[str] | None, folder: Path) -> argparse.Namespace:
    """Read the command line of what writes the reference.

    Args:
        argv: The arguments; None for those of this process.
        folder: Of the documents.
    """
    parser = args.Parser("Write docs/reference from the models that the code works by.")
    parser.add_argument("--check", action="store_true", help="write nothing; status 1 if a document is out of date")
    parser.set_defaults(folder=folder)
    return parser.parse_args(argv)
