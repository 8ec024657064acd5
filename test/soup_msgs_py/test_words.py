"""Word lists: the supplied ones keep their law, any text works, and bad files are refused in one line."""

import contextlib
import os
import pickle
import string
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from soup_msgs_py.warehouse.words import FOREIGN, NUMBER, SINGLE_LETTER, WordFileError, WordList, read_words

WORDS = Path(__file__).resolve().parents[2] / "config" / "words"

same_file_each_time = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
usable_words = st.text(string.ascii_letters, min_size=2, max_size=16)
separators = st.text(" \t\r\n.,;:!?'\u2019\"“”-\u2013—_()[]/&%#*+=", min_size=1, max_size=4)


@pytest.fixture
def text_file(tmp_path):
    """Write text (or bytes) to a file and return its path."""
    path = tmp_path / "words.txt"

    def write(content: str | bytes) -> Path:
        path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        return path

    return write


def refusal(path: Path) -> str:
    """Return the line with which a file is refused, checked to be one line that names the file."""
    with pytest.raises(WordFileError) as caught:
        read_words(path)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{path}: found ")
    assert "; allowed: " in line
    return line


# the supplied lists


def test_jargon_has_at_least_500_unique_sorted_words_of_mean_length_9_2():
    path = WORDS / "jargon.txt"
    jargon = read_words(path)
    assert len(jargon.words) >= 500
    assert len(set(jargon.words)) == len(jargon.words)
    assert jargon.mean_length == pytest.approx(9.2, abs=1e-9)
    assert jargon.unusable == ()
    assert path.read_text(encoding="utf-8").split() == sorted(word.lower() for word in jargon.words)


def test_jargon_uses_every_letter_of_the_alphabet():
    assert set("".join(read_words(WORDS / "jargon.txt").words)) == set(string.ascii_uppercase)


def test_jargon_lengths_spread_from_short_to_long():
    lengths = {len(word) for word in read_words(WORDS / "jargon.txt").words}
    assert lengths == set(range(3, 16))


def test_prose_is_a_word_list_too():
    prose = read_words(WORDS / "prose.txt")
    assert len(prose.words) > 400
    assert prose.words[:5] == ("THE", "NIGHT", "SHIFT", "HANDS", "OVER")
    assert prose.words.count("THE") > 20
    assert dict(prose.unusable)[NUMBER] == 5
    assert dict(prose.unusable)[FOREIGN] == 2


# what a word is


@same_file_each_time
@given(pieces=st.lists(st.tuples(usable_words, separators), min_size=1))
def test_any_words_between_any_separators_come_back_in_order_with_repetitions(text_file, pieces):
    found = read_words(text_file("".join(word + separator for word, separator in pieces)))
    assert list(found.words) == [word.upper() for word, _ in pieces]
    assert found.unusable == ()


@same_file_each_time
@given(text=st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0")))
def test_any_text_gives_usable_words_or_one_clear_refusal(text_file, text):
    try:
        found = read_words(text_file(text))
    except WordFileError:
        return
    assert all(len(word) >= 2 and set(word) <= set(string.ascii_uppercase) for word in found.words)
    assert all(count > 0 for _, count in found.unusable)
    assert "\n" not in found.describe()


@same_file_each_time
@given(content=st.binary(max_size=200))
def test_any_bytes_are_read_or_refused_and_nothing_else(text_file, content):
    with contextlib.suppress(WordFileError):
        assert read_words(text_file(content)).words


@pytest.mark.parametrize(
    ("text", "words", "unusable"),
    [
        ("the dog's bone", ["THE", "DOG", "BONE"], {SINGLE_LETTER: 1}),
        ("I have a cat", ["HAVE", "CAT"], {SINGLE_LETTER: 2}),
        ("twenty-four snake_case", ["TWENTY", "FOUR", "SNAKE", "CASE"], {}),
        ("a café for naïve bots", ["FOR", "BOTS"], {SINGLE_LETTER: 1, FOREIGN: 2}),
        ("one cafe\u0301 spelt in two parts", ["ONE", "SPELT", "IN", "TWO", "PARTS"], {FOREIGN: 1}),
        ("слово and 単語", ["AND"], {FOREIGN: 2}),
        ("1,200 tiles at 3.5 m/s, row 7.", ["TILES", "AT", "ROW"], {NUMBER: 3, SINGLE_LETTER: 2}),
        ("the 4th of May", ["THE", "TH", "OF", "MAY"], {NUMBER: 1}),
        ("\ufeffmarked\r\nlines\r\n", ["MARKED", "LINES"], {}),
    ],
)
def test_words_are_what_stands_between_other_characters(text_file, text, words, unusable):
    found = read_words(text_file(text))
    assert list(found.words) == words
    assert dict(found.unusable) == unusable


def test_a_word_list_describes_itself_in_one_line(text_file):
    assert read_words(text_file("pallet")).describe() == "1 word, mean length 6.00"
    found = read_words(text_file("the robot's café has 3 tables and 12 chairs"))
    assert found.describe() == (
        "6 words, mean length 4.33, 4 unusable (2 numbers, 1 single letter, 1 word with a character outside A-Z)"
    )


def test_a_word_list_names_its_file_and_can_travel_between_processes(text_file):
    found = read_words(str(text_file("grab release transfer")))
    assert found.path.endswith("words.txt")
    assert pickle.loads(pickle.dumps(found)) == found
    assert found == WordList(("GRAB", "RELEASE", "TRANSFER"), (), found.path)


# what is refused


def test_a_missing_file_is_refused(tmp_path):
    assert "found no such file" in refusal(tmp_path / "nowhere" / "words.txt")


def test_a_directory_is_refused(tmp_path):
    assert "found a directory" in refusal(tmp_path)


def test_a_name_that_no_file_can_have_is_refused():
    with pytest.raises(WordFileError, match="found a zero byte in its name"):
        read_words("words\0.txt")


def test_a_pipe_is_refused_without_waiting_for_it(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert "found a device, pipe or socket" in refusal(tmp_path / "pipe")


def test_a_path_through_a_file_is_refused(text_file):
    assert "cannot be read (Not a directory)" in refusal(text_file("word") / "words.txt")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_without_read_permission_is_refused(text_file):
    path = text_file("word")
    path.chmod(0)
    assert "cannot be read (Permission denied)" in refusal(path)


def test_an_empty_file_is_refused(text_file):
    assert "found an empty file" in refusal(text_file(""))


def test_a_file_of_another_encoding_is_refused_with_the_offending_byte(text_file):
    assert "found byte 0xe9 at offset 3, not UTF-8" in refusal(text_file("café".encode("latin-1")))


def test_the_offset_of_a_bad_byte_counts_a_byte_order_mark(text_file):
    assert "byte 0xff at offset 7" in refusal(text_file(b"\xef\xbb\xbfword\xff"))


@pytest.mark.parametrize("content", [b"word\0word", "word".encode("utf-16-le")])
def test_a_binary_file_is_refused(text_file, content):
    assert "found binary data (a zero byte at offset " in refusal(text_file(content))


def test_a_file_without_any_word_is_refused(text_file):
    assert "found no word at all" in refusal(text_file(" \n ... \n"))


def test_a_file_without_a_usable_word_is_refused_with_what_it_holds(text_file):
    line = refusal(text_file("12 34 é x"))
    assert "no usable word, only 2 numbers, 1 word with a character outside A-Z, 1 single letter" in line


def test_a_huge_file_is_refused(text_file, monkeypatch):
    monkeypatch.setattr("soup_msgs_py.warehouse.words.MAX_FILE_MB", 1)
    assert len(read_words(text_file("ab " * 333_333)).words) == 333_333
    assert "found more than 1 MB; allowed: at most 1 MB" in refusal(text_file("ab " * 333_334))
