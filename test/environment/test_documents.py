"""What the documents say is where they say it is."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import _environment

ROOT = _environment.ROOT
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
FOLDERS = ("src", "scripts", "test", "config", "examples", "docs")
PLACE = re.compile(r"`([\w./]+\.(?:py|yaml|md|msg))`|`((?:src|test|scripts|config|soup_(?!msgs/)\w+)/[\w./]+)`")
OUT_OF_A_RUN = {"metadata.yaml"}  # files that programs write


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda file: file.name)
def test_every_file_that_a_document_names_is_there(document: Path):
    files = [str(file) for folder in FOLDERS for file in (ROOT / folder).rglob("*") if "__pycache__" not in file.parts]
    files += [str(file) for file in ROOT.iterdir()]
    named = {(a or b).rstrip("/") for a, b in PLACE.findall(document.read_text(encoding="utf-8"))} - OUT_OF_A_RUN
    assert not [place for place in sorted(named) if not any(file.endswith(f"/{place}") for file in files)]
