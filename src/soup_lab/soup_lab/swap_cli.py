"""Swap one part of a live warehouse for another, in one go."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from soup_bots import bot_node
from soup_managers import fleet_manager_node, letter_manager_node, word_manager_node
from soup_msgs_py.arguments import Parser

MANAGERS = {
    "word": word_manager_node.main,
    "letter": letter_manager_node.main,
    "fleet": fleet_manager_node.main,
}


def main(argv: Sequence[str] | None = None, *, policies: Path | None = None) -> int:
    """Run the part that takes over, until a signal comes; the exit status.

    Where the one before was started by `run_warehouse.py`, it stands by then, and is in charge again afterwards.
    """
    parser = Parser(
        "Have a new part take over from the one that is running: as soon as it is ready, the old one hands over. It "
        "runs in this terminal until Ctrl-C. All other options are those of run_word_manager.py and its siblings, or "
        "of run_bots.py. Examples: swap_manager.py fleet --policy minimal; swap_manager.py 7 --policy evade."
    )
    parser.add_argument("part", metavar="word|letter|fleet|BOTS", help="which manager, or which bots: 7 or 0-19")
    options, further = parser.parse_known_args(argv)
    manager = MANAGERS.get(options.part)
    if manager is not None:
        return manager([*further, "--take-over"], policies=policies)
    if not options.part[0].isdecimal():
        parser.error(f"part: found {options.part!r}; allowed: word, letter, fleet, or bots like 0-5,8")
    return bot_node.main([options.part, *further], policies=policies)


if __name__ == "__main__":
    sys.exit(main())
