"""How far discovery reaches, unless the person says something else."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import pytest

from soup_live.domain import (
    LEFT_TO_OTHERS,
    LOCALHOST_ONLY,
    MOST_LOCAL,
    OTHERS,
    PROFILES,
    RANGE,
    RMW,
    THIS_MACHINE,
    TRANSPORTS,
    stay_on_this_machine,
)
from soup_msgs_py.errors import InputError


def test_a_warehouse_keeps_to_its_machine():
    environment: dict[str, str] = {}
    stay_on_this_machine(4, environment)
    assert environment == {RANGE: "SUBNET", PROFILES: str(THIS_MACHINE), TRANSPORTS: "UDPv4"}
    addresses = [element.text for element in ElementTree.parse(THIS_MACHINE).iter() if element.tag.endswith("address")]
    assert set(addresses) == {"127.0.0.1"}


@pytest.mark.parametrize("name", OTHERS)
def test_a_person_who_says_who_is_meant_is_heard(name: str):
    environment = {name: "what they say", TRANSPORTS: "DEFAULT"}
    before = dict(environment)
    stay_on_this_machine(4, environment)
    assert environment == before


def test_so_many_processes_would_not_find_each_other_and_are_refused():
    environment: dict[str, str] = {}
    most = MOST_LOCAL - LEFT_TO_OTHERS
    stay_on_this_machine(most, environment)
    assert environment[PROFILES] == str(THIS_MACHINE)
    with pytest.raises(InputError, match=f"{most + 1}.*at most {most} on one machine"):
        stay_on_this_machine(most + 1, {})
    ranges = [e.text for e in ElementTree.parse(THIS_MACHINE).iter() if e.tag.endswith("maxInitialPeersRange")]
    assert ranges == [str(MOST_LOCAL)]


def test_what_a_starter_decides_its_parts_keep():
    environment: dict[str, str] = {}
    stay_on_this_machine(40, environment)
    decided = dict(environment)
    stay_on_this_machine(1, environment)
    assert environment == decided


def test_other_implementations_of_dds_are_kept_to_this_machine_too():
    environment = {RMW: "rmw_cyclonedds_cpp"}
    stay_on_this_machine(4, environment)
    assert environment[RANGE] == "LOCALHOST"
    assert PROFILES not in environment


def test_the_older_word_for_this_machine_is_understood():
    environment = {LOCALHOST_ONLY: "1"}
    stay_on_this_machine(4, environment)
    assert environment == {RANGE: "SUBNET", PROFILES: str(THIS_MACHINE), TRANSPORTS: "UDPv4"}
    environment = {LOCALHOST_ONLY: "0"}
    stay_on_this_machine(4, environment)
    assert environment == {LOCALHOST_ONLY: "0", TRANSPORTS: "UDPv4"}
