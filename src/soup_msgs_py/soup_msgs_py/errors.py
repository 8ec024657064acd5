"""Errors that name what a person can mend."""

from __future__ import annotations


class InputError(ValueError):
    """Something that a person wrote is wrong.

    Its text is one line: the file (or option), the key, what was found there, what is allowed.
    Programs print it and exit with status 2.

    Args:
        source: File or command-line option.
        key: Dotted key inside the source; empty for the whole source.
        found: What was found there.
        allowed: What is allowed instead.
    """

    def __init__(self, source: object, key: str, found: object, allowed: str) -> None:
        where = f"{source}: {key}" if key else str(source)
        super().__init__(f"{where}: found {found}; allowed: {allowed}".replace("\n", " "))
        self.source = str(source)
        self.key = key
        self.found = str(found)
        self.allowed = allowed


class RunError(RuntimeError):
    """The run itself failed, in one line; programs print it and exit with status 1."""
