"""Services whose answers may come later than the callback returns, under any executor."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile

from soup_live.process import Live
from soup_live.qos import EVERY_ONE
from soup_msgs_py.codes import Code
from soup_msgs_py.wire import MalformedMessage, fill_result


class Answer:
    """The answer to a service call, given now or later, once."""

    def __init__(self, send: Callable[[Any, Any], None]) -> None:
        """Remember how to send it."""
        self._send = send
        self._header: Any = None
        self._response: Any = None

    def give(self, response: Any) -> None:
        """Send the response, as soon as the executor has told to whom."""
        self._response = response
        self._send_if_complete()

    def address(self, header: Any) -> None:
        """Learn from the executor to whom the answer goes."""
        self._header = header
        self._send_if_complete()

    def _send_if_complete(self) -> None:
        if self._response is None or self._header is None:
            return
        with contextlib.suppress(rclpy_implementation.RCLError):  # who asked is gone
            self._send(self._response, self._header)


def serve(
    live: Live,
    node: Node,
    kind: type,
    name: str,
    take: Callable[[Any, Answer], None],
    profile: QoSProfile = EVERY_ONE,
) -> None:
    """Offer a service whose answers may come later: `take` gets each request together with its `Answer`.

    The executor sends whatever the callback returns through the service's `send_response`. Here it returns
    the `Answer`, and `send_response` keeps who asked instead of sending.
    """

    def on_request(request: Any, response: Any) -> Answer:
        answer = Answer(send)
        try:
            take(request, answer)
        except MalformedMessage as error:
            live.drop(error)
            answer.give(fill_result(response, Code.INVALID, str(error)))
        return answer

    def keep(answer: Answer | None, header: Any) -> None:
        if answer is not None:
            answer.address(header)

    service: Any = node.create_service(kind, name, live.guard(on_request), qos_profile=profile)
    send = service.send_response
    service.send_response = keep
