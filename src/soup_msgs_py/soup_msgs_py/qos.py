"""QoS profiles. Publishers and subscribers of a topic share one, so that all are compatible."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

# The newest message is kept for newcomers.
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# None may be lost: events, requests, replies. Deep enough for the bursts of hundreds of bots.
EVERY_ONE = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.RELIABLE)
# Targets of one bot. Reliable, as the teleoperation programs publish it.
COMMANDS = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
# Poses, clock, figures: only the newest counts. Reliable, so that any subscriber fits.
DISPLAY = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
# Subscribers of those take what comes and never hold the publisher up.
WATCH = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
