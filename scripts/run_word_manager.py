"""Run the word manager. Needs nothing else to be running yet."""

import _environment

_environment.enter()

import sys

from _command_line import POLICIES
from soup_managers.word_manager_node import main

if __name__ == "__main__":
    sys.exit(main(policies=POLICIES))
