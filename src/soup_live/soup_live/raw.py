"""Serialized messages together with the number that their publisher gave them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.type_support import check_for_type_support
from rclpy.waitable import NumberOfEntities, Waitable

from soup_live.process import Live

NUMBER = "publication_sequence_number"


class RawSubscription(Waitable):
    """A subscription that hands over bytes and numbers.

    The events executor of the wheels fails on callbacks that want to know more than the message (`null argument to
    internal routine`). It leaves waitables to themselves, so this one takes its messages itself.
    """

    def __init__(
        self,
        live: Live,
        node: Node,
        kind: type,
        topic: str,
        take: Callable[[bytes, int], None],
        profile: QoSProfile,
        events: SubscriptionEventCallbacks,
    ) -> None:
        """Begin to listen.

        Args:
            live: The process.
            node: The node that subscribes.
            kind: Class of the messages.
            topic: Name of the topic.
            take: Is given each serialized message and its number: 1, 2, 3 ... by publisher.
            profile: Quality of service.
            events: What else to be told.
        """
        super().__init__(node.default_callback_group)
        check_for_type_support(kind)  # loads it
        self._kind, self._take = kind, take
        self._guarded = live.guard(self._hand_over)
        self._waiting: deque[tuple[bytes, dict[str, int]]] = deque()
        with node.handle:
            self._handle = rclpy_implementation.Subscription(node.handle, kind, topic, profile.get_c_qos_profile())
        self._index: int | None = None
        node.add_waitable(self)
        for handler in events.create_event_handlers(node.default_callback_group, self._handle, topic):
            node.add_waitable(handler)

    def get_num_entities(self) -> NumberOfEntities:
        """One subscription."""
        return NumberOfEntities(1)

    def add_to_wait_set(self, wait_set: Any) -> None:
        """Tell the executor what to wait for."""
        self._index = wait_set.add_subscription(self._handle)

    def is_ready(self, wait_set: Any) -> bool:
        """Whether a message has come."""
        return wait_set.is_ready("subscription", self._index)

    def take_data(self) -> bool:
        """Take all messages that have come; whether any wait to be handed over.

        The executor calls once a message, but now and then before the message can be taken. One at a time, the newest
        would then always wait for the next one to come.
        """
        with self._handle:
            while (taken := self._handle.take_message(self._kind, True)) is not None:
                self._waiting.append(taken)
        return bool(self._waiting)

    async def execute(self, taken_data: bool) -> None:
        """Hand them over, in the order in which they were taken."""
        self._guarded()

    def take_rest(self) -> None:
        """Hand over what waits though nobody was called for it."""
        self.take_data()
        self._hand_over()

    def destroy(self) -> None:
        """Stop listening."""
        self._handle.destroy_when_not_in_use()

    def _hand_over(self) -> None:
        while self._waiting:
            cdr, info = self._waiting.popleft()
            self._take(cdr, info[NUMBER])
