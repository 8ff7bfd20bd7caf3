"""The house: a file imports only files of a lower rank, and nothing happens at import."""

import ast
import graphlib
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "src" / "ehamj"
MODULES = sorted(PACKAGE.rglob("*.py"))

RANKS = (
    ("errors", "arrays", "labels", "plain"),
    ("settings", "registry", "findings", "scenario_files", "folders", "compiled", "signals", "plots"),
    ("isolator", "estimate", "slides"),
    ("plant",),
    ("records",),
    ("criteria",),
    ("memory", "ground", "forces", "judge"),
    ("control",),
    ("faults",),
    ("mujoco", "scenario"),
    ("linear", "result", "smallmotion"),
    ("designs", "pages"),
    ("run", "replay"),
    ("rig", "bench"),
    ("evaluation",),
    ("paper", "report", "studies"),
    ("design", "verify", "store"),
    ("cli", "__init__"),
)
"""Rooms of the package from the ground floor up; rooms of one rank do not know each other."""

RANK = {room: rank for rank, rooms in enumerate(RANKS) for room in rooms}


def room_of(path: Path) -> str:
    """The room that a file belongs to: its package, or itself."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


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


@pytest.mark.parametrize("module", ["ehamj", "ehamj.cli"])
def test_import_does_nothing(module: str) -> None:
    """Importing ehamj, and starting its command line, installs no callback and pulls in none of the slow libraries."""
    code = (
        f"import sys, {module}; from ehamj.mujoco.hold import installed; "
        "slow = {'obspy', 'rerun', 'control', 'slycot', 'matplotlib', 'nptdms', 'idelib', 'pyuff', "
        "'ehamj.design.tuning'} & set(sys.modules); "
        "sys.exit(f'{slow} {installed()}' if slow or any(installed().values()) else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
