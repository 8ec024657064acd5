"""Swap one part of a live warehouse for another, in one go."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from soup_bots import bots_program
from soup_lab.lab_arguments import parse_swap
from soup_managers.nodes import fleet_manager_node, letter_manager_node, word_manager_node

MAINS = {
    "word": word_manager_node.main,
    "letter": letter_manager_node.main,
    "fleet": fleet_manager_node.main,
}


def main(argv: Sequence[str] | None = None, *, policies: Path | None = None) -> int:
    """Run the part that takes over, until a signal comes; the exit status.

    Where the one before was started by `run_warehouse.py`, it stands by then, and is in charge again afterwards.
    """
    part, further = parse_swap(argv, policies)
    return MAINS.get(part, bots_program.main)(further, policies=policies)


if __name__ == "__main__":
    sys.exit(main())
