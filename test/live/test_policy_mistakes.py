"""A live manager whose policy decides what cannot be says so; one whose policy fails ends with its file and line."""

from __future__ import annotations

from pathlib import Path

import pytest

from .conftest import Parts
from .person import Person
from .test_swap import Reports

pytestmark = [pytest.mark.live, pytest.mark.timeout(300)]

OWN = """\
from soup_managers.policies import WordPolicy
from soup_msgs_py.messages import AssignWord

class NoSuchWord(WordPolicy):
    def choose(self, view, stations, rng):
        return AssignWord(999_999, stations[0])

class Failing(WordPolicy):
    def choose(self, view, stations, rng):
        return stations[1000]
"""


def test_a_manager_tells_what_its_policy_got_wrong(parts: Parts, tmp_path: Path):
    own = tmp_path / "own.py"
    own.write_text(OWN)
    world = parts.start("run_world.py")
    manager = parts.start("run_word_manager.py", "--policy", f"{own}:NoSuchWord")
    mistake = "word policy NoSuchWord chose a word that does not wait (AssignWord(word=999999, station=0))"
    with Person() as person:
        reports = Reports(person)
        person.wait(lambda: reports.value("word manager", "mistake") == mistake, "the mistake is reported")
    assert f"word manager: {mistake}\n" in parts.interrupt(manager)
    status, _, err = parts.run("run_word_manager.py", "--policy", f"{own}:Failing")
    assert status == 1
    assert err.endswith(f"a policy failed: IndexError: list index out of range ({own}, line 10)\n")
    assert "Traceback" not in err
    parts.interrupt(world)
