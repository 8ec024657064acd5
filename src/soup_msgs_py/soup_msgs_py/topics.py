"""Names of everything in the live graph. Absolute, so that they do not depend on a node's namespace."""

from __future__ import annotations

WORLD_NODE = "world"
WORD_MANAGER_NODE = "word_manager"
LETTER_MANAGER_NODE = "letter_manager"
FLEET_MANAGER_NODE = "fleet_manager"
DASHBOARD_NODE = "dashboard"

# The world tells
CLOCK = "/clock"
SCENARIO = "/world/scenario"
SNAPSHOT = "/world/snapshot"
BOTS = "/world/bots"
BUCKETS = "/world/buckets"
STATIONS = "/world/stations"
EVENTS = "/world/events"
REPLIES = "/world/replies"
STATISTICS = "/world/statistics"
STATE = "/world/state"
MARKERS = "/visualization_marker_array"
DIAGNOSTICS = "/diagnostics"

# The world keeps the parts in step: it says that it has spoken, each says that it has heard
BEAT = "/world/beat"
HEARD = "/world/heard"
SENSED_BOTS = "/world/sensed/bots"
SENSED_BUCKETS = "/world/sensed/buckets"

# The world is asked
REQUESTS = "/world/requests"
PAUSE = "/world/pause"
STEP = "/world/step"
SET_SPEED = "/world/set_speed"
CHECKPOINT = "/world/checkpoint"
SEEK = "/world/seek"  # of a replay, which stands in for the world
ASSIGN_WORD = "/world/assign_word"
ASSIGN_BUNDLE = "/world/assign_bundle"
SET_STORAGE_SPOT = "/world/set_storage_spot"

# The fleet
DELIVER_LETTERS = "/fleet/deliver_letters"
STORE_BUNDLE = "/fleet/store_bundle"
TASKS = "/fleet/tasks"
ORDERS = "/fleet/orders"  # to all bots
OUTCOMES = "/fleet/outcomes"  # of orders
BOUND = "/fleet/bound"

# Who is in charge
CHARGE = "charge"  # of a manager, in its namespace
HAND_OVER = "hand_over"
BOTS_CHARGE = "/bots/charge"

FRAME = "map"


def of_manager(node: str, name: str) -> str:
    """A topic or service of a manager: `charge`, `hand_over`."""
    return f"/{node}/{name}"


def bot_node(bot: int) -> str:
    """Name of a bot's node and of its namespace, without the slash."""
    return f"bot_{bot}"


def bot_topic(bot: int, name: str) -> str:
    """A topic, service or action of one bot: `cmd_vel`, `path`, `status`, `grab`, ..."""
    return f"/{bot_node(bot)}/{name}"


CMD_VEL = "cmd_vel"
PATH = "path"
STATUS = "status"
GRAB = "grab"
RELEASE = "release"
TRANSFER = "transfer"
DRIVE = "drive"
TRIP = "trip"
