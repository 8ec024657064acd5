"""The command line of a live warehouse. It loads nothing that takes long: help comes at once."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from soup_msgs_py.command_line import arguments as args
from soup_msgs_py.policies import ROLES, usual_policies


def parse(argv: Sequence[str] | None, scenario: Path | None = None, policies: Path | None = None) -> argparse.Namespace:
    """Read the command line.

    Args:
        argv: The arguments; None for those of this process.
        scenario: The scenario where the command line names none.
        policies: The policies file where the command line names none.
    """
    parser = args.Parser("Run a live warehouse: world, bots and managers as ROS 2 nodes in their own processes.")
    args.add_scenario(parser, scenario)
    args.add_policies(parser, None, ROLES, usual=policies)
    args.add_run(parser)
    args.add_explain(parser)
    args.add_speed(parser)
    parser.add_argument(
        "--bot-processes", type=args.processes, metavar="N",
        help="processes that share the bots (default: one for 64 bots, at most one a core)",
    )  # fmt: skip
    parser.add_argument("--no-dashboard", action="store_true", help="without the browser page")
    args.add_port(parser)
    help_ = "record all topics into a new rosbag2 bag"
    parser.add_argument("--record", type=args.bag_folder, metavar="DIR", help=help_)
    parser.add_argument("--overwrite", action="store_true", help="remove the bag that DIR holds; nothing but a bag")
    args.add_checkpoint(parser)
    options = parser.parse_args(argv)
    if options.policies is None and policies is not None:
        options.policies = usual_policies(policies, options.scenario)
    args.check_run(parser, options)
    if options.overwrite and options.record is None:
        parser.error("--overwrite: found no --record; allowed: together with --record DIR")
    args.check_checkpoint(parser, options)
    return options
