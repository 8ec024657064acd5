"""What makes two runs the same run: fingerprints of settings and code, so that no old result passes for a new one."""

from __future__ import annotations

import functools
import hashlib
import importlib
import importlib.metadata
import json
import os
import platform
import subprocess
from pathlib import Path
from typing import Any

from soup_lab.headless.runs import RunPlan

CODE = ("soup_msgs_py", "soup_sim", "soup_bots", "soup_managers", "soup_lab")  # packages that a run is made of
# Modules of theirs that no headless run comes by: nodes, their programs, and what nodes are made of.
NO_PART = ("*_node.py", "*_program.py", "wire/*", "nodes/*", "time_services.py", "checkpoint_keeper.py")
OF_LAB = ("headless/simulation.py", "headless/runs.py")  # all that a run needs of soup_lab
LIBRARIES = ("numpy", "scipy", "numba")  # that figures can depend on


def settings_digest(plan: RunPlan) -> str:
    """Fingerprint of a plan: scenario, policies and times, and what is in the files that they name, not where."""
    settings = {
        "scenario": plan.warehouse.scenario.model_dump(mode="json"),
        "policies": plan.policies.model_dump(mode="json"),
        "times": [plan.duration_s, plan.warmup_s],
    }
    return _digest(json.dumps(_with_contents(settings), sort_keys=True, default=repr))


def run_digest(settings: str, seed: int, code: str) -> str:
    """Fingerprint of one run."""
    return _digest(f"{settings} {seed} {code}")


@functools.cache
def code_digest() -> str:
    """Fingerprint of the code and the libraries that decide what a run does."""
    parts = [f"{name} {version}" for name, version in _libraries().items()]
    for name in CODE:
        folder = Path(importlib.import_module(name).__file__ or "").parent
        for file in sorted(folder.rglob("*.py")):
            module = file.relative_to(folder)
            used = str(module) in OF_LAB if name == "soup_lab" else not any(map(module.match, NO_PART))
            if used:
                parts.append(f"{name}/{module} {_digest(file.read_bytes())}")
    return _digest("\n".join(parts))


def versions() -> dict[str, str]:
    """What a person needs to get the same figures again."""
    return {**_libraries(), "code": code_digest(), "git": _commit()}


def _libraries() -> dict[str, str]:
    return {"python": platform.python_version(), **{name: importlib.metadata.version(name) for name in LIBRARIES}}


def _commit() -> str:
    """The commit that the sources are of."""
    command = ["git", "describe", "--always", "--dirty= with changes", "--abbrev=12", "--exclude=*"]
    try:
        folder = Path(__file__).resolve().parent
        answer = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=20, check=True)
    except (OSError, subprocess.SubprocessError):
        return "no git repository"
    return answer.stdout.strip()


def _with_contents(value: Any) -> Any:
    """A value, each file that it names (`/words.txt`, `policy.py:Class`) replaced by a fingerprint of the file."""
    if isinstance(value, dict):
        return {str(key): _with_contents(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_with_contents(part) for part in value]
    if not isinstance(value, str):
        return value
    place, _, of_file = value.rpartition(":") if ".py:" in value else (value, "", "")
    path = Path(place)
    if not (path.is_absolute() or of_file) or not os.path.isfile(path):
        return value
    return ["file", _digest(path.read_bytes()), of_file]


def _digest(data: str | bytes) -> str:
    return hashlib.sha256(data.encode() if isinstance(data, str) else data).hexdigest()[:16]
