"""The rules that hold over all sources: who may import whom, where ROS may appear, what no module does."""

import ast
from collections.abc import Iterator
from fnmatch import fnmatch
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import _environment

SOURCES = _environment.ROOT / "src"
PACKAGES = ("soup_msgs_py", "soup_live", "soup_sim", "soup_bots", "soup_managers", "soup_lab", "soup_dashboard")

# A package and the packages of ours that it may import, itself left out.
MAY_IMPORT = {
    "soup_msgs_py": set(),
    "soup_live": {"soup_msgs_py"},
    "soup_sim": {"soup_msgs_py", "soup_live"},
    "soup_bots": {"soup_msgs_py", "soup_live"},
    "soup_managers": {"soup_msgs_py", "soup_live"},
    "soup_dashboard": {"soup_msgs_py", "soup_live"},
    "soup_lab": set(PACKAGES),
}

# The rooms of soup_managers from the ground up: each may know those on the floors below.
MANAGERS = "soup_managers"
FLOORS = (
    {"kernels", "contents"},
    {"view", "explain"},
    {"manager", "policies", "traffic", "planners"},
    {"stations", "state"},
    {"decisions"},
    {"fleets"},
    {"nodes"},
)

# The only modules that may know ROS, below src/<package>/: the nodes and what serves them.
ROS_MODULES = (
    "*_node.py",
    "soup_msgs_py/wire/*.py",
    "soup_live/*.py",
    "soup_bots/bot_host.py",
    "soup_bots/bots_program.py",
    "soup_sim/world_program.py",
    "soup_sim/time_services.py",
    "soup_sim/checkpoint_keeper.py",
    "soup_lab/bags/*.py",
    "soup_lab/launch/*.py",
)
ROS_PREFIXES = ("rcl", "soup_live", "rosidl", "rmw", "ament", "rosbag2", "tf2")
ROS_SUFFIXES = ("_msgs", "_srvs", "_interfaces")


def modules() -> list[Path]:
    """All modules of our packages, as paths below src/<package>/."""
    return sorted(
        file.relative_to(SOURCES / name) for name in PACKAGES for file in (SOURCES / name / name).rglob("*.py")
    )


def read(module: Path) -> ast.Module:
    return ast.parse((SOURCES / module.parts[0] / module).read_text())


def imported(tree: ast.AST) -> Iterator[tuple[str, int]]:
    """Yield the top-level name and the line of every import, also those inside functions and by importlib."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name.split(".")[0], node.lineno
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield node.module.split(".")[0], node.lineno
        elif isinstance(node, ast.Call) and name_of(node.func) in ("import_module", "__import__") and node.args:
            first = node.args[0]
            if isinstance(first, ast.Constant) and isinstance(first.value, str):
                yield first.value.split(".")[0], node.lineno


def name_of_module(module: Path) -> str:
    return ".".join(module.with_suffix("").parts).removesuffix(".__init__")


NAMES = {name_of_module(module) for module in modules()}


def modules_imported(module: Path) -> Iterator[str]:
    """Yield the modules of ours that one imports, also those inside functions."""
    for node in ast.walk(read(module)):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] in PACKAGES:
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                yield whole if whole in NAMES else node.module
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in NAMES)


def name_of(function: ast.expr) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def is_ros(name: str) -> bool:
    return name.startswith(ROS_PREFIXES) or name.endswith(ROS_SUFFIXES)


def yaml_loads(tree: ast.AST) -> Iterator[int]:
    """Yield the lines that call a loader of PyYAML which can make arbitrary objects."""
    unsafe = {"load", "load_all", "unsafe_load", "unsafe_load_all", "full_load", "full_load_all"}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and name_of(node.value) == "yaml" and node.attr in unsafe:
            yield node.lineno
        elif isinstance(node, ast.ImportFrom) and node.module == "yaml":
            yield from (node.lineno for alias in node.names if alias.name in unsafe)


def test_every_package_is_looked_at():
    assert {module.parts[0] for module in modules()} == set(PACKAGES)
    assert {file.parent.name for file in SOURCES.glob("*/setup.py")} == set(PACKAGES)


@pytest.mark.parametrize("module", modules(), ids=str)
def test_a_module_imports_only_packages_that_its_own_may_know(module: Path):
    own = module.parts[0]
    known = MAY_IMPORT[own] | {own}
    wrong = [
        f"{module}:{line} imports {name}"
        for name, line in imported(read(module))
        if name in PACKAGES and name not in known
    ]
    assert not wrong


def test_no_module_imports_itself_by_way_of_others():
    graph = {name_of_module(module): set(modules_imported(module)) for module in modules()}
    TopologicalSorter(graph).prepare()  # CycleError names the circle


def floor(name: str) -> int:
    """The floor of a module of soup_managers."""
    room = name.split(".")[1]
    return next(number for number, rooms in enumerate(FLOORS) if room in rooms)


def test_rooms_of_the_managers_know_only_those_below_them():
    wrong = [
        f"{own} imports {other}"
        for module in modules()
        if module.parts[0] == MANAGERS and (own := name_of_module(module)) != MANAGERS
        for other in modules_imported(module)
        if other.startswith(f"{MANAGERS}.")
        if floor(other) > floor(own) or (floor(other) == floor(own) and other.split(".")[1] != own.split(".")[1])
    ]
    assert not wrong


@pytest.mark.parametrize("module", modules(), ids=str)
def test_ros_appears_only_in_the_shells(module: Path):
    if any(fnmatch(str(module), pattern) for pattern in ROS_MODULES):
        return
    wrong = [f"{module}:{line} imports {name}" for name, line in imported(read(module)) if is_ros(name)]
    assert not wrong


@pytest.mark.parametrize("name", ["rclpy", "soup_msgs", "std_srvs", "builtin_interfaces", "geometry_msgs"])
def test_the_rule_knows_ros_by_name(name: str):
    assert list(imported(ast.parse(f"def f():\n    from {name}.msg import X"))) == [(name, 2)]
    assert is_ros(name)


def test_our_own_python_is_not_taken_for_ros():
    assert not any(is_ros(name) for name in (*(set(PACKAGES) - {"soup_live"}), "numpy", "yaml", "rich", "rosbags"))


def every_file() -> list[Path]:
    files = [*SOURCES.rglob("*.py"), *(_environment.ROOT / "scripts").rglob("*.py")]
    return sorted(file.relative_to(_environment.ROOT) for file in files)


@pytest.mark.parametrize("file", every_file(), ids=str)
def test_a_file_says_what_it_is_and_loads_yaml_safely(file: Path):
    tree = ast.parse((_environment.ROOT / file).read_text())
    assert ast.get_docstring(tree), f"{file} has no docstring"
    assert not list(yaml_loads(tree)), f"{file} loads YAML in a way that can run code"
