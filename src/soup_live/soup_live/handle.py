"""What a script has asked of a warehouse: while it is done, and how it ended."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from soup_msgs_py.codes import Code
from soup_msgs_py.errors import RunError


class Refused(RunError):
    """What was asked for was not done.

    Attributes:
        code: Why, for a program.
    """

    def __init__(self, what: str, code: Code, message: str) -> None:
        """Say it in one line: what was asked for, and the sentence of who was asked."""
        self.code = code
        super().__init__(f"{what}: {code}: {message}")


class Handle:
    """One thing that was asked for.

    Attributes:
        what: In words, for instance `bot 3 drives to (4.0, 5.0)`.
        feedback: The newest that was told of it, as its .action file says; None before, and for services.
        news: Whether nobody has looked at it yet.
        code: How it ended; None until then.
        message: The sentence that came with the end.
    """

    def __init__(self, what: str, cancel: Callable[[], object] | None = None) -> None:
        """Begin to wait for the end.

        Args:
            what: Was asked for.
            cancel: Asks that it ends early; None where it is done in a moment and cannot.
        """
        self.what = what
        self.feedback: Any = None
        self.news = False
        self.code: Code | None = None
        self.message = ""
        self._cancel = cancel

    def __repr__(self) -> str:
        """What was asked for, and how it is."""
        return f"<{self.what}: {self.code or 'under way'}>"

    @property
    def done(self) -> bool:
        """Whether it has ended, well or not."""
        return self.code is not None

    @property
    def succeeded(self) -> bool:
        """Whether it has ended well."""
        return self.code is Code.DONE

    def cancel(self) -> None:
        """Ask that it ends early; it ends as `cancelled` then, unless it is faster. A service cannot be cancelled."""
        if self._cancel is not None and not self.done:
            self._cancel()

    def check(self) -> None:
        """Make sure that it did not end in vain.

        Raises:
            Refused: It did.
        """
        if self.code is not None and not self.succeeded:
            raise Refused(self.what, self.code, self.message)

    def tell(self, feedback: Any) -> None:
        """Somebody tells how far it is."""
        self.feedback, self.news = feedback, True

    def end(self, code: Code, message: str) -> None:
        """It has ended."""
        self.code, self.message = code, message
