"""QoS profiles. Publishers and subscribers of a topic share one, so that all are compatible."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

# The newest message is kept for newcomers.
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Followers of who is in charge: claims of several that come at once, their own among them, must not push each other
# out.
CLAIMS = QoSProfile(depth=20, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# What every process with bots speaks for.
CHARGES = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# None may be lost: events, requests, replies. Deep enough for the bursts of hundreds of bots.
EVERY_ONE = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.RELIABLE)
# Targets of one bot, and what it is asked. Reliable, as the teleoperation programs publish it; there are so many of
# these that deeper ones would cost a megabyte a bot.
COMMANDS = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
# Poses, clock, figures: only the newest counts. Reliable, so that any subscriber fits.
DISPLAY = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
# Their publishers keep some: a recorder that is late for a moment still gets each.
SHOWN = QoSProfile(depth=30, reliability=ReliabilityPolicy.RELIABLE)
# The same where newcomers get the newest.
SHOWN_LATCHED = QoSProfile(depth=4, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Subscribers of those take what comes and never hold the publisher up.
WATCH = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
