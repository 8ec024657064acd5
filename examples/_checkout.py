"""Has a program of this folder run from a checkout, as those in `scripts/` do: in `.venv`, made by the first start."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1] / "scripts"))

from _environment import enter as enter
