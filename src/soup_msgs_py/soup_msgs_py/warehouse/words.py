"""The words customers may order: read from any plain text file, a list or prose."""

import errno
import os
import re
import sys
import unicodedata
from collections import Counter
from dataclasses import dataclass

from soup_msgs_py.errors import InputError
from soup_msgs_py.reading.files import DEVICE, ZERO_BYTE, read_bytes

MAX_FILE_MB = 50

# what `unusable` counts, and how several of it are called
NUMBER = "number"
SINGLE_LETTER = "single letter"
FOREIGN = "word with a character outside A-Z"
_PLURALS = {
    NUMBER: "numbers",
    SINGLE_LETTER: "single letters",
    FOREIGN: "words with a character outside A-Z",
}

# a number (1200; 1,200; 3.5), or a run of letters with any accents that stand on their own
_PIECE = re.compile(r"\d+(?:[.,]\d+)*|[^\W\d_](?:[^\W\d_]|[\u0300-\u036f])*")

_TEXT = "a text file in UTF-8"
_ONE_WORD = "text with at least one word of two or more letters A-Z"


class WordFileError(InputError):
    """A word file cannot be used."""


@dataclass(frozen=True, slots=True)
class WordList:
    """The usable words of one file.

    Attributes:
        words: In the file's order, upper case A-Z, two letters or more. A word that stands in the file twice
            stands here twice, so a uniform draw follows the frequencies of the text.
        unusable: What could not be used and how often, as (kind, count), the most frequent first.
        path: The file, as it was given.

    """

    words: tuple[str, ...]
    unusable: tuple[tuple[str, int], ...]
    path: str

    @property
    def mean_length(self) -> float:
        """Mean number of letters per word."""
        return sum(map(len, self.words)) / len(self.words)

    def describe(self) -> str:
        """Return one line for a report: how many words, their mean length, and what was left out."""
        line = f"{_count(len(self.words), 'word', 'words')}, mean length {self.mean_length:.2f}"
        if not self.unusable:
            return line
        total = sum(count for _, count in self.unusable)
        return f"{line}, {total} unusable ({_tally(self.unusable)})"


def read_words(path: str | os.PathLike[str]) -> WordList:
    """Read the words of a text file.

    A word is what stands between other characters: a run of two or more of the letters A-Z, in either case.
    Spaces, punctuation, hyphens, apostrophes, underscores and digits all separate: "dog's" is DOG and a
    single letter. Numbers, single letters and runs with a letter outside A-Z ("café", which is not split) are
    counted as unusable.

    Args:
        path: A text file in UTF-8, of at most `MAX_FILE_MB` megabytes.

    Raises:
        WordFileError: The file is missing, unreadable, too large, not text, or holds no usable word.

    """
    words: list[str] = []
    unusable: Counter[str] = Counter()
    # composed, an accented letter is one letter however the file spells it
    for match in _PIECE.finditer(unicodedata.normalize("NFC", _read_text(path))):
        piece = match.group()
        if piece[0].isdecimal():
            unusable[NUMBER] += 1
        elif not piece.isascii():
            unusable[FOREIGN] += 1
        elif len(piece) == 1:
            unusable[SINGLE_LETTER] += 1
        else:
            # prose repeats itself: interned, each distinct word is held once
            words.append(sys.intern(piece.upper()))
    found = WordList(tuple(words), tuple(unusable.most_common()), str(path))
    if not words:
        only = f"no usable word, only {_tally(found.unusable)}" if unusable else "no word at all"
        raise WordFileError(found.path, "", only, _ONE_WORD)
    return found


def _count(number: int, singular: str, plural: str) -> str:
    return f"{number} {singular if number == 1 else plural}"


def _tally(unusable: tuple[tuple[str, int], ...]) -> str:
    return ", ".join(_count(number, kind, _PLURALS[kind]) for kind, number in unusable)


def _read_text(path: str | os.PathLike[str]) -> str:
    """Return the text of a file, or raise a `WordFileError` that says why there is none."""
    name, limit = str(path), MAX_FILE_MB * 1_000_000
    try:
        data = read_bytes(path, limit)
    except FileNotFoundError:
        raise WordFileError(name, "", "no such file", _TEXT) from None
    except IsADirectoryError:
        raise WordFileError(name, "", "a directory", _TEXT) from None
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise WordFileError(name, "", f"more than {MAX_FILE_MB} MB", f"at most {MAX_FILE_MB} MB of text") from None
        is_ours = error.strerror in (DEVICE, ZERO_BYTE)
        found = error.strerror if is_ours else f"that it cannot be read ({error.strerror})"
        raise WordFileError(name, "", found, _TEXT) from None
    if not data:
        raise WordFileError(name, "", "an empty file", _ONE_WORD)
    if (position := data.find(0)) >= 0:
        raise WordFileError(name, "", f"binary data (a zero byte at offset {position})", _TEXT)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        found = f"byte 0x{data[error.start]:02x} at offset {error.start}, not UTF-8"
        raise WordFileError(name, "", found, _TEXT) from None
