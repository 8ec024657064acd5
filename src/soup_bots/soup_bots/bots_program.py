"""The program behind `scripts/run_bots.py`: some bucketbots, each its own node, in one process."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from soup_bots.bot_host import run_bots
from soup_live.process import exit_status
from soup_msgs_py.command_line.part_arguments import parse_bots
from soup_msgs_py.policies import load_policies


def main(argv: Sequence[str] | None = None, *, policies: Path | None = None) -> int:
    """Run some bucketbots in this process; its exit status."""
    options = parse_bots(argv, policies)

    def run() -> None:
        choice = load_policies(options.policies, {"bot": options.policy}).bot
        run_bots(options.bots, choice, options.seed)

    return exit_status(run)


if __name__ == "__main__":
    sys.exit(main())
