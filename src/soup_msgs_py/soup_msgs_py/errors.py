"""Errors that name what a person can mend."""

from __future__ import annotations

LONGEST = 240  # characters of one part of a message; of longer ones the middle is left out


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
        self.source, self.key, self.found = printable(source), printable(key), printable(found)
        self.allowed = printable(allowed, 4 * LONGEST)
        where = f"{self.source}: {self.key}" if key else self.source
        super().__init__(f"{where}: found {self.found}; allowed: {self.allowed}")


class RunError(RuntimeError):
    """The run itself failed, in one line; programs print it and exit with status 1."""


def printable(text: object, longest: int = LONGEST) -> str:
    """What a person wrote, as part of one line: control characters escaped, the middle of long texts left out."""
    text = str(text)
    if len(text) > longest:
        text = f"{text[: longest // 2]} ... {text[-longest // 4 :]}"
    text = text.replace("\n", " ")
    return text if text.isprintable() else "".join(map(_escaped, text))


def _escaped(character: str) -> str:
    return character if character.isprintable() else character.encode("unicode_escape").decode("ascii")
