"""Command-line arguments that several programs share; a wrong one is told in one line, exit status 2."""

from __future__ import annotations

import argparse
import math
import os
import re
import socket
import sys
from pathlib import Path
from typing import Any, NoReturn

from soup_msgs_py.command_line.output_files import LONGEST_NAME, why
from soup_msgs_py.errors import InputError, printable
from soup_msgs_py.policies import NAMES

MOST_BOTS = 100_000
LONGEST_MESSAGE = 1_000  # characters
LONGEST_RUN_S = 1e9  # some thirty years; ROS counts seconds up to 2**31
BAG_FILE = "_0000.mcap"  # what comes after the name of a bag's folder in those of its files
PAGE_PORT = 8080
EVERY = "simulated seconds between two checkpoints (default: 10 seconds of wall time)"
SPEED = "simulated seconds per second of wall time, or max (default: 1)"


class Parser(argparse.ArgumentParser):
    """The parser of the standard library, but an error is one line."""

    def __init__(self, description: str) -> None:
        """Make a parser that knows no option yet.

        Args:
            description: What the program does.
        """
        super().__init__(description=description, allow_abbrev=False)

    def error(self, message: str) -> NoReturn:
        """Print the line and exit."""
        print(f"{self.prog}: {printable(message.removeprefix('argument '), LONGEST_MESSAGE)}", file=sys.stderr)
        sys.exit(2)

    def parse_known_args(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, args: Any = None, namespace: Any = None
    ) -> Any:
        """Parse as ever, but refuse a value that the standard library stumbles over."""
        for argument in sys.argv[1:] if args is None else args:
            option, _, value = argument.partition("=")
            if value == "--" and option.startswith("--"):
                self.error(f"{option}: found '--'; allowed: a value")
        return super().parse_known_args(args, namespace)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def positive(text: str) -> float:
    """A number above 0."""
    value = _number(text)
    if not (value > 0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"found {text!r}; allowed: a number above 0")
    return value


def seconds(text: str) -> float:
    """A simulated time above 0 (s)."""
    value = positive(text)
    if value > LONGEST_RUN_S:
        raise argparse.ArgumentTypeError(f"found {text!r}; allowed: a number above 0, up to {LONGEST_RUN_S:g}")
    return value


def not_negative(text: str) -> float:
    """A number from 0."""
    value = _number(text)
    if not (value >= 0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"found {text!r}; allowed: a number from 0")
    return value


def _whole(text: str, least: int, most: int) -> int:
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if not least <= value <= most:
        raise argparse.ArgumentTypeError(f"found {text!r}; allowed: a whole number from {least} to {most}")
    return value


def seed(text: str) -> int:
    """The seed of the random numbers."""
    return _whole(text, 0, 2**63 - 1)


def port(text: str) -> int:
    """A TCP port that needs no privilege."""
    return _whole(text, 1024, 65535)


def processes(text: str) -> int:
    """A number of processes."""
    return _whole(text, 1, 256)


def replications(text: str) -> int:
    """A number of runs."""
    return _whole(text, 1, 10_000)


def output_file(text: str) -> Path:
    """A file to write: its folder exists and can be written, and it is no folder itself."""
    path = _new_path(text)
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f"found no folder {path.parent}; allowed: a file in a folder that exists")
    pipe = path.exists() and not path.is_file()  # or a device: nothing is made beside it
    if path.is_dir() or not os.access(path if pipe else path.parent, os.W_OK):
        raise argparse.ArgumentTypeError(f"found {text!r}; allowed: a file that can be written")
    return path


def bag_folder(text: str) -> Path:
    """The folder of a bag, whose files are called after it."""
    return _new_path(text, BAG_FILE)


def _new_path(text: str, end: str = "") -> Path:
    """A path that the system can take, also with something at its end."""
    path = Path(text).absolute()
    longest = LONGEST_NAME - len(end)
    allowed = f"a name of at most {longest} bytes, in a folder that exists"
    try:
        if len(os.fsencode(path.name)) <= longest:
            path.is_dir()
            return path
        found = f"a name of {len(os.fsencode(path.name)):,} bytes"
    except OSError as error:
        found = f"a path of {len(os.fsencode(path)):,} bytes ({why(error)})"
    raise argparse.ArgumentTypeError(f"found {found}; allowed: {allowed}")


def bots(text: str) -> tuple[int, ...]:
    """Numbers of bots as ranges and lists, for instance `0-5,8`."""
    numbers: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.partition("-")
        if not (first.isdecimal() and (last.isdecimal() or not dash)):
            raise argparse.ArgumentTypeError(f"found {text!r}; allowed: ranges and lists of bots, for instance 0-5,8")
        low, high = int(first), int(last or first)
        if not low <= high < MOST_BOTS:
            raise argparse.ArgumentTypeError(f"found {part!r}; allowed: rising numbers below {MOST_BOTS}")
        numbers.update(range(low, high + 1))
    return tuple(sorted(numbers))


def written_bots(numbers: tuple[int, ...]) -> str:
    """Numbers of bots as `bots` reads them."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][1] + 1:
            parts[-1][1] = number
        else:
            parts.append([number, number])
    return ",".join(f"{low}-{high}" if low < high else str(low) for low, high in parts)


def pattern(text: str) -> re.Pattern[str]:
    """A regular expression."""
    try:
        return re.compile(text)
    except re.error as error:
        raise argparse.ArgumentTypeError(f"found {text!r} ({error}); allowed: a regular expression") from error


def add_scenario(parser: Parser, default: Path | None) -> None:
    """Add `--scenario` and `--set`."""
    help_ = f"the warehouse: a scenario, or a world of cells ({_usual(default)})"
    parser.add_argument("--scenario", type=Path, default=default, required=default is None, metavar="FILE", help=help_)
    help_ = "override one value of the scenario, for instance bots=8 or bucket.capacity=20; can be given again"
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=help_)


def _usual(file: Path | None) -> str:
    return f"default: {file.name}" if file is not None else "no default"


def add_run(parser: Parser, ends: str = "until Ctrl-C") -> None:
    """Add what says how long, how fast and how a run goes.

    Args:
        parser: The parser.
        ends: When a run ends that is given no duration.
    """
    parser.add_argument("--duration", type=seconds, metavar="S", help=f"simulated seconds (default: {ends})")
    help_ = "simulated seconds at its start that are not counted (default: 0)"
    parser.add_argument("--warmup", type=not_negative, default=0.0, metavar="S", help=help_)
    _add_seed(parser, "of all random numbers")
    parser.add_argument("--summary", type=output_file, metavar="FILE", help="write the figures of the run as JSON")
    parser.add_argument("--event-log", type=output_file, metavar="FILE", help="write all events as JSON lines")


def _add_seed(parser: Parser, of: str) -> None:
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help=f"{of} (default: 0)")


def add_explain(parser: Parser) -> None:
    """Add `--explain`."""
    parser.add_argument("--explain", type=output_file, metavar="FILE", help="write all decisions as JSON lines")


def folder(text: str) -> Path:
    """A folder to write to; it is made where there is none."""
    path = _new_path(text)
    try:
        path.mkdir(exist_ok=True)
    except OSError as error:
        raise argparse.ArgumentTypeError(f"found {text!r} ({why(error)}); allowed: a folder") from error
    if not os.access(path, os.W_OK):
        raise argparse.ArgumentTypeError(f"found {text!r}; allowed: a folder that can be written to")
    return path


def add_checkpoint(parser: Parser) -> None:
    """Add what keeps the state of a world."""
    parser.add_argument("--checkpoint", type=folder, metavar="DIR", help="keep the world's newest checkpoint there")
    parser.add_argument("--every", type=seconds, metavar="S", help=EVERY)
    parser.add_argument("--restore", action="store_true", help="go on from the checkpoint in DIR, if there is one")


def check_checkpoint(parser: Parser, arguments: argparse.Namespace) -> None:
    """Refuse options for checkpoints that nobody keeps."""
    if arguments.checkpoint is None and (arguments.every is not None or arguments.restore):
        name = "--restore" if arguments.restore else "--every"
        parser.error(f"{name}: found no --checkpoint; allowed: together with --checkpoint DIR")


def speed(text: str) -> float:
    """A real-time factor; infinity for `max`."""
    value = math.inf if text == "max" else _number(text)
    if not value > 0 or (math.isinf(value) and text != "max"):
        raise argparse.ArgumentTypeError(f"found {text!r}; allowed: a number above 0, or max")
    return value


def add_speed(parser: Parser) -> None:
    """Add `--speed`."""
    parser.add_argument("--speed", type=speed, default=1.0, metavar="RTF", help=SPEED)


def check_run(parser: Parser, arguments: argparse.Namespace) -> None:
    """Refuse a warm-up that leaves nothing to count."""
    if arguments.duration is not None and arguments.warmup >= arguments.duration:
        parser.error(f"--warmup: found {arguments.warmup:g}; allowed: less than --duration {arguments.duration:g}")


def add_policies(parser: Parser, default: Path | None, roles: tuple[str, ...], usual: Path | None = None) -> None:
    """Add `--policies` and an override for each role.

    Args:
        parser: The parser.
        default: The policies file where none is named.
        roles: Whose policies.
        usual: What is taken in the end where there is no default, for the help.
    """
    help_ = f"a policy for each role ({_usual(default or usual)})"
    parser.add_argument("--policies", type=Path, default=default, metavar="FILE", help=help_)
    for role in roles:
        parser.add_argument(f"--{role}-policy", metavar="POLICY", help=f"another {role} policy: {policy_names(role)}")


def add_policy(parser: Parser, role: str, policies: Path | None) -> None:
    """Add what says which policy a part follows.

    Args:
        parser: The parser.
        role: Of the part.
        policies: The policies file where none is named.
    """
    help_ = f"the {role} policy: {policy_names(role)} (default: what the policies file says)"
    parser.add_argument("--policy", metavar="POLICY", help=help_)
    help_ = f"where policies are named ({_usual(policies)})"
    parser.add_argument("--policies", type=Path, default=policies, metavar="FILE", help=help_)
    _add_seed(parser, "of the random numbers of the policy")


def policy_names(role: str) -> str:
    """What `--policy` may be."""
    return f"{', '.join(NAMES[role])}, or FILE.py:Class"


def add_port(parser: Parser) -> None:
    """Add `--port`."""
    help_ = f"of the page, on 127.0.0.1 (default: {PAGE_PORT})"
    parser.add_argument("--port", type=port, default=PAGE_PORT, metavar="N", help=help_)


def add_live_only(parser: Parser) -> None:
    """Accept what only a live run needs, so that a command line can be moved from one to the other."""
    help_ = "of no effect in one process"
    parser.add_argument("--speed", type=speed, metavar="RTF", help=help_)
    parser.add_argument("--bot-processes", type=processes, metavar="N", help=help_)
    parser.add_argument("--no-dashboard", action="store_true", help=help_)
    parser.add_argument("--port", type=port, metavar="N", help=help_)


def refuse_port_in_use(port: int) -> None:
    """Make sure that a server on this machine can have its port.

    Raises:
        InputError: Another program has it.
    """
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError as error:
            raise InputError("--port", "", f"port {port} in use", "a free port") from error
