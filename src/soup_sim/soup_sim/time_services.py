"""Time as anybody may ask for it: services of the world that pause it, step it, and set its speed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from soup_msgs import srv
from std_srvs.srv import SetBool

from soup_live.process import Live
from soup_live.services import Answer, serve
from soup_msgs_py import topics
from soup_msgs_py.codes import Code
from soup_msgs_py.wire import fill_result
from soup_sim.pacing import Pacer
from soup_sim.world import World

LONGEST_STEP_S = 3600.0


class TimeServices:
    """What is asked of the pace of a world, and answered.

    Args:
        live: The process.
        node: The node `world`.
        world: The world whose time it is.
        pacer: How fast it runs.
        catch_up: Called before time changes its pace: the world goes on to the present.
        changed: Called when the speed has changed.
    """

    def __init__(
        self,
        live: Live,
        node: Any,
        world: World,
        pacer: Pacer,
        catch_up: Callable[[], None],
        changed: Callable[[], None],
    ) -> None:
        """Begin to serve."""
        self._world, self._pacer = world, pacer
        self._catch_up, self._changed = catch_up, changed
        self._steps: list[Answer] = []
        serve(live, node, SetBool, topics.PAUSE, self._on_pause)
        serve(live, node, srv.Step, topics.STEP, self._on_step)
        serve(live, node, srv.SetSpeed, topics.SET_SPEED, self._on_set_speed)

    def answer_steps(self) -> None:
        """Tell who asked for a step that it is done."""
        if self._steps and self._pacer.paused:
            for answer in self._steps:
                answer.give(fill_result(srv.Step.Response(), Code.DONE, f"it is {self._world.now:g} s now"))
            self._steps.clear()

    def _on_pause(self, request: SetBool.Request, answer: Answer) -> None:
        self._catch_up()
        self._pacer.pause(request.data)
        state = "stands" if request.data else "goes on"
        answer.give(SetBool.Response(success=True, message=f"time {state} at {self._world.now:g} s"))

    def _on_step(self, request: srv.Step.Request, answer: Answer) -> None:
        if not self._pacer.paused:
            why = "the world is not paused; call /world/pause first"
            answer.give(fill_result(srv.Step.Response(), Code.MOVING, why))
        elif not 0.0 < request.seconds <= LONGEST_STEP_S:
            why = f"found {request.seconds:g} s; allowed: above 0, at most {LONGEST_STEP_S:g}"
            answer.give(fill_result(srv.Step.Response(), Code.INVALID, why))
        else:
            self._pacer.step(self._world.now, request.seconds)
            self._steps.append(answer)

    def _on_set_speed(self, request: srv.SetSpeed.Request, answer: Answer) -> None:
        self._catch_up()
        factor = request.real_time_factor
        if not factor > 0.0:
            why = f"found a real-time factor of {factor:g}; allowed: a number above 0, inf for no limit"
            answer.give(fill_result(srv.SetSpeed.Response(), Code.INVALID, why))
            return
        self._pacer.speed = factor
        self._changed()
        answer.give(fill_result(srv.SetSpeed.Response(), Code.DONE, f"the real-time factor is {factor:g}"))
