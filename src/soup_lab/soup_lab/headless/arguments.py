"""The command line of a run in one process. It loads nothing that takes long: help comes at once."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from soup_msgs_py.command_line import arguments as args
from soup_msgs_py.policies import ROLES, usual_policies

ROOT = Path(__file__).resolve().parents[4]
SCENARIO = ROOT / "config/scenarios/demo.yaml"
POLICIES = ROOT / "config/policies/best.yaml"
DEFAULT_DURATION_S = 3600.0


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = args.Parser("Run a warehouse in one process, as fast as the machine can.")
    args.add_scenario(parser, SCENARIO)
    args.add_policies(parser, None, ROLES, usual=POLICIES)
    args.add_run(parser, ends=f"{DEFAULT_DURATION_S:,.0f}")
    args.add_explain(parser)
    parser.add_argument(
        "--replications", type=args.replications, default=1, metavar="N",
        help="runs, each with the next seed, and their means (default: 1)",
    )  # fmt: skip
    parser.add_argument("--processes", type=args.processes, metavar="N", help="runs at once (default: one a core)")
    parser.add_argument("--from-bag", type=Path, metavar="DIR", help="run on from a moment of a bag: what if ...")
    parser.add_argument("--at", type=args.not_negative, metavar="S", help="that moment, in simulated seconds")
    args.add_live_only(parser)
    parsed = parser.parse_args(argv)
    if (parsed.from_bag is None) != (parsed.at is None):
        parser.error("--from-bag: found one of --from-bag and --at; allowed: both")
    if parsed.from_bag is not None:
        return _from_bag(parser, parsed)
    parsed.policies = parsed.policies or usual_policies(POLICIES, parsed.scenario)
    parsed.duration = parsed.duration or DEFAULT_DURATION_S
    args.check_run(parser, parsed)
    for name in ("event_log", "explain"):
        if parsed.replications > 1 and getattr(parsed, name) is not None:
            parser.error(f"--{name.replace('_', '-')}: found --replications above 1; allowed: one run")
    return parsed


def _from_bag(parser: args.Parser, parsed: argparse.Namespace) -> argparse.Namespace:
    """Check what goes together with a bag, which says itself what warehouse it is."""
    if parsed.set or parsed.scenario != SCENARIO or parsed.replications > 1 or parsed.warmup:
        parser.error("--from-bag: found --scenario, --set, --warmup or --replications; allowed: what the bag has")
    if parsed.duration is not None and parsed.duration <= parsed.at:
        parser.error(f"--duration: found {parsed.duration:g}; allowed: more than --at {parsed.at:g}")
    return parsed
