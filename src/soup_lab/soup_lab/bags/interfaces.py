"""Interface definitions: of what is installed, for a bag; and of what a bag holds."""

from __future__ import annotations

import importlib
import sys
from functools import cache
from pathlib import Path
from typing import Any

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

SECTION = "=" * 80 + "\nMSG: "  # between the definitions of a type and of those that it contains


class UnknownType(Exception):
    """A message type that is not installed here, or whose definition cannot be read."""


class Definitions:
    """Definitions of message types, as a bag needs them, from the packages that are installed."""

    def __init__(self) -> None:
        """Begin with what every ROS has."""
        self._store: Typestore = get_typestore(Stores.ROS2_JAZZY)
        self._made: dict[str, tuple[str, str]] = {}

    def of(self, kind: str) -> tuple[str, str]:
        """Definition and type hash of a message type such as `std_msgs/msg/String`.

        Raises:
            UnknownType: It is not installed.
        """
        if kind not in self._made:
            self._add(kind)
            definition, _ = self._store.generate_msgdef(kind, ros_version=2)
            self._made[kind] = definition, self._store.hash_rihs01(kind)
        return self._made[kind]

    def _add(self, kind: str) -> None:
        """Take in a type and all that it contains."""
        if kind in self._store.fielddefs:
            return
        package, folder, name = _parts(kind)
        try:
            file = _share(package) / folder / f"{name}.msg"
            types = get_types_from_msg(file.read_text(encoding="utf-8"), kind)
        except (PackageNotFoundError, OSError) as error:
            raise UnknownType(f"{kind}, which is not installed") from error
        for contained in _contained(types):
            if contained not in types:
                self._add(contained)
        self._store.register(types)


def type_hash(kind: str, definition: str) -> str:
    """Type hash of a message type, from its definition in a bag; empty where that cannot be read."""
    store = get_typestore(Stores.EMPTY)
    try:
        for k, text in enumerate(definition.split(SECTION)):
            name, body = (kind, text) if k == 0 else text.split("\n", 1)
            store.register(get_types_from_msg(body, name if "/msg/" in name else name.replace("/", "/msg/")))
        return store.hash_rihs01(kind)
    except Exception:  # whatever a foreign definition holds: the hash is a courtesy
        return ""


@cache
def is_installed(kind: str, definition: str) -> bool:
    """Whether a message type is installed here as a bag defines it: else its messages would be read as others."""
    try:
        installed, hashed = Definitions().of(kind)
    except UnknownType:
        return False
    return definition in (installed, "") or type_hash(kind, definition) in (hashed, "")


@cache
def message_class(kind: str) -> Any:
    """The class of a message type.

    Raises:
        UnknownType: It is not installed.
    """
    package, folder, name = _parts(kind)
    try:
        return getattr(importlib.import_module(f"{package}.{folder}"), name)
    except (ImportError, AttributeError) as error:
        raise UnknownType(f"{kind}, which is not installed") from error


def _share(package: str) -> Path:
    """Where a package has what it shares: in the workspace that is sourced, or beside this Python.

    Raises:
        PackageNotFoundError: Nowhere.
    """
    beside = Path(sys.prefix) / "share" / package
    return beside if beside.is_dir() else Path(get_package_share_directory(package))


def _parts(kind: str) -> list[str]:
    parts = kind.split("/")
    if len(parts) != 3 or parts[1] != "msg":
        raise UnknownType(f"{kind}, which is no message type")
    return parts


def _contained(types: Any) -> set[str]:
    """Names of the message types that the fields of definitions have."""
    found: set[str] = set()

    def look(desc: Any) -> None:
        if isinstance(desc, tuple | list):
            for part in desc:
                look(part)
        elif isinstance(desc, str) and desc.count("/") == 2:
            found.add(desc)

    for _constants, fields in types.values():
        for _name, desc in fields:
            look(desc)
    return found
