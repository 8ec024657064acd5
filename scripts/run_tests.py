"""Run every check: ruff, the formatter, the type checker, then the tests. Extra arguments go to pytest.

Exit status 0 only when all pass.
"""

import _environment

_environment.enter()

import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

PYTEST = ["-m", "pytest"]
QUICK = {
    "ruff check": ["-m", "ruff", "check", "--quiet"],
    "ruff format": ["-m", "ruff", "format", "--check", "--quiet"],
}
TYPES = {"types": ["-m", "basedpyright", "--warnings"]}
# Two at a time; live nodes are tested alone afterwards, since they need the processors to keep their promises.
TOGETHER = {
    "tests of the lab and the environment": [*PYTEST, "-m", "not live", "test/environment", "test/soup_lab"],
    "tests of all other packages": [
        *PYTEST, "-m", "not live", "--ignore=test/environment", "--ignore=test/soup_lab", "--ignore=test/live",
    ],
    **TYPES,
}  # fmt: skip
ALONE = {"live tests": [*PYTEST, "-m", "live"]}


def main() -> int:
    """Run the checks; each is run whatever the others said."""
    passed = [check(name, arguments) for name, arguments in QUICK.items()]
    if sys.argv[1:]:
        chosen = {**TYPES, "tests": [*PYTEST, *sys.argv[1:]]}
        passed += [check(name, arguments) for name, arguments in chosen.items()]
    else:
        with ThreadPoolExecutor(2) as pool:
            passed += pool.map(lambda entry: check(*entry, aside=True), TOGETHER.items())
        passed += [check(name, arguments) for name, arguments in ALONE.items()]
    if not all(passed):
        print("Not all checks passed.", file=sys.stderr)
    return 0 if all(passed) else 1


def check(name: str, arguments: list[str], *, aside: bool = False) -> bool:
    """Run one check and tell how it went; `aside`: show what it says when it is over. Whether it passed."""
    command = [sys.executable, *arguments]
    if aside:
        with tempfile.TemporaryFile("w+") as said:
            status = subprocess.run(command, cwd=_environment.ROOT, check=False, stdout=said, stderr=said).returncode
            said.seek(0)
            print(f"== {name}\n{said.read()}", end="", flush=True)
    else:
        print(f"== {name}", flush=True)
        status = subprocess.run(command, cwd=_environment.ROOT, check=False).returncode
    print(f"== {name}: {'failed' if status else 'passed'}", flush=True)
    return status == 0


if __name__ == "__main__":
    sys.exit(main())
