"""The command lines of programs for bags. They load nothing that takes long: help comes at once."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from soup_msgs_py.command_line import arguments as args

LEAST_FREE_MIB = 200.0


def parse_record(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line of the recorder."""
    parser = args.Parser("Record a live warehouse, or any ROS graph, into a rosbag2 bag (MCAP).")
    parser.add_argument("folder", type=args.bag_folder, metavar="DIR", help="the bag; it must not exist yet")
    parser.add_argument("--topics", type=args.pattern, metavar="REGEX", help="only topics whose whole name matches")
    parser.add_argument("--exclude", type=args.pattern, metavar="REGEX", help="no topics whose whole name matches")
    parser.add_argument("--compression", choices=("zstd", "none"), default="zstd", help="of the bag (default: zstd)")
    parser.add_argument(
        "--split-mib",
        type=args.positive,
        default=2048.0,
        metavar="MIB",
        help="begin a new file after this size (default: 2048)",
    )
    help_ = "begin a new file after so many wall seconds"
    parser.add_argument("--split-s", type=args.positive, metavar="S", help=help_)
    help_ = f"end before the disk has less room than this (default: {LEAST_FREE_MIB:g})"
    parser.add_argument("--leave-free-mib", type=args.positive, default=LEAST_FREE_MIB, metavar="MIB", help=help_)
    parser.add_argument("--go-on", action="store_true", help="continue in DIR if a recorder was killed there")
    return parser.parse_args(argv)


def parse_replay(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line of a replay."""
    parser = _reader("Replay a bag with its timing, as if the warehouse were running; /clock goes with it.")
    help_ = "how many times the recorded speed, or max (default: 1)"
    parser.add_argument("--speed", type=args.speed, default=1.0, metavar="X", help=help_)
    parser.add_argument("--start", type=args.not_negative, metavar="T", help="begin at this simulated second")
    parser.add_argument("--loop", action="store_true", help="begin again at the end")
    parser.add_argument("--paused", action="store_true", help="begin paused, until /world/pause is called")
    parser.add_argument("--topics", type=args.pattern, metavar="REGEX", help="only topics whose whole name matches")
    return parser.parse_args(argv)


def parse_summary(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line of what computes the figures of a bag."""
    parser = _reader("Compute the figures of a run from the events in its bag.")
    parser.add_argument("--compare", type=Path, metavar="JSON", help="show where the figures of this summary differ")
    parser.add_argument(
        "--warmup", type=args.not_negative, metavar="S", help="simulated seconds not counted (default: as in the run)"
    )
    parser.add_argument("--summary", type=args.output_file, metavar="FILE", help="write the figures as JSON")
    return parser.parse_args(argv)


def _reader(description: str) -> args.Parser:
    """The parser of a program that reads a bag."""
    parser = args.Parser(description)
    parser.add_argument("folder", type=Path, metavar="DIR", help="the bag")
    return parser
