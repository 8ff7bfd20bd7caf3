"""CONTRIBUTING.md tells the truth: its examples are applied to a copy of the tree, and they run.

A fenced block whose first line is a comment ``# path`` is a new file. A ``diff`` block whose first line is ``+++ path``
adds lines to a file: its other lines, ``+`` left out, must stand there once. Commands are lines of ``console`` blocks
after ``$``.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
GUIDE = ROOT / "CONTRIBUTING.md"

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)

LONGEST = 40
"""Lines of an example's file in the package: thirty of the example, and its imports."""
MOST_ENTRIES = 3
"""Lines that a registration adds: an import, an entry, a base class."""


EACH = """
import json, sys
from ehamj.cli import main
for sys.argv in json.loads(sys.argv[1]):
    try:
        main()
    except SystemExit as end:
        if end.code:
            raise
"""
"""Runs commands one after the other in one process."""


@dataclass
class Example:
    """A section of the guide."""

    title: str
    files: dict[str, str] = field(default_factory=dict)
    additions: dict[str, list[str]] = field(default_factory=dict)
    commands: list[str] = field(default_factory=list)

    @property
    def tests(self) -> list[str]:
        """Test files of the example."""
        return [path for path in self.files if path.startswith("tests/")]

    @property
    def sources(self) -> list[str]:
        """Its files in the package."""
        return [path for path in self.files if path.startswith("src/")]


def examples() -> list[Example]:
    """The sections of the guide that add something."""
    found = []
    for section in re.split(r"^## ", GUIDE.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]:
        example = Example(section.partition("\n")[0])
        for language, body in BLOCK.findall(section):
            first, _, rest = body.partition("\n")
            if language == "diff":
                example.additions[first.removeprefix("+++ ")] = rest.splitlines()
            elif language == "console":
                example.commands += [line[2:] for line in body.splitlines() if line.startswith("$ ")]
            elif first.startswith("# ") and "/" in first:
                example.files[first.removeprefix("# ")] = rest.lstrip("\n")
        found.append(example)
    return found


def added(text: str, lines: list[str]) -> str:
    """A file with the ``+`` lines of a diff, each hunk of which (between ``@@`` lines) must match it once."""
    hunks: list[list[str]] = [[]]
    for line in lines:
        if line.startswith("@@"):
            hunks.append([])
        else:
            hunks[-1].append(line)
    for hunk in filter(None, hunks):
        before = "".join(f"{line[1:]}\n" for line in hunk if not line.startswith("+"))
        after = "".join(f"{line[1:]}\n" for line in hunk)
        assert all(line[:1] in (" ", "+") for line in hunk), f"a registration only adds lines: {hunk}"
        assert text.count(before) == 1, f"stands there {text.count(before)} times, not once:\n{before}"
        text = text.replace(before, after)
    return text


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the tree."""
    copy = tmp_path_factory.mktemp("tree")
    for folder in ("src", "models", "tests"):
        shutil.copytree(ROOT / folder, copy / folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", copy)
    return copy


def apply(example: Example, tree: Path) -> None:
    """Add the example's files and registrations to the tree, beside those of the examples before it."""
    for path, text in example.files.items():
        assert not (tree / path).exists(), f"{path} is there already"
        (tree / path).parent.mkdir(parents=True, exist_ok=True)
        (tree / path).write_text(text, encoding="utf-8")
    for path, lines in example.additions.items():
        assert added((ROOT / path).read_text(encoding="utf-8"), lines), "an example needs no other one"
        (tree / path).write_text(added((tree / path).read_text(encoding="utf-8"), lines), encoding="utf-8")


@pytest.mark.parametrize("example", examples(), ids=lambda example: example.title)
def test_example_is_one_file(example: Example) -> None:
    """One new file of the package and at most one registration, and a test."""
    assert len(example.sources) == 1, f"files of the package: {example.sources}"
    assert example.tests, "an example has a test"
    assert len(example.additions) <= 1, f"registered in {list(example.additions)}"
    entries = [line for lines in example.additions.values() for line in lines if line.startswith("+")]
    assert len(entries) <= MOST_ENTRIES
    assert len(example.files[example.sources[0]].splitlines()) <= LONGEST


def test_examples_work(tree: Path) -> None:
    """Their tests pass, their commands run: all in one tree, so that what they change is compiled and imported once."""
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    own["PYTHONPATH"] = str(tree / "src")

    def run(*command: str) -> None:
        done = subprocess.run(command, cwd=tree, env=own, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout[-6000:]}\n{done.stderr[-4000:]}"

    found = examples()
    for example in found:
        apply(example, tree)
    run(sys.executable, "-m", "ruff", "check", *(path for one in found for path in (*one.files, *one.additions)))
    tests = [path for example in found for path in example.tests]
    run(sys.executable, "-m", "pytest", "-o", "addopts=", "-q", "--import-mode=importlib", *tests)
    commands = [shlex.split(command) for example in found for command in example.commands]
    assert all(program == "ehamj" for program, *_ in commands), "a command of an example is one of ehamj"
    run(sys.executable, "-c", EACH, json.dumps(commands))


def test_guide_has_an_example_of_every_kind() -> None:
    """None of the headings is empty."""
    assert {example.title for example in examples() if example.sources} == {
        "A valve option",
        "A valve state",
        "A ground",
        "A reader of records",
        "A force",
        "A fault",
        "An architecture",
        "A synthesis",
        "A setting or unit",
        "A norm",
        "A study",
        "A kind of test",
        "An option to choose",
        "A figure of merit",
        "A plan of designs",
        "A spread of values",
        "A report section",
        "A format to export to",
        "A verification case",
        "A timing",
    }
