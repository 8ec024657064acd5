"""Each end of a channel counts what it says or hears, and tells what has changed."""

from __future__ import annotations

from soup_msgs_py import mail
from soup_msgs_py.mail import Mail

OUTCOMES = mail.outcomes("bots 0-3")


def test_only_what_has_changed_is_told():
    counts = Mail()
    counts.sent(mail.BOUND)
    counts.got(OUTCOMES)
    assert counts.has_news
    assert counts.news() == (((mail.BOUND, 1),), ((OUTCOMES, 1),))
    assert not counts.has_news
    assert counts.news() == ((), ())
    counts.got(OUTCOMES)
    assert counts.news() == ((), ((OUTCOMES, 2),))


def test_another_world_is_told_everything():
    counts = Mail()
    counts.sent(mail.BOUND)
    counts.news()
    counts.tell_all_again()
    assert counts.news() == (((mail.BOUND, 1),), ())


def test_those_that_a_newer_one_has_pushed_out_count_as_heard():
    counts = Mail()
    counts.got(OUTCOMES, 1, of=2)
    counts.got(OUTCOMES, 4, of=2)
    counts.got(OUTCOMES, 2, of=3)
    assert counts.news()[1] == ((OUTCOMES, 6),)


def test_numbers_that_begin_anew_are_of_somebody_who_was_started_again():
    counts = Mail()
    counts.got(OUTCOMES, 7, of=2)
    counts.got(OUTCOMES, 1, of=2)
    assert counts.news()[1] == ((OUTCOMES, 8),)
