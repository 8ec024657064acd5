"""What the programs in this folder have in common on their command lines."""

from __future__ import annotations

import _environment

CONFIG = _environment.ROOT / "config"
SCENARIO = CONFIG / "scenarios" / "demo.yaml"
POLICIES = CONFIG / "policies" / "best.yaml"
