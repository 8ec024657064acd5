"""What the parts of a live warehouse have in common, loaded once, by the process from which they are forked.

Seven processes that each load ROS, numba and scipy by themselves need half a minute of two cores for it, and a
hundred megabytes more each.
"""

from __future__ import annotations

import gc

import soup_bots.bot_host
import soup_managers.nodes.fleet_manager_node
import soup_managers.nodes.letter_manager_node
import soup_managers.nodes.word_manager_node
import soup_sim.world_program

__all__ = ["soup_bots", "soup_managers", "soup_sim"]

gc.freeze()  # what is loaded stays where it is: the children share its memory
