"""Where a person's own code failed: the file and the line of an exception that came out of it."""

from __future__ import annotations

import sysconfig
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from soup_msgs_py.errors import InputError, RunError, printable

_OURS = Path(__file__).resolve().parents[2]
_LIBRARIES = tuple({Path(path).resolve() for path in sysconfig.get_paths().values()})
# What a policy may import, by the name that it had before, and where it is now.
MOVED = {
    "soup_managers.bitset": "soup_managers.kernels.bitset",
    "soup_managers.coordination": "soup_managers.fleets.coordinated and soup_managers.state",
    "soup_managers.fleets.coordinated.situation": "soup_managers.state.planning_state",
    "soup_managers.plans": "soup_managers.fleets.minimal.plans",
    "soup_managers.policies.coordinated": "soup_managers.fleets.coordinated.policies",
    "soup_managers.policies.fleet": "soup_managers.fleets.minimal.policies",
    "soup_managers.policies.planned": "soup_managers.fleets.planned.policies",
    "soup_managers.router": "soup_managers.traffic.router",
    "soup_managers.state.stock": "soup_managers.contents",
    **{f"soup_msgs_py.{name}": f"soup_msgs_py.warehouse.{name}" for name in ("layout", "tiles", "words", "cell_world")},
}


def told(error: BaseException) -> str:
    """An exception in one line: what it says, and the last line of a person's code that it came through."""
    said = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    if isinstance(error, ImportError) and error.name in MOVED:
        said = f"{said}; it is {MOVED[error.name]} now"
    place = where(error)
    return printable(f"{said} ({place})" if place else said, 1_000)


@contextmanager
def blaming() -> Iterator[None]:
    """Tell what a person's own code, a policy, raises during a run in one line with its file and line.

    Raises:
        RunError: It did; `SystemExit` is no way to end a run either.
    """
    try:
        yield
    except (InputError, RunError):
        raise
    except (Exception, SystemExit) as error:
        if not where(error):
            raise  # a fault of the warehouse itself
        raise RunError(f"a policy failed: {told(error)}") from error


def where(error: BaseException) -> str:
    """The last line that is neither the warehouse's nor a library's; empty where there is none."""
    if isinstance(error, SyntaxError) and error.filename:
        return f"{error.filename}, line {error.lineno}"
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if _is_a_persons(frame.filename):
            return f"{frame.filename}, line {frame.lineno}"
    return ""


def _is_a_persons(file: str) -> bool:
    path = Path(file)
    return path.is_absolute() and not any(path.is_relative_to(folder) for folder in (_OURS, *_LIBRARIES))
