"""A program of its own for a test: writes the number of the bot of every transfer, and every violation, to a file.

DDS keeps what a process first learned about discovery servers, so that the tests' own process cannot look on.
"""

from __future__ import annotations

import sys
from pathlib import Path

from soup_msgs import msg

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from live.person import Person

if __name__ == "__main__":
    with open(sys.argv[1], "a", buffering=1, encoding="utf-8") as file, Person() as person:

        def note(event: msg.Event) -> None:
            if event.type == "transferred":
                file.write(f"{event.bot}\n")

        def judge(figures: msg.Statistics) -> None:
            if figures.violations:
                file.write("violation\n")

        person.node.create_subscription(msg.Event, "/world/events", note, 1000)
        person.node.create_subscription(msg.Statistics, "/world/statistics", judge, 1)
        person.wait(lambda: False, "a signal ends this")
