"""Make sure a program runs with ROS 2, the pinned packages and a current build of soup_msgs.

Every program in this folder begins with ``import _environment`` and ``_environment.enter()``, before its
other imports. Standard library only: this runs under whatever ``python3`` the machine has.
``_setup.py`` holds the slow part.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
PYTHON = VENV / "bin" / "python"
LOCK_FILE = ROOT / "requirements.lock"
MESSAGES = ROOT / "src" / "soup_msgs"

# Written last by the set-up; each holds the fingerprint of what was installed.
PACKAGES_STAMP = VENV / "ready-packages"
MESSAGES_STAMP = VENV / "ready-messages"

RMW = "rmw_fastrtps_cpp"  # the only implementation of DDS that the wheels bring

# The ROS wheels restart the interpreter to set LD_LIBRARY_PATH unless this says that it is done.
BOOTSTRAP_GUARD = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"


def enter() -> None:
    """Return only in an interpreter that has everything: set up what is missing and restart in it."""
    if in_ros_workspace():
        return
    if not is_ready():
        import _setup

        _setup.bring_up_to_date()
    environment = run_environment()
    if Path(sys.prefix) == VENV and environment == dict(os.environ):
        return
    asked = os.environ.get("RMW_IMPLEMENTATION") or RMW
    if asked != RMW:
        print(f"RMW_IMPLEMENTATION: {asked} does not come as a wheel, {RMW} is used", file=sys.stderr)
    sys.stdout.flush()
    sys.stderr.flush()
    os.execve(PYTHON, [str(PYTHON), *sys.orig_argv[1:]], environment)


def in_ros_workspace() -> bool:
    """Tell whether this interpreter already has ROS and soup_msgs from a sourced workspace."""
    if Path(sys.prefix) == VENV or not foreign_prefixes(os.environ):
        return False
    return all(importlib.util.find_spec(name) for name in ("rclpy", "soup_msgs"))


def is_ready() -> bool:
    """Tell whether the virtual environment holds what the sources ask for. Costs milliseconds."""
    return (
        PYTHON.exists()
        and read(PACKAGES_STAMP) == packages_fingerprint()
        and read(MESSAGES_STAMP) == messages_fingerprint()
        and read(site_packages() / "soup_sources.pth") == source_folders()
        and kernels_folder().exists()
    )


def packages_fingerprint() -> str:
    """Hash the lock file, the place of the virtual environment and the interpreter it was made from."""
    return digest([LOCK_FILE.read_bytes(), os.fsencode(VENV), os.fsencode(PYTHON.resolve())])


def messages_fingerprint() -> str:
    """Hash every file of soup_msgs, and the packages it was built against."""
    parts = [packages_fingerprint().encode()]
    for file in sorted(MESSAGES.rglob("*")):
        if file.is_file():
            parts += [os.fsencode(file.relative_to(MESSAGES)), file.read_bytes()]
    return digest(parts)


def kernels_folder() -> Path:
    """Where machine code made by numba is kept: another folder whenever a source that it is made from changes.

    Numba looks at the file of a kernel alone, not at those whose kernels are part of it, and ends with an error where a
    module is gone that its old index names.
    """
    parts = [packages_fingerprint().encode()]
    for file in sorted(ROOT.glob("src/*/*/**/*.py")):
        content = file.read_bytes()
        if b"soup_msgs_py.kernel" in content:
            parts += [os.fsencode(file.relative_to(ROOT)), content]
    return VENV / "kernels" / digest(parts)[:16]


def source_folders() -> str:
    """List the folders of our Python packages, one a line, as a .pth file wants them."""
    return "".join(f"{setup.parent}\n" for setup in sorted(ROOT.glob("src/*/setup.py")))


def site_packages() -> Path:
    """Return the folder that pip installs into; one that does not exist while there is none."""
    return next(VENV.glob("lib/python3*/site-packages"), VENV / "lib" / "site-packages")


def run_environment() -> dict[str, str]:
    """Return the variables for programs in .venv: its libraries first, no other ROS mixed in."""
    environment = dict(os.environ)
    others = foreign_prefixes(environment)
    for name in ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH", "COLCON_PREFIX_PATH"):
        environment.pop(name, None)
    libraries = [str(VENV / "lib"), *sorted(map(str, site_packages().glob("ros_*.libs")))]
    for name, first in (("PYTHONPATH", []), ("LD_LIBRARY_PATH", libraries)):
        given = [entry for entry in environment.pop(name, "").split(os.pathsep) if entry]
        kept = [entry for entry in given if not is_below(entry, [*others, VENV])]
        if first or kept:
            environment[name] = os.pathsep.join([*first, *kept])
    environment["RMW_IMPLEMENTATION"] = RMW
    environment["NUMBA_CACHE_DIR"] = str(kernels_folder())
    # without it each process would translate all of its libraries anew, which takes most of its start
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    environment["PYTHONPYCACHEPREFIX"] = str(VENV / "bytecode")
    environment[BOOTSTRAP_GUARD] = "1"
    return environment


def foreign_prefixes(environment: os._Environ[str] | dict[str, str]) -> list[str]:
    """Return the installation prefixes of a sourced ROS workspace, our own left out."""
    prefixes = environment.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [prefix for prefix in prefixes if prefix and Path(prefix) != VENV]


def is_below(path: str, folders: list[str | Path]) -> bool:
    """Tell whether a path is one of the folders or in it."""
    return any(Path(path).is_relative_to(folder) for folder in folders)


def digest(parts: list[bytes]) -> str:
    """Hash a list of byte strings; where one ends and the next begins counts."""
    total = hashlib.sha256()
    for part in parts:
        total.update(len(part).to_bytes(8, "big"))
        total.update(part)
    return total.hexdigest()


def read(path: Path) -> str | None:
    """Return a file's text, or None where there is no such file."""
    try:
        return path.read_text()
    except OSError:
        return None
