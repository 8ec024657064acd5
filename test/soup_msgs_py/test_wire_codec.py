"""A dataclass and its message that do not fit each other are told at import, not by a field that never arrives."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from soup_msgs import msg

from soup_msgs_py.wire import MalformedMessage, codec, from_ros, to_ros
from soup_msgs_py.wire.codec import Way, row

NO_DATACLASS = {"Statistics"}  # figures by their names; see `to_statistics`


@pytest.fixture(autouse=True)
def rows_of_their_own(monkeypatch: pytest.MonkeyPatch):
    """No row that a test makes stays."""
    monkeypatch.setattr(codec, "codecs", dict(codec.codecs))
    monkeypatch.setattr(codec, "readers", dict(codec.readers))


@dataclass
class Pile:
    """Of the shape of a bundle."""

    bundle: int
    tile: int
    count: int


def test_every_message_has_a_row():
    messages = {name for name in dir(msg) if name[0].isupper()} - NO_DATACLASS
    assert messages == {ros.__name__ for ros in codec.readers if ros.__module__.startswith("soup_msgs.msg.")}


def test_a_new_message_is_one_dataclass_and_one_row():
    row(Pile, msg.Bundle)
    assert to_ros(Pile(1, 2, 3)) == msg.Bundle(bundle=1, tile=2, count=3)
    assert from_ros(msg.Bundle(bundle=1, tile=2, count=3)) == Pile(1, 2, 3)


def test_a_field_that_the_message_lacks_is_told():
    @dataclass
    class Heap(Pile):
        colour: int

    with pytest.raises(TypeError, match=r"Heap\.colour: its message has no"):
        row(Heap, msg.Bundle)


def test_a_field_that_only_the_message_has_is_told():
    @dataclass
    class Crumb:
        bundle: int
        tile: int

    with pytest.raises(TypeError, match="Bundle has more than Crumb: count"):
        row(Crumb, msg.Bundle)
    row(Crumb, msg.Bundle, apart=("count",))
    assert to_ros(Crumb(1, 2)) == msg.Bundle(bundle=1, tile=2)


def test_a_hint_that_no_rule_is_for_is_told():
    @dataclass
    class Odd:
        bundle: complex
        tile: int
        count: int

    with pytest.raises(TypeError, match="no rule for <class 'complex'> in Odd"):
        row(Odd, msg.Bundle)


def test_what_the_message_does_not_hold_is_handed_to_the_codec():
    @dataclass
    class Owned(Pile):
        owner: str
        note: str = ""

    made = row(Owned, msg.Bundle, apart=("owner", "note"))
    assert made.from_ros(msg.Bundle(bundle=1), "we") == Owned(1, 0, 0, "we")


def test_a_field_may_travel_under_another_name_in_several_and_through_functions():
    @dataclass
    class Parcel:
        what: int
        tile_and_count: tuple[int, int]

    ways = {"what": Way("bundle"), "tile_and_count": Way("tile", "count", out=tuple, back=lambda *both: both)}
    row(Parcel, msg.Bundle, ways=ways)
    assert to_ros(Parcel(1, (2, 3))) == msg.Bundle(bundle=1, tile=2, count=3)
    assert from_ros(msg.Bundle(bundle=1, tile=2, count=3)) == Parcel(1, (2, 3))


def test_a_verb_that_no_row_has_is_refused():
    with pytest.raises(MalformedMessage, match="'explode' is no verb of BotRequest"):
        from_ros(msg.BotRequest(verb="explode"))
