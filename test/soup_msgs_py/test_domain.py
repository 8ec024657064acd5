"""How far discovery reaches, unless the person says something else."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import pytest

from soup_msgs_py.live.domain import MOST_LOCAL, OTHERS, PROFILES, RANGE, THIS_MACHINE, TRANSPORTS, stay_on_this_machine


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


def test_so_many_processes_find_each_other_in_the_usual_way():
    environment: dict[str, str] = {}
    stay_on_this_machine(MOST_LOCAL, environment)
    assert environment == {TRANSPORTS: "UDPv4"}
