"""Run the word manager. Needs nothing else to be running yet."""

import _environment

_environment.enter()

import sys
from functools import partial

from _command_line import POLICIES, start
from soup_msgs_py.command_line.part_arguments import parse_manager

if __name__ == "__main__":
    sys.exit(start("soup_managers.nodes.word_manager_node", partial(parse_manager, role="word"), policies=POLICIES))
