"""The house: a file imports only files of a lower rank, and nothing happens at import."""

import ast
import graphlib
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import ehamj

PACKAGE = Path(__file__).parents[1] / "src" / "ehamj"
MODULES = sorted(PACKAGE.rglob("*.py"))

RANKS = (
    (
        "errors",
        "above",
        "arrays",
        "bounds",
        "caches",
        "interruption",
        "labels",
        "notebook",
        "opened",
        "plain",
        "stopped",
        "unfinished",
    ),
    (
        "settings",
        "registry",
        "extras",
        "findings",
        "scenario_files",
        "folders",
        "compiled",
        "signals",
        "plots",
        "columns",
        "growing",
    ),
    ("belonging",),
    ("isolator", "estimate", "slides", "series"),
    ("plant",),
    ("records",),
    ("criteria",),
    ("memory", "ground", "forces", "judge"),
    ("control",),
    ("faults", "measured"),
    ("mujoco",),
    ("linear",),
    ("synthesis",),
    ("scenario",),
    ("variables",),
    ("views", "result", "smallmotion"),
    ("designs", "pages"),
    ("run", "replay"),
    ("rig",),
    ("evaluation", "paper"),
    ("merits",),
    ("report", "studies"),
    ("design", "export", "verify", "store", "campaign"),
    ("identification",),
    ("bench",),
    ("cli", "__init__"),
)
"""Rooms of the package from the ground floor up; rooms of one rank do not know each other."""

RANK = {room: rank for rank, rooms in enumerate(RANKS) for room in rooms}


def room_of(path: Path) -> str:
    """The room that a file belongs to: its package, or itself."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


@cache
def imported(path: Path) -> set[str]:
    """What a file imports from ehamj, by its dotted names, but for what it needs for type checking only."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    typing_only = {
        id(node)
        for block in ast.walk(tree)
        if isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING"
        for node in ast.walk(block)
    }
    names: set[str] = set()
    for node in ast.walk(tree):
        if id(node) in typing_only:
            continue
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return {name for name in names if name.startswith("ehamj.")}


def imported_rooms(path: Path) -> set[str]:
    """Rooms of ehamj that a file imports."""
    return {name.split(".")[1] for name in imported(path) if "." in name} & set(RANK)


def test_there_is_no_circle_among_files() -> None:
    """Within a room too, files can be put in an order in which each imports only earlier ones."""
    named = {".".join(("ehamj", *path.relative_to(PACKAGE).with_suffix("").parts)): path for path in MODULES}
    graph = {name: imported(path) & named.keys() for name, path in named.items()}
    list(graphlib.TopologicalSorter(graph).static_order())  # raises CycleError, which names the circle


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_go_down(path: Path) -> None:
    """Every import goes to a lower rank, or stays in the room."""
    own = room_of(path)
    assert own in RANK, f"{own} has no rank: add it to RANKS where it belongs"
    upward = {room for room in imported_rooms(path) if room != own and RANK[room] >= RANK[own]}
    assert not upward, f"{path.name} (rank {RANK[own]}) imports {upward}"


SLOW = ("obspy", "rerun", "control", "slycot", "matplotlib", "nptdms", "idelib", "pyuff", "pandas", "xarray", "h5py")
SLOWER = (*SLOW, "mujoco", "numba", "jinja2", "scipy.linalg", "scipy.signal", "scipy.interpolate", "scipy.optimize")
"""What nobody needs who asks for help or mistypes a word, and takes a tenth of a second or more to import."""

MAIN = "import sys; sys.argv[1:] = {arguments}; from ehamj.cli import main; main()"
WITHOUT: dict[str, tuple[str, tuple[str, ...]]] = {
    "import ehamj": ("import ehamj, ehamj.cli", (*SLOWER, "pydantic", "numpy")),
    "--help": (MAIN.format(arguments=["--help"]), (*SLOWER, "numpy")),
    "a mistyped command": (MAIN.format(arguments=["rnu"]), (*SLOWER, "numpy")),
    "scenarios": (MAIN.format(arguments=["scenarios"]), (*SLOWER, "numpy")),
    "a mistyped option": (MAIN.format(arguments=["run", "--sett", "duration=1"]), (*SLOWER, "numpy")),
    "a mistyped scenario": (MAIN.format(arguments=["run", "vc-c-flor"]), (*SLOWER, "numpy")),
    "a mistyped key": (MAIN.format(arguments=["run", "vc-c-floor", "--set", "machine.mas=4500"]), SLOWER),
    "one for another command": (MAIN.format(arguments=["modes", "--set", "machine.mas=4500"]), SLOWER),
    "one for a study": (MAIN.format(arguments=["study", "gains", "--json", "vc-c-floor", "--set=sead=1"]), SLOWER),
    "load a scenario": ("from ehamj import load_scenario; load_scenario('vc-c-floor').plant", SLOWER),
}
"""What is done, and what must not be imported for it."""


@pytest.mark.parametrize("done", WITHOUT)
def test_what_should_be_at_once_imports_nothing_slow(done: str) -> None:
    """Help, lists and refusals wait for nothing that they do not need: how long that takes, no test measures."""
    code, without = WITHOUT[done]
    told = (
        "import atexit, sys; "
        f"atexit.register(lambda: print('IMPORTED', *sorted(set({without}) & set(sys.modules)), file=sys.stderr)); "
    )
    said = subprocess.run([sys.executable, "-c", told + code], capture_output=True, text=True, check=False).stderr
    assert "Traceback" not in said, said
    assert said.splitlines()[-1].split() == ["IMPORTED"], said


def test_import_installs_no_callback() -> None:
    code = "import sys, ehamj.run.simulate, ehamj.mujoco.hold as hold; sys.exit(any(hold.installed().values()))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_every_public_name_is_where_a_type_checker_sees_it() -> None:
    """The names that are found when they are used are those that `import ehamj` shows to a type checker."""
    tree = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    shown = {
        alias.asname: node.module for node in block.body if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    assert {name: f"ehamj.{home}" for name, home in ehamj._HOME.items()} == shown
    assert all(getattr(ehamj, name) is not None for name in ehamj.__all__)
