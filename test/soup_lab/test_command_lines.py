"""A person at a terminal: help comes at once and says it all, Ctrl-C and `| head` end a program without a traceback."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

import _environment
from soup_bots.steering import KNOWN as STEERING
from soup_lab.headless.arguments import DEFAULT_DURATION_S, parse
from soup_lab.lab_arguments import PLANNERS, parse_swap
from soup_managers.fleets.make import FLEET
from soup_managers.planners.known import PLANNERS as KNOWN_PLANNERS
from soup_managers.policies import LETTER, WORD
from soup_msgs_py.policies import NAMES

SCRIPTS = _environment.ROOT / "scripts"
PATIENCE_S = 100.0
SLOW = ("numpy", "numba", "scipy", "rclpy", "soup_msgs", "rich", "nicegui", "matplotlib", "rosbags", "dask")  # to load
PROGRAMS = sorted(file.stem for file in SCRIPTS.glob("*.py") if not file.stem.startswith("_"))


def run(*command: str, folder: Path | None = None) -> subprocess.Popen[str]:
    """Start Python, away from any terminal."""
    return subprocess.Popen(
        [sys.executable, *command],
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize("script", PROGRAMS)
def test_help_is_told_before_the_program_is_loaded(script: str):
    loaded = f"""
import runpy, sys
sys.path.insert(0, {str(SCRIPTS)!r})
sys.argv = [{script!r}, "--help"]
try:
    runpy.run_path({str(SCRIPTS / f"{script}.py")!r}, run_name="__main__")
except SystemExit as end:
    print(end.code, [name for name in {SLOW} if name in sys.modules])
"""
    out, err = run("-c", loaded).communicate(timeout=PATIENCE_S)
    assert out.splitlines()[-1] == "0 []", err
    assert "usage:" in out


def test_the_names_of_policies_in_the_help_are_those_that_there_are():
    known = {"word": WORD, "letter": LETTER, "fleet": FLEET, "bot": STEERING}
    assert {role: tuple(sorted(policies)) for role, policies in known.items()} == NAMES


def test_the_names_of_planners_in_the_help_are_those_that_there_are():
    assert tuple(KNOWN_PLANNERS) == PLANNERS


def test_what_is_wrong_with_the_part_that_takes_over_is_told_before_the_program_is_loaded(
    capsys: pytest.CaptureFixture[str],
):
    for wrong in (["fleet", "--polcy", "x"], ["0-5", "--take-over"], ["soup"], [""]):
        with pytest.raises(SystemExit) as ends:
            parse_swap(wrong)
        assert ends.value.code == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
    assert parse_swap(["fleet", "--policy", "minimal"]) == ("fleet", ["--policy", "minimal", "--take-over"])
    assert parse_swap(["0-5", "--seed", "3"]) == ("0-5", ["0-5", "--seed", "3"])


def test_the_help_of_a_run_in_one_process_names_its_end_and_its_policies(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit):
        parse(["--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert f"simulated seconds (default: {DEFAULT_DURATION_S:,.0f})" in said
    assert "Ctrl-C" not in said
    for names in NAMES.values():
        assert ", ".join(names) in said


def test_the_help_of_the_tests_runs_no_check():
    process = run(str(SCRIPTS / "run_tests.py"), "--help")
    out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0
    assert "usage:" in out
    assert "== " not in out


def started(folder: Path, module: str) -> subprocess.Popen[str]:
    """Start a module as the programs in `scripts/` start theirs."""
    (folder / "program.py").write_text(module)
    start = f"import sys; sys.path[:0] = [{str(SCRIPTS)!r}, '.']; from _command_line import start"
    return run("-c", f"{start}; sys.exit(start('program'))", folder=folder)


def line(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline()


def test_ctrl_c_while_a_program_is_loaded_ends_it_without_a_word(tmp_path: Path):
    process = started(tmp_path, "import time\nprint('loads', flush=True)\ntime.sleep(1000)\n")
    assert line(process) == "loads\n"
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=PATIENCE_S) == ("", "")
    assert process.returncode == -signal.SIGINT


def test_ctrl_c_in_a_program_that_says_nothing_about_it_ends_it_without_a_word(tmp_path: Path):
    program = "import time\ndef main():\n    print('runs', flush=True)\n    time.sleep(1000)\n"
    process = started(tmp_path, program)
    assert line(process) == "runs\n"
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=PATIENCE_S) == ("", "")
    assert process.returncode == 130


@pytest.mark.parametrize("flush", [True, False])
def test_a_program_whose_reader_has_gone_ends_without_a_traceback(tmp_path: Path, flush: bool):
    program = (
        "import sys\ndef main():\n    print('first', flush=True)\n    sys.stdin.read()\n"
        f"    for _ in range(10):\n        print('more', flush={flush})\n    return 0\n"
    )
    process = started(tmp_path, program)
    assert line(process) == "first\n"
    assert process.stdin is not None
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    process.stdin.close()  # now it may go on
    assert process.stderr.read() == ""
    assert process.wait(PATIENCE_S) == 141
