"""What the metadata.yaml of a bag says: which files it has, and what its recorder noted."""

from __future__ import annotations

from pathlib import Path, PurePath
from typing import Annotated, Any

from pydantic import BaseModel, Field, field_validator

from soup_lab.bags.writer import METADATA, VERSION
from soup_msgs_py.errors import InputError
from soup_msgs_py.reading.yaml_input import read_mapping, validate

ALLOWED = "a rosbag2 bag"
REPAIRED = f"what rosbag2 writes (a bag without its {METADATA} is repaired when it is opened)"
TOP = "rosbag2_bagfile_information"
Count = Annotated[int, Field(ge=0, lt=2**63)]


class FileEntry(BaseModel):
    """One file of a bag."""

    path: str
    message_count: Count


class BagMetadata(BaseModel):
    """What is of interest here of the metadata of a bag; its files themselves say the rest."""

    version: Annotated[int, Field(ge=1, le=VERSION)]
    storage_identifier: str
    relative_file_paths: Annotated[list[str], Field(min_length=1)]
    message_count: Count | None = None
    compression_mode: str = ""
    files: list[FileEntry] | None = None
    custom_data: dict[str, str] | None = None

    @field_validator("storage_identifier")
    @classmethod
    def _is_mcap(cls, value: str) -> str:
        if value != "mcap":
            raise ValueError(f"{value[:40]!r}|mcap (`ros2 bag convert` makes such a bag of another)")
        return value

    @field_validator("compression_mode")
    @classmethod
    def _is_by_chunk(cls, value: str) -> str:
        if value.lower() not in ("", "none", "storage"):
            raise ValueError(f"{value[:40]!r}|none, with compressed chunks (`ros2 bag convert` makes such a bag)")
        return value

    @property
    def names(self) -> dict[str, int | None]:
        """Its files, with how many messages each should hold as far as that is known."""
        counts = {PurePath(entry.path).name: entry.message_count for entry in self.files or ()}
        names = [PurePath(path).name for path in self.relative_file_paths]
        return {name: counts.get(name) for name in names if name}


def read_metadata(folder: Path) -> BagMetadata:
    """Read the metadata of a bag.

    Raises:
        InputError: There are none, or they make no sense.
    """
    path = folder / METADATA
    if not path.exists():
        raise InputError(folder, "", f"no {METADATA}", ALLOWED)
    try:
        content: Any = read_mapping(path).get(TOP)
        if not isinstance(content, dict):
            raise InputError(path, TOP, "nothing" if content is None else f"a {type(content).__name__}", "a mapping")
        return validate(BagMetadata, content, path)
    except InputError as error:
        raise InputError(error.source, error.key, error.found, f"{error.allowed}; {REPAIRED}") from error
