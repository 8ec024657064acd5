"""The ROS domain that this process is in."""

from __future__ import annotations

import os
from collections.abc import Mapping

from soup_msgs_py.errors import InputError

VARIABLE = "ROS_DOMAIN_ID"
HIGHEST = 232  # the ports of higher ones would be beyond 65535


def domain_id(environment: Mapping[str, str] = os.environ) -> int:
    """The number that the environment gives, 0 without one.

    Raises:
        InputError: It gives something else.
    """
    text = environment.get(VARIABLE) or "0"
    if not (text.isascii() and text.isdecimal() and int(text) <= HIGHEST):
        raise InputError(VARIABLE, "", text, f"a whole number from 0 to {HIGHEST}")
    return int(text)
