"""The ROS domain that the environment names."""

from __future__ import annotations

import pytest

from soup_live.domain_id import HIGHEST, VARIABLE, domain_id
from soup_msgs_py.errors import InputError


@pytest.mark.parametrize(("text", "number"), [(None, 0), ("", 0), ("0", 0), ("42", 42), (str(HIGHEST), HIGHEST)])
def test_the_domain_is_the_one_that_is_named(text: str | None, number: int):
    assert domain_id({} if text is None else {VARIABLE: text}) == number


@pytest.mark.parametrize("text", ["abc", "-1", "1.5", " 1", "²", str(HIGHEST + 1)])
def test_what_is_no_domain_is_told(text: str):
    with pytest.raises(InputError, match=f"^{VARIABLE}: found {text}; allowed: a whole number from 0 to {HIGHEST}$"):
        domain_id({VARIABLE: text})
