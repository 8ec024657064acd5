"""Run every check: ruff, the formatter, the type checker, then the tests. Extra arguments go to pytest.

Exit status 0 only when all pass.
"""

import _environment

_environment.enter()

import subprocess
import sys

CHECKS = {
    "ruff check": ["-m", "ruff", "check", "--quiet"],
    "ruff format": ["-m", "ruff", "format", "--check", "--quiet"],
    "types": ["-m", "basedpyright", "--warnings"],
    "tests": ["-m", "pytest"],
}


def main() -> int:
    """Run the checks one after the other; each is run whatever the others said."""
    failed = []
    for name, arguments in CHECKS.items():
        extra = sys.argv[1:] if name == "tests" else []
        print(f"== {name}", flush=True)
        command = [sys.executable, *arguments, *extra]
        if subprocess.run(command, cwd=_environment.ROOT, check=False).returncode:
            failed.append(name)
            print(f"== {name}: failed", flush=True)
        elif name != "tests":
            print(f"== {name}: passed", flush=True)
    if failed:
        print(f"Failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
