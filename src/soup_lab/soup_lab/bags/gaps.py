"""Whether all messages of a topic came, judged by the numbers that DDS gives them."""

from __future__ import annotations


class Gaps:
    """Follows the numbers of the messages on one topic.

    Each publisher numbers its messages 1, 2, 3 ..., and a message does not say whose it is. Complete ones form as many
    chains of consecutive numbers as there are publishers; each gap begins one more chain.
    """

    def __init__(self) -> None:
        """Nothing has come."""
        self._ends: dict[int, int] = {}  # number that a chain ends with -> how many chains do
        self._chains = 0

    def take(self, number: int) -> None:
        """A message came."""
        before = self._ends.get(number - 1, 0)
        if before > 1:
            self._ends[number - 1] = before - 1
        elif before:
            del self._ends[number - 1]
        else:
            self._chains += 1
        self._ends[number] = self._ends.get(number, 0) + 1

    def count(self, publishers: int) -> int:
        """How many gaps there were at least.

        Args:
            publishers: How many there have been.
        """
        return max(0, self._chains - publishers)
