"""What the parts of the warehouse say to each other: frozen dataclasses, the same in one process and on the wire.

Times are simulated seconds, positions metres in frame `map` (x right, y up), angles radians. A number that means
nothing in a message is -1. Tile kinds are numbered as in `tiles`, stations as in `layout`.

CONTRIBUTING.md says how a new message is added.
"""

from soup_msgs_py.messages.base import Floats as Floats
from soup_msgs_py.messages.base import Ints as Ints
from soup_msgs_py.messages.base import Point as Point
from soup_msgs_py.messages.lockstep import *
from soup_msgs_py.messages.requests import *
from soup_msgs_py.messages.tasks import *
from soup_msgs_py.messages.trips import *
from soup_msgs_py.messages.world import *
