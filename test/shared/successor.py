"""A new manager in the place of one that has died: it knows nothing but what the world and the bots say."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from soup_lab.headless.simulation import Headless
from soup_msgs_py.codes import Code
from soup_msgs_py.messages import DELIVER, TaskResult, TaskState


def takes_over(run: Headless, role: str, mind: Any, tasks: Iterable[TaskState] = ()) -> None:
    """Put it in place, as the nodes do.

    Args:
        run: The run.
        role: As in `Headless.replace`.
        mind: The new manager.
        tasks: Of a fleet manager that has died; who asked for them learns that they will not be done.
    """
    now = run.world.now
    run.replace(role, mind)
    said = mind.handle(run.world.snapshot(), now)
    if role == "fleet":
        said += [answer for bot in run.crew.minds.values() for answer in mind.handle(bot._status(now), now)]
    run.say(mind, said)
    for task in tasks:
        manager = run.word if task.kind == DELIVER else run.letter
        run.tell(manager, TaskResult(task.kind, task.task, Code.STOPPED, "the fleet manager is gone"))
