"""The event log: every event as one line of JSON, only the fields that mean something."""

from __future__ import annotations

import json
from dataclasses import fields

from soup_msgs_py.command_line.output_files import Lines
from soup_msgs_py.messages import Event

_DEFAULTS = {f.name: f.default for f in fields(Event)}
_OPTIONAL = tuple(f.name for f in fields(Event) if f.name not in ("time", "sequence", "type"))


def event_line(event: Event) -> str:
    """One event as a line of JSON; times in nanoseconds' precision, places in micrometres'."""
    entry: dict[str, object] = {"time": round(event.time, 9), "sequence": event.sequence, "type": event.type.value}
    for name in _OPTIONAL:
        value = getattr(event, name)
        if value != _DEFAULTS[name]:
            entry[name] = round(value, 6) if isinstance(value, float) else value
    return json.dumps(entry, separators=(",", ":")) + "\n"


class EventLog:
    """Writes events to a text file as they happen."""

    def __init__(self, file: Lines) -> None:
        self._file = file

    def __call__(self, event: Event) -> None:
        """Write one event."""
        self._file.write(event_line(event))
