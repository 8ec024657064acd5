"""The reference of scenario keys, written from the models that check a scenario."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any

from soup_msgs_py.scenario import Scenario

Schema = dict[str, Any]
UNITS = {"_mps2": "m/s²", "_mps": "m/s", "_radps": "rad/s", "_rad": "rad", "_m": "m", "_s": "s", "per_hour": "1/h"}
POLICY = "PolicyChoice"
LISTED = 6  # defaults with more members are told by their first


def scenario_page() -> str:
    """The whole document."""
    schema = Scenario.model_json_schema()
    parts = schema["$defs"]
    lines = [
        "# Scenario keys",
        "",
        "A scenario is a YAML file, for instance [`demo.yaml`](../../config/scenarios/demo.yaml).",
        "`--set KEY=VALUE` changes one value, with dots between the keys: `--set bot.max_speed_mps=3`.",
        "A key without a default is required. Paths of files are relative to the scenario file.",
        "",
        *_section("", schema, parts, set()),
    ]
    return "\n".join(lines) + "\n"


def _section(path: str, schema: Schema, parts: Schema, told: set[str]) -> Iterator[str]:
    """A table of the keys of one part, then the parts that it has; those in `told` have a table already."""
    yield "| key | unit | allowed | default | meaning |"
    yield "|---|---|---|---|---|"
    inner: dict[str, tuple[str, Schema]] = {}
    for key, value in schema["properties"].items():
        if key == "kind":
            continue
        whole = f"{path}.{key}" if path else key
        branches = [_resolved(branch, parts) for branch in _branches(value)]
        members = [_resolved(value["items"], parts)] if "items" in value else []
        for branch in [*branches, *members]:
            if branch.get("properties") and f"{whole} {branch['title']}" not in told and branch["title"] != POLICY:
                inner[f"{whole} {branch['title']}"] = (whole, branch)
        yield _row(whole, value, branches, key in schema.get("required", ()))
    told |= inner.keys()
    for whole, branch in inner.values():
        kind = branch["properties"].get("kind", {}).get("const")
        yield ""
        yield f"## `{whole}`, kind `{kind}`" if kind else f"## `{whole}`"
        yield ""
        yield " ".join(branch.get("description", "").split())
        if branch["properties"].keys() - {"kind"}:
            yield ""
            yield from _section(whole, branch, parts, told)


def _row(key: str, value: Schema, branches: list[Schema], required: bool) -> str:
    unit = next((unit for ending, unit in UNITS.items() if key.endswith(ending)), "")
    default = "" if required else _default(value.get("default"))
    meaning = " ".join(value.get("description", "").split())
    allowed = _one_of(dict.fromkeys(allowed_values(branch) for branch in branches))
    return f"| `{key}` | {unit} | {allowed} | {default} | {meaning} |".replace("|  |", "| |").replace("|  |", "| |")


def _one_of(choices: Iterable[str]) -> str:
    *others, last = choices
    return f"{', '.join(others)} or {last}" if others else last


def _default(value: Any) -> str:
    if isinstance(value, dict):
        named = f"`{value['name']}`" if "name" in value else "see below"
        return f"`kind: {value['kind']}`" if "kind" in value else named
    text = json.dumps(value[:LISTED] if isinstance(value, list) else value)
    return f"`{text}`" + (" and so on" if isinstance(value, list) and len(value) > LISTED else "")


def _branches(value: Schema) -> list[Schema]:
    """The shapes that a value may have."""
    return value.get("oneOf") or value.get("anyOf") or [value]


def _resolved(value: Schema, parts: Schema) -> Schema:
    return parts[value["$ref"].removeprefix("#/$defs/")] if "$ref" in value else value


def allowed_values(value: Schema) -> str:
    """What a JSON schema allows, in words."""
    kind = value.get("type")
    if "enum" in value:
        return ", ".join(f"`{each}`" for each in value["enum"])
    if value.get("properties"):
        tag = value["properties"].get("kind", {}).get("const")
        if value["title"] == POLICY:
            return "[a policy](policies.md), or a mapping with its `name` and `options`"
        return f"`kind: {tag}`" if tag else "a mapping"
    if kind == "array":
        if "prefixItems" in value:
            return f"[{', '.join(allowed_values(each) for each in value['prefixItems'])}]"
        count = _range(value.get("minItems"), value.get("maxItems"))
        each = value.get("items", {})
        return f"a list ({count}), each " + ("a mapping" if "$ref" in each else allowed_values(each))
    if kind in ("number", "integer"):
        return _numbers(value, "a whole number" if kind == "integer" else "a number")
    if kind == "string" and "maxLength" in value:
        return f"text, {_range(value.get('minLength'), value['maxLength'])} characters"
    names = {"boolean": "`true` or `false`", "null": "`null`", "string": "text", "object": "a mapping"}
    return names.get(str(kind), "")


def _numbers(value: Schema, what: str) -> str:
    least, most, above = value.get("minimum"), value.get("maximum"), value.get("exclusiveMinimum")
    if least is None and above is not None:
        return f"{what} above {_written(above)}" + (f", at most {_written(most)}" if most is not None else "")
    return f"{what} {_range(least, most)}".strip()


def _range(least: Any, most: Any) -> str:
    if least is not None and least == most:
        return _written(least)
    if least is not None and most is not None:
        return f"{_written(least)} to {_written(most)}"
    if least is not None:
        return f"from {_written(least)}"
    return f"at most {_written(most)}" if most is not None else ""


def _written(number: float) -> str:
    return f"{number:,}" if isinstance(number, int) else f"{number:,g}"
