"""What policies chose that cannot be: counted, and told to whoever wants to hear of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from soup_msgs_py.errors import printable

TOLD_AT = tuple(10**k for k in range(10))  # how often it has happened when it is told: at first, then ever more rarely


@dataclass
class Mistakes:
    """Decisions that nobody can carry out. Whoever asks the policy does as if it had decided nothing.

    Attributes:
        tell: Is told a line at the first mistake of a kind, and again when there are ten, a hundred ... of it.
        counts: How often each mistake was made, by a line that says by which policy, and what.
    """

    tell: Callable[[str], None] | None = None
    counts: dict[str, int] = field(default_factory=dict)

    def add(self, role: str, policy: object, what: str, chosen: object) -> None:
        """Note a mistake.

        Args:
            role: What the policy decides: word, letter, buckets ...
            policy: The policy.
            what: What is wrong with its choice; of the same kind the same words.
            chosen: The choice; told at the first time.
        """
        line = f"{role} policy {type(policy).__name__} chose {what}"
        count = self.counts[line] = self.counts.get(line, 0) + 1
        if self.tell is not None and count in TOLD_AT:
            self.tell(f"{line} ({printable(chosen)}){'' if count == 1 else f', {count} times by now'}")

    def lines(self) -> list[str]:
        """Each mistake, and how often it was made."""
        return [f"{line}: {count} times" for line, count in self.counts.items()]
