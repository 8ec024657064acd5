"""The command lines of single parts. They load nothing that takes long: help comes at once."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from soup_msgs_py.command_line import arguments as args


def parse_world(argv: Sequence[str] | None, scenario: Path | None = None) -> argparse.Namespace:
    """Read the command line of the world.

    Args:
        argv: The arguments; None for those of this process.
        scenario: The scenario where the command line names none.
    """
    parser = args.Parser("Run the world of a warehouse: physics, stations, orders.")
    args.add_scenario(parser, scenario)
    args.add_run(parser)
    args.add_speed(parser)
    args.add_checkpoint(parser)
    parser.add_argument("--paused", action="store_true", help="time stands until /world/pause is called")
    options = parser.parse_args(argv)
    args.check_run(parser, options)
    args.check_checkpoint(parser, options)
    return options


def parse_bots(argv: Sequence[str] | None, policies: Path | None = None) -> argparse.Namespace:
    """Read the command line of some bots.

    Args:
        argv: The arguments; None for those of this process.
        policies: The policies file where the command line names none.
    """
    parser = args.Parser("Run bucketbots, each its own ROS node, in one process.")
    parser.add_argument("bots", type=args.bots, help="which, for instance 0-19 or 0-5,8")
    args.add_policy(parser, "bot", policies)
    return parser.parse_args(argv)


def parse_manager(argv: Sequence[str] | None, role: str, policies: Path | None = None) -> argparse.Namespace:
    """Read the command line of a manager.

    Args:
        argv: The arguments; None for those of this process.
        role: word, letter or fleet.
        policies: The policies file where the command line names none.
    """
    parser = args.Parser(f"Run the {role} manager.")
    args.add_policy(parser, role, policies)
    args.add_explain(parser)
    help_ = f"ask the {role} manager that is in charge to hand over (default: stand by until it is gone)"
    parser.add_argument("--take-over", action="store_true", help=help_)
    parser.add_argument("--stand-by", action="store_true", help="do not take over, whatever else is said")
    return parser.parse_args(argv)


def parse_dashboard(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line of the browser page."""
    parser = args.Parser("Run the browser page of a live warehouse.")
    args.add_port(parser)
    return parser.parse_args(argv)
