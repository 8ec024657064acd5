"""What a person meets who starts a program: on a machine that lacks something, twice at once, interrupted."""

import fcntl
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import _environment
import _setup

BASE_PYTHON = getattr(sys, "_base_executable", sys.executable)
PROGRAM = "import _environment\n_environment.enter()\nimport sys\nprint('ran in', sys.prefix)\n"


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A copy of the project in which nothing has been set up, with one program to start."""
    folder = tmp_path / "clone"
    (folder / "scripts").mkdir(parents=True)
    for name in ("_environment.py", "_setup.py"):
        shutil.copy(_environment.ROOT / "scripts" / name, folder / "scripts")
    shutil.copy(_environment.LOCK_FILE, folder)
    shutil.copytree(_environment.MESSAGES, folder / "src" / "soup_msgs")
    (folder / "scripts" / "program.py").write_text(PROGRAM)
    return folder


@pytest.fixture
def paths(clone: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same copy, for calls of the set-up's functions in this process."""
    venv = clone / ".venv"
    for name, value in {
        "ROOT": clone,
        "VENV": venv,
        "PYTHON": venv / "bin" / "python",
        "LOCK_FILE": clone / "requirements.lock",
        "MESSAGES": clone / "src" / "soup_msgs",
        "PACKAGES_STAMP": venv / "ready-packages",
        "MESSAGES_STAMP": venv / "ready-messages",
    }.items():
        monkeypatch.setattr(_environment, name, value)
    monkeypatch.setattr(_setup, "LOG_FILE", venv / "setup.log")
    monkeypatch.setattr(_setup, "BUILD", venv / "build")
    return clone


@pytest.fixture
def commands(paths: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """The names of the set-up's commands, which are recorded instead of run."""
    seen: list[str] = []

    def record(_self: object, arguments: list[str], _progress: object) -> None:
        known = [name for name in ("venv", "pip", "-c") if name in arguments]
        seen.append({"-c": "kernels"}.get(known[0], known[0]) if known else "cmake")
        if seen[-1] == "venv":
            _environment.PYTHON.parent.mkdir(parents=True)
            _environment.PYTHON.symlink_to(BASE_PYTHON)
            (paths / ".venv" / "lib" / "python3.11" / "site-packages").mkdir(parents=True)

    monkeypatch.setattr(_setup.Setup, "command", record)
    yield seen


def start(clone: Path, **variables: str) -> "subprocess.Popen[str]":
    environment = {"PATH": os.environ["PATH"], **variables}
    command = [BASE_PYTHON, str(clone / "scripts" / "program.py")]
    return subprocess.Popen(
        command,
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        stdin=subprocess.DEVNULL,
    )


def first_line(process: "subprocess.Popen[str]") -> str:
    assert process.stderr is not None
    return process.stderr.readline()


def test_a_later_start_has_nothing_to_do_and_is_silent():
    program = "import sys; sys.path[:0] = ['scripts']; import _environment as e; e.enter(); print(sys.prefix)"
    reply = subprocess.run(
        [BASE_PYTHON, "-c", program],
        cwd=_environment.ROOT,
        env={"PATH": os.environ["PATH"]},
        capture_output=True,
        text=True,
        check=True,
    )
    assert reply.stdout.strip() == str(_environment.VENV)
    assert reply.stderr == ""


def test_libraries_are_translated_once_and_not_at_each_start(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    environment = _environment.run_environment()
    assert "PYTHONDONTWRITEBYTECODE" not in environment
    assert Path(environment["PYTHONPYCACHEPREFIX"]).is_relative_to(_environment.VENV)


def test_inside_the_ready_environment_nothing_is_restarted(monkeypatch: pytest.MonkeyPatch):
    environment = _environment.run_environment()
    monkeypatch.setattr(os, "environ", environment)
    assert _environment.run_environment() == environment
    monkeypatch.setattr(os, "execve", lambda *_: pytest.fail("restarted"))
    _environment.enter()


def test_a_missing_compiler_is_named_with_the_command_that_installs_it(clone: Path):
    process = start(clone, PATH="/nowhere")
    _, said = process.communicate(timeout=30)
    assert process.returncode == 1
    assert said == "Set-up failed: a C++ compiler not found. Install with: sudo apt-get install g++\n"
    assert not (clone / ".venv").exists()


def test_a_missing_venv_module_is_named_with_the_command_that_installs_it(paths: Path, tmp_path: Path):
    python = tmp_path / "python3"
    python.write_text(f'#!/bin/sh\ncase "$2" in *ensurepip*) exit 1;; esac\nexec {BASE_PYTHON} "$@"\n')
    python.chmod(0o755)
    setup = _setup.Setup(_setup.StatusLine(), 0)
    setup.base = str(python)
    with pytest.raises(_setup.StepFailedError, match=r"sudo apt-get install python3-venv$"):
        setup.refuse_if_something_is_missing()


@pytest.mark.parametrize("name", ["a$b", "a'b", 'a"b', "a;b", "a:b", "a\\b", "käfig", "a\nb"])
def test_a_path_that_the_build_tools_cannot_take_is_told_before_anything_is_fetched(clone: Path, name: str):
    process = start(clone.rename(clone.with_name(name)))
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (1, "")
    assert err.startswith("Set-up failed: the folder ") and err.count("\n") == 1
    assert f"has {name.strip('abkfig')!a} in its path" in err
    assert not (clone.with_name(name) / ".venv").exists()


def test_an_unsupported_python_is_refused_unless_another_is_there(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setattr(sys, "version_info", (3, 9, 1))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(_setup.StepFailedError, match=r"need one from 3\.11 to 3\.13\. Install with"):
        _setup.choose_interpreter()
    (tmp_path / "python3.12").symlink_to(BASE_PYTHON)
    assert _setup.choose_interpreter() == str(tmp_path / "python3.12")


def test_ctrl_c_during_the_set_up_ends_with_one_line_and_130(clone: Path):
    process = start(clone)
    assert first_line(process) == "Making .venv (first start only)\n"
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=30)
    assert process.returncode == 130
    assert said == "Set-up interrupted. The next start repairs it.\n"


def test_a_second_start_waits_and_says_so(clone: Path):
    with (clone / "requirements.lock").open() as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        process = start(clone)
        assert first_line(process) == "Another start is setting up .venv; waiting for it\n"
        process.terminate()
        _, said = process.communicate(timeout=30)
    assert process.returncode == 143
    assert said == "Set-up interrupted. The next start repairs it.\n"


def test_everything_is_set_up_once_and_then_only_what_changed(paths: Path, commands: list[str]):
    _setup.bring_up_to_date()
    assert commands == ["venv", "pip", "cmake", "cmake", "cmake", "kernels"]
    assert _environment.is_ready()

    commands.clear()
    _setup.bring_up_to_date()
    assert commands == []

    (paths / "src" / "soup_msgs" / "msg" / "Another.msg").write_text("int32 x\n")
    assert not _environment.is_ready()
    _setup.bring_up_to_date()
    assert commands == ["cmake", "cmake", "cmake", "kernels"]

    commands.clear()
    with (paths / "requirements.lock").open("a") as lock:
        lock.write("something-new==1.0\n")
    _setup.bring_up_to_date()
    assert commands == ["pip", "cmake", "cmake", "cmake", "kernels"]


def test_kernels_are_compiled_anew_when_any_of_their_sources_has_changed(paths: Path, commands: list[str]):
    source = paths / "src" / "soup_sim" / "soup_sim" / "fast.py"
    source.parent.mkdir(parents=True)
    source.write_text("from soup_msgs_py.kernel import kernel\n")
    _setup.bring_up_to_date()
    folders = [_environment.kernels_folder()]
    for k in range(4):
        source.write_text(f"from soup_msgs_py.kernel import kernel\n\n# {k}\n")
        assert not _environment.is_ready()
        commands.clear()
        _setup.bring_up_to_date()
        assert commands == ["kernels"]
        folders.append(_environment.kernels_folder())
        assert _environment.run_environment()["NUMBA_CACHE_DIR"] == str(folders[-1])
    assert len(set(folders)) == 5
    assert [folder.exists() for folder in folders] == [False, False, True, True, True]
    (source.parent / "slow.py").write_text("pass\n")
    assert _environment.is_ready()


def test_an_interrupted_installation_begins_again_from_an_empty_environment(
    paths: Path, commands: list[str], monkeypatch: pytest.MonkeyPatch
):
    with monkeypatch.context() as patch:
        patch.setattr(_setup, "write", lambda *_: os.kill(os.getpid(), signal.SIGTERM))
        with pytest.raises(SystemExit) as end:
            _setup.bring_up_to_date()
    assert end.value.code == 143
    (paths / ".venv" / "half").touch()
    commands.clear()
    _setup.bring_up_to_date()
    assert commands == ["venv", "pip", "cmake", "cmake", "cmake", "kernels"]
    assert not (paths / ".venv" / "half").exists()


def test_a_moved_project_is_set_up_anew(paths: Path, commands: list[str], monkeypatch: pytest.MonkeyPatch):
    _setup.bring_up_to_date()
    moved = paths.with_name("moved")
    paths.rename(moved)
    monkeypatch.setattr(_environment, "VENV", moved / ".venv")
    monkeypatch.setattr(_environment, "LOCK_FILE", moved / "requirements.lock")
    monkeypatch.setattr(_environment, "PACKAGES_STAMP", moved / ".venv" / "ready-packages")
    assert _environment.read(_environment.PACKAGES_STAMP) != _environment.packages_fingerprint()


def test_a_new_package_folder_becomes_importable(paths: Path, commands: list[str]):
    _setup.bring_up_to_date()
    package = paths / "src" / "soup_new"
    package.mkdir()
    (package / "setup.py").touch()
    assert not _environment.is_ready()
    _setup.bring_up_to_date()
    assert str(package) in (_environment.site_packages() / "soup_sources.pth").read_text()


def test_inside_a_sourced_workspace_the_program_runs_where_it_is(clone: Path, tmp_path: Path):
    workspace = tmp_path / "workspace"
    for name in ("rclpy", "soup_msgs"):
        (workspace / name).mkdir(parents=True)
        (workspace / name / "__init__.py").touch()
    process = start(clone, AMENT_PREFIX_PATH=str(workspace), PYTHONPATH=str(workspace))
    said, complaints = process.communicate(timeout=30)
    assert (said, complaints) == (f"ran in {sys.base_prefix}\n", "")


def test_another_ros_does_not_leak_into_the_environment(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("AMENT_PREFIX_PATH", "/opt/ros/other")
    monkeypatch.setenv("PYTHONPATH", "/opt/ros/other/lib/python3.12/site-packages:/mine")
    monkeypatch.setenv("LD_LIBRARY_PATH", "/opt/ros/other/lib:/mine/lib")
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")
    environment = _environment.run_environment()
    assert "AMENT_PREFIX_PATH" not in environment
    assert environment["PYTHONPATH"] == "/mine"
    assert environment["LD_LIBRARY_PATH"].startswith(str(_environment.VENV / "lib"))
    assert environment["LD_LIBRARY_PATH"].endswith(":/mine/lib")
    assert "/opt/ros" not in environment["LD_LIBRARY_PATH"]
    assert environment["RMW_IMPLEMENTATION"] == "rmw_fastrtps_cpp"


def test_soup_msgs_travels_between_two_ros_nodes():
    program = """
import sys; sys.path.insert(0, 'scripts'); import _environment; _environment.enter()
import time, rclpy
from soup_msgs.msg import Event
rclpy.init()
node = rclpy.create_node('travels')
seen = []
node.create_subscription(Event, 'event', seen.append, 10)
publisher = node.create_publisher(Event, 'event', 10)
end = time.monotonic() + 20
while not seen and time.monotonic() < end:
    publisher.publish(Event())
    rclpy.spin_once(node, timeout_sec=0.1)
rclpy.shutdown()
assert seen and seen[0] == Event()
"""
    variables = {**os.environ, "ROS_DOMAIN_ID": str(os.getpid() % 100 + 1)}
    subprocess.run([BASE_PYTHON, "-c", program], cwd=_environment.ROOT, env=variables, check=True, timeout=60)


def test_that_another_implementation_of_dds_was_asked_for_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")
    monkeypatch.setattr(_environment, "in_ros_workspace", lambda: False)
    monkeypatch.setattr(_environment, "is_ready", lambda: True)
    entered: list[dict[str, str]] = []
    monkeypatch.setattr(os, "execve", lambda _program, _arguments, environment: entered.append(environment))
    _environment.enter()
    said = capsys.readouterr().err
    assert said == "RMW_IMPLEMENTATION: rmw_cyclonedds_cpp does not come as a wheel, rmw_fastrtps_cpp is used\n"
    assert entered[0]["RMW_IMPLEMENTATION"] == "rmw_fastrtps_cpp"
