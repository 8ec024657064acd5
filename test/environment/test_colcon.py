"""The packages are ordinary ROS 2 packages: colcon builds them, `ros2 run` finds their programs."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import _environment

# Compiling all interfaces takes minutes, and the set-up has done it with the same CMakeLists.txt.
INTERFACES = {"msg": ["Event.msg"], "srv": ["Grab.srv"], "action": ["Drive.action"]}
PROGRAMS = {
    "soup_msgs": [],
    "soup_msgs_py": [],
    "soup_live": [],
    "soup_sim": ["world"],
    "soup_bots": ["bots"],
    "soup_managers": ["fleet_manager", "letter_manager", "word_manager"],
    "soup_lab": ["headless"],
    "soup_dashboard": ["dashboard"],
}


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder into which colcon has built and installed what is in src/, with one interface of each kind."""
    folder = tmp_path_factory.mktemp("colcon")
    sources = folder / "src"
    shutil.copytree(_environment.ROOT / "src", sources, ignore=shutil.ignore_patterns(*INTERFACES, "__pycache__"))
    for kind, names in INTERFACES.items():
        (sources / "soup_msgs" / kind).mkdir()
        for name in names:
            shutil.copy(_environment.MESSAGES / kind / name, sources / "soup_msgs" / kind)
    environment = _environment.run_environment()
    environment["AMENT_PREFIX_PATH"] = environment["CMAKE_PREFIX_PATH"] = str(_environment.VENV)
    environment["PATH"] = os.pathsep.join([str(_environment.VENV / "bin"), environment["PATH"]])
    bases = {"--build-base": "build", "--install-base": "install"}
    command = [sys.executable, "-m", "colcon", "--log-base", str(folder / "log"), "build"]
    command += ["--base-paths", str(sources)]
    for option, name in bases.items():
        command += [option, str(folder / name)]
    command += [
        "--cmake-args",
        "-G",
        "Ninja",
        f"-DPython3_EXECUTABLE={_environment.PYTHON}",
        "-DBUILD_TESTING=OFF",
    ]
    reply = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert reply.returncode == 0, reply.stdout + reply.stderr
    return folder / "install"


@pytest.mark.timeout(900)
@pytest.mark.parametrize("package", PROGRAMS)
def test_colcon_installs_the_package_where_ros2_looks_for_it(installed: Path, package: str):
    prefix = installed / package
    assert (prefix / "share" / "ament_index" / "resource_index" / "packages" / package).exists()
    assert (prefix / "share" / package / "package.xml").exists()


@pytest.mark.parametrize("package", PROGRAMS)
def test_ros2_run_finds_the_programs_of_the_package(installed: Path, package: str):
    folder = installed / package / "lib" / package
    found = sorted(file.name for file in folder.glob("*") if os.access(file, os.X_OK) and file.is_file())
    assert found == PROGRAMS[package]


def test_the_message_package_that_colcon_built_can_be_imported(installed: Path):
    folder = next((installed / "soup_msgs").glob("lib/python3*/site-packages"))
    environment = _environment.run_environment()
    environment["PYTHONPATH"] = str(folder)
    environment["LD_LIBRARY_PATH"] = f"{installed / 'soup_msgs' / 'lib'}:{environment['LD_LIBRARY_PATH']}"
    program = "import soup_msgs.msg as m; m.Event.__class__.__import_type_support__(); print(m.__file__)"
    reply = subprocess.run([sys.executable, "-c", program], env=environment, text=True, capture_output=True, check=True)
    assert reply.stdout.startswith(str(folder))
