"""The reference of policies, written from the tables of names, the classes, and what their constructors take."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterator, Mapping
from typing import Any, get_type_hints

from pydantic import TypeAdapter

from soup_bots.steering import KNOWN as STEERING
from soup_lab.reference.scenario import allowed_values
from soup_managers.decisions import BOTS, BUCKETS, FILLS, ONWARD, STORAGE
from soup_managers.fleets.make import FLEET
from soup_managers.policies import LETTER, WORD
from soup_managers.state.planning_state import Horizons
from soup_sim.station_policies import LETTER_STATION, WORD_STATION

# Title, what is decided, where a choice is made, and the table of names.
GROUPS: tuple[tuple[str, str, str, Mapping[str, type]], ...] = (
    ("Word policies", "Which word is opened on which word station", "`word:`, `--word-policy`", WORD),
    ("Letter policies", "Which letters come in, and to which letter station", "`letter:`, `--letter-policy`", LETTER),
    ("Fleet policies", "What the bots do", "`fleet:`, `--fleet-policy`", FLEET),
    ("Buckets for words", "Which bucket is fetched for a word station", "`buckets` of `coordinated`", BUCKETS),
    ("Buckets for letters", "Which bucket is fetched to be filled", "`fills` of `coordinated`", FILLS),
    ("Bots", "Which bot fetches a bucket", "`bots` of `coordinated`", BOTS),
    ("Onward", "Where a bucket goes when a station is done with it", "`onward` of `coordinated`", ONWARD),
    ("Storage", "Where a bucket is stored", "`storage` of `coordinated`", STORAGE),
    ("Steering", "How a bot avoids others on its way", "`bot:`, `--bot-policy`", STEERING),
    ("Word station policies", "What a word station does next", "scenario, `word_station.policy`", WORD_STATION),
    ("Letter station policies", "What a letter station does next", "scenario, `letter_station.policy`", LETTER_STATION),
)


def policies_page() -> str:
    """The whole document."""
    lines = [
        "# Policies",
        "",
        "A policies file names a policy for each role. [`best.yaml`](../../config/policies/best.yaml) is the default.",
        "Where a name stands, a class of your own may stand as `FILE.py:Class`, relative to the file that names it.",
        "Options go into a mapping: `storage: {name: near_words, options: {weight: 2.0}}`.",
    ]
    for title, decides, where, known in GROUPS:
        lines += ["", f"## {title}", "", f"{decides} ({where})."]
        for name, policy in known.items():
            lines += ["", f"### `{name}`", "", described(policy), *options_table(policy)]
    lines += ["", "## Horizons", "", f"{described(Horizons)} (`horizons` of `coordinated`.)", *options_table(Horizons)]
    return "\n".join(lines) + "\n"


def described(policy: type) -> str:
    """What the docstring of a class says, without its arguments; paragraphs in one line each."""
    text = re.split(r"\n(?:Args|Attributes|Example|Raises):\n", inspect.cleandoc(policy.__doc__ or ""))[0]
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in text.strip().split("\n\n"))


def options_table(policy: type) -> Iterator[str]:
    """The options of a class as a table; nothing where it has none."""
    options = list(options_of(policy))
    if options:
        yield from ("", "| option | allowed | default | meaning |", "|---|---|---|---|")
        for option, (allowed, default, meaning) in options:
            yield f"| `{option}` | {allowed} | {default} | {meaning} |"


def options_of(policy: type) -> Iterator[tuple[str, tuple[str, str, str]]]:
    """Each option of a constructor: its name, what is allowed, its default, what it means."""
    constructor: Any = policy.__init__
    if constructor is object.__init__:
        return
    hints = get_type_hints(constructor, include_extras=True)
    meanings = meanings_of(policy)
    for name, parameter in list(inspect.signature(constructor).parameters.items())[1:]:
        default = "" if parameter.default is parameter.empty else f"`{_yaml(parameter.default)}`"
        yield name, (_allowed(hints[name]), default, meanings.get(name, ""))


def meanings_of(policy: type) -> dict[str, str]:
    """What the docstrings of a class and of those that it extends say of each argument."""
    meanings: dict[str, str] = {}
    for each in policy.__mro__:
        text = inspect.cleandoc(each.__doc__ or "")
        section = re.search(r"\n(?:Args|Attributes):\n(.*?)(?:\n\n|\Z)", text, re.DOTALL)
        for found in re.finditer(r"^ {4}(\w+): (.*?)(?=^ {4}\w|\Z)", section[1] if section else "", re.M | re.DOTALL):
            meanings.setdefault(found[1], " ".join(found[2].split()))
    return meanings


def _allowed(hint: Any) -> str:
    schema = TypeAdapter(hint).json_schema()
    branches = schema.get("anyOf") or [schema]
    return " or ".join(dict.fromkeys(allowed_values(branch) for branch in branches))


def _yaml(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)
