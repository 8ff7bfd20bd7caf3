"""The Python API: every public name, and what README and CONTRIBUTING name besides."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import ehamj

TOPICS: Final = {
    "scenarios.md": ("Scenarios", ("load_scenario", "parse_scenario", "Scenario")),
    "runs.md": ("Runs and results", ("simulate", "simulate_many", "Stepper", "Result", "load_result")),
    "laws.md": ("Laws", ("Controller", "ControllerBank", "PythonController", "load_controller")),
    "views.md": ("Linear models and statics", ("linearise", "sampled_plant", "static_loads")),
    "studies.md": ("Studies", ("study", "run_study")),
    "errors.md": ("Errors and warnings", ("InputError", "SimulationFailed", "DerivedAnew")),
}
"""Pages of public names; what is on none of them has a page of its own, so that no name is lost."""


def api_pages(root: Path) -> dict[str, str]:
    """Markdown by path within the site."""
    named = {name for _, names in TOPICS.values() for name in names}
    topics = dict(TOPICS)
    rest = tuple(name for name in ehamj.__all__ if name not in named)
    if rest:
        topics["others.md"] = ("Other names", rest)
    pages = {
        file: f"# {title}\n\n" + "\n".join(_entry(f"ehamj.{name}") for name in names)
        for file, (title, names) in topics.items()
    }
    inner = "\n".join(map(_entry, inner_names(root)))
    pages["inside.md"] = (
        "# What extensions use\n\nNames below the public ones that README and [Adding to ehamj](../contributing.md) "
        f"use. They may change between versions.\n\n{inner}"
    )
    listed = "\n".join(
        f"- [{title}]({file}): {', '.join(f'`ehamj.{name}`' for name in names)}"
        for file, (title, names) in topics.items()
    )
    index = (
        "# Python\n\n`import ehamj` imports nothing slow; each name is found when it is used.\n\n"
        f"{listed}\n- [What extensions use](inside.md): names of the rooms that one more of a kind needs\n"
    )
    return {f"reference/api/{name}": text for name, text in {"index.md": index, **pages}.items()}


def _entry(name: str) -> str:
    return f"::: {name}\n"


def inner_names(root: Path) -> list[str]:
    """What the Python blocks of README and CONTRIBUTING import from rooms of the package that stand there."""
    found: dict[str, None] = {}
    for file in ("README.md", "CONTRIBUTING.md"):
        for block in re.findall(r"^```python\n(.*?)^```", (root / file).read_text(encoding="utf-8"), re.M | re.S):
            for name in _imported(block):
                found[name] = None
    public = {f"ehamj.{home}.{name}" for name, home in ehamj._HOME.items()}
    return sorted(name for name in found if name not in public and _stands(root, name))


def _imported(block: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(block)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("ehamj."):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _stands(root: Path, name: str) -> bool:
    """Whether the module is one of the package; a recipe's own is not."""
    module = root / "src" / Path(*name.split(".")[:-1])
    return module.with_suffix(".py").is_file() or (module / "__init__.py").is_file()
