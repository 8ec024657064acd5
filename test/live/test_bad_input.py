"""What a person gets wrong is told in one line, exit status 2, and nothing is started."""

from __future__ import annotations

import socket
from collections.abc import Iterator

import pytest

from .conftest import Parts
from .person import Person

pytestmark = [pytest.mark.live, pytest.mark.timeout(300)]

# program and arguments, and what the line must say
WRONG = {
    "a duration below zero": ("run_warehouse.py", ["--duration", "-5"], "--duration: found '-5'; allowed:"),
    "a speed that is no number": ("run_warehouse.py", ["--speed", "nan"], "--speed: found 'nan'; allowed:"),
    "a warm-up longer than the run": ("run_warehouse.py", ["--duration", "5", "--warmup", "9"], "--warmup: found 9"),
    "an option that does not exist": ("run_warehouse.py", ["--fast"], "--fast"),
    "a summary in a missing folder": ("run_warehouse.py", ["--summary", "no/out.json"], "--summary: found no folder"),
    "a policy that does not exist": (
        "run_warehouse.py",
        ["--fleet-policy", "psychic"],
        "fleet policy: found 'psychic'",
    ),
    "a steering that does not exist": ("run_bots.py", ["0", "--policy", "psychic"], "bot policy: found 'psychic'"),
    "an unknown key": ("run_warehouse.py", ["--set", "robots=3"], "robots: found an unknown key"),
    "a missing word file": ("run_world.py", ["--set", "words=no.txt"], "no such file"),
    "a missing scenario": ("run_world.py", ["--scenario", "no.yaml"], "no.yaml: found No such file"),
    "bots that run backwards": ("run_bots.py", ["5-2"], "bots: found '5-2'; allowed:"),
    "a bag that is there": ("run_warehouse.py", ["--record", "."], "which is there already; allowed: a folder"),
    "a folder that holds more than a bag": (
        "run_warehouse.py",
        ["--no-dashboard", "--record", ".", "--overwrite"],
        "allowed: a folder that holds a bag alone",
    ),
    "nothing to overwrite": ("run_warehouse.py", ["--overwrite"], "--overwrite: found no --record"),
    "a bag nowhere": ("run_warehouse.py", ["--record", "no/bag"], "no/bag: found No such file or directory; allowed:"),
}


@pytest.mark.parametrize("mistake", WRONG)
def test_a_mistake_is_told_in_one_line_and_nothing_starts(parts: Parts, mistake: str):
    script, arguments, told = WRONG[mistake]
    status, out, err = parts.run(script, *arguments)
    assert (status, out) == (2, "")
    assert told in err
    assert err.count("\n") == 1
    assert parts.alive() == []


@pytest.fixture
def taken_port() -> Iterator[int]:
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        yield server.getsockname()[1]


def test_a_port_in_use_is_told_before_anything_starts(parts: Parts, taken_port: int):
    for script in ("run_warehouse.py", "run_dashboard.py"):
        status, _, err = parts.run(script, "--port", str(taken_port))
        assert status == 2
        assert "--port: found" in err
        assert f"{taken_port} in use; allowed:" in err
        assert err.count("\n") == 1


def test_a_second_world_in_the_domain_is_refused(parts: Parts, domain: str):
    world = parts.start("run_world.py")
    with Person() as person:
        person.wait(lambda: person.node.count_publishers("/clock") > 0, "the first world is there")
    for script, *more in (("run_world.py",), ("run_warehouse.py", "--no-dashboard")):
        status, _, err = parts.run(script, *more)
        assert status == 2
        assert (
            err
            == f"ROS_DOMAIN_ID: found another world in domain {domain}; allowed: a domain of its own for each world\n"
        )
    parts.interrupt(world)


def test_bots_that_the_world_does_not_have_end_with_a_line(parts: Parts):
    world = parts.start("run_world.py", "--set", "bots=3")
    status, _, err = parts.run("run_bots.py", "2-3")
    assert status == 2
    assert "found bot 3; allowed: 0 to 2, which the world has" in err
    parts.interrupt(world)
