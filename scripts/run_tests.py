"""Run every check: ruff, the formatter, the type checker, then the tests; see --help."""

import _environment

_environment.enter()

import argparse
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

from _command_line import carry_out

PYTEST = ["-m", "pytest"]
QUICK = {
    "ruff check": ["-m", "ruff", "check", "--quiet"],
    "ruff format": ["-m", "ruff", "format", "--check", "--quiet"],
}
TYPES = {"types": ["-m", "basedpyright", "--warnings"]}
COMMANDS = "test/live/test_readme.py"
SWEEPS = "test/soup_lab/test_compare_sweep.py"
LAB = ("test/environment", "test/soup_lab")
# Two at a time, so that both processors have work to the end. Live nodes wait for messages, and tests for facts: what
# else the machine does makes them slower, and nothing else.
TOGETHER = {
    "live": [*PYTEST, "-m", "live", f"--ignore={COMMANDS}"],
    "others": [*PYTEST, "-m", "not live", *(f"--ignore={folder}" for folder in LAB)],
    "lab": [*PYTEST, "-m", "not live", *LAB, f"--ignore={SWEEPS}"],
    "commands": [*PYTEST, "-m", "live", COMMANDS],
    "sweeps": [*PYTEST, SWEEPS],
    **TYPES,
}


def main() -> int:
    """Run the checks; each is run whatever the others said."""
    parser = argparse.ArgumentParser(
        description="Run every check: ruff, the formatter, the type checker, then all tests (some 20 minutes on two "
        "cores). Exit status 0 only when all pass.",
        epilog="With arguments, these go to pytest, and only the tests that they name are run after the other checks; "
        "for instance: run_tests.py test/soup_sim -k layouts",
        usage="%(prog)s [-h] [ARGUMENTS OF PYTEST]",
        allow_abbrev=False,
    )
    _, chosen = parser.parse_known_args()
    passed = [check(name, arguments) for name, arguments in QUICK.items()]
    if chosen:
        passed += [check(name, arguments) for name, arguments in {**TYPES, "tests": [*PYTEST, *chosen]}.items()]
    else:
        with ThreadPoolExecutor(2) as pool:
            passed += pool.map(lambda entry: check(*entry, prefix=f"{entry[0]}: "), TOGETHER.items())
    if not all(passed):
        print("Not all checks passed.", file=sys.stderr)
    return 0 if all(passed) else 1


def check(name: str, arguments: list[str], prefix: str = "") -> bool:
    """Run one check, show what it says line by line, and tell how it went: whether it passed.

    Args:
        name: Of the check.
        arguments: What Python is to run.
        prefix: What its lines begin with, where several checks run at once.
    """
    print(f"== {name}", flush=True)
    began = time.monotonic()
    command = [sys.executable, *arguments]
    with subprocess.Popen(
        command, cwd=_environment.ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            print(f"{prefix}{line}", end="", flush=True)
    how = "failed" if process.returncode else "passed"
    if process.returncode < 0:
        how = f"ended by {signal.Signals(-process.returncode).name}"
    print(f"== {name}: {how} after {time.monotonic() - began:.0f} s", flush=True)
    return process.returncode == 0


if __name__ == "__main__":
    sys.exit(carry_out(main))
