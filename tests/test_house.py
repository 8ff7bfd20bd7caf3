"""Sizes of the house: what a person can take in at once. To split what belongs together would be no gain."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "src" / "ehamj"
MODULES = sorted(PACKAGE.rglob("*.py"))

LONGEST_MODULE = 350
LONGEST_FUNCTION = 60
MOST_ARGUMENTS = 10


def functions(path: Path) -> list[ast.FunctionDef]:
    """Every function of a module, inner ones too."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_is_read_at_once(path: Path) -> None:
    """No module, no function and no argument list is longer than what the house allows."""
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST_MODULE
    for function in functions(path):
        lines = (function.end_lineno or 0) - function.lineno + 1
        given = function.args.posonlyargs + function.args.args + function.args.kwonlyargs
        count = len([argument for argument in given if argument.arg not in ("self", "cls")])
        assert lines <= LONGEST_FUNCTION, f"{function.name}: {lines} lines"
        assert count <= MOST_ARGUMENTS, f"{function.name}: {count} arguments"
