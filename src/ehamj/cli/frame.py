"""The frame of the command line: the app, the options that commands share, folders and printing."""

import itertools
import json
import os
import re
import secrets
import shutil
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any

import typer
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from ehamj.errors import InputError

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    help="""Simulate a machine on active hydraulic isolators.

    Begin with `ehamj run`: it simulates the shipped scenario *recorded* and writes numbers and a replay.
    `ehamj scenarios` lists what else ships; copy one, change a value, run it again.
    Results go to standard output (with `--json` one JSON object), progress and messages to standard error.
    Exit codes: 0 done, 2 bad input, 3 the simulation failed.""",
)
log = Console(stderr=True)
out = Console()

JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
ScenarioArgument = Annotated[str, typer.Argument(help="A TOML file, or the name of a shipped scenario.")]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Override a key of the scenario, e.g. machine.mass=4500."),
]
OutOption = Annotated[Path | None, typer.Option("--out", help="Folder for the result [default: a new runs/NNNN].")]
OverwriteOption = Annotated[bool, typer.Option("--overwrite", help="Replace an existing --out.")]
RUNS = Path("runs")
NUMBER = re.compile(r"[-+−–]?[\d.]*(e[-+]\d+)?")
"""What a table puts to the right."""


def check_out(folder: Path | None, overwrite: bool, marks: Sequence[str]) -> None:
    """Raise InputError unless ``folder`` may be written; called before anything is computed.

    Only a folder that holds the files ``marks`` is replaced: it is of the kind that will be written.
    """
    if folder is not None and folder.exists():
        if not overwrite:
            raise InputError(f"--out {str(folder)!r}: exists already; name another folder or add --overwrite")
        if not folder.is_dir():
            raise InputError(f"--out {str(folder)!r}: is a file, not a folder")
        if any(folder.iterdir()) and not all((folder / name).is_file() for name in marks):
            raise InputError(
                f"--out {str(folder)!r}: --overwrite replaces a folder of its own kind only, and this is none"
            )
        if Path.cwd().is_relative_to(folder.resolve()):
            raise InputError(f"--out {str(folder)!r}: is where you stand; replace it from a folder above")
    folder = folder or RUNS
    above = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        raise InputError(f"--out {str(folder)!r}: cannot be written, since {str(above)!r} is no writable folder")


def _numbered() -> Path:
    """Make the next number under runs/; of two runs that end together each gets its own."""
    RUNS.mkdir(exist_ok=True)
    numbers = [int(found.group()) for path in RUNS.glob("*") if (found := re.match(r"\d+", path.name))]
    for number in itertools.count(max(numbers, default=0) + 1):
        with suppress(FileExistsError):
            (RUNS / f"{number:04d}").mkdir()
            break
    return RUNS / f"{number:04d}"


@contextmanager
def new_folder(wanted: Path | None, overwrite: bool) -> Iterator[tuple[Path, Path]]:
    """The result's folder, and a temporary one that takes its place when everything in it is written."""
    try:
        folder = wanted or _numbered()
        final = folder.resolve()
        final.parent.mkdir(parents=True, exist_ok=True)
        temporary = final.with_name(f".{final.name}-{secrets.token_hex(4)}")
        temporary.mkdir()
    except OSError as error:
        raise InputError(f"--out {str(wanted or RUNS)!r}: cannot be written ({error.strerror})") from error
    try:
        yield folder, temporary
        if overwrite and final.is_dir():
            shutil.rmtree(final)
        temporary.replace(final)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
        if wanted is None:
            with suppress(OSError):
                final.rmdir()  # only succeeds where nothing took its place


def distinct(names: list[str], folders: list[Path]) -> list[str]:
    """Labels for results: their scenario's name, with the folder's name or path where that is not enough.

    Raises:
        InputError: if a folder is named twice.
    """
    paths = [folder.resolve() for folder in folders]
    twice = [str(folder) for folder, path in zip(folders, paths, strict=True) if paths.count(path) > 1]
    if twice:
        raise InputError(f"result {twice[0]!r}: is named twice; each result is shown once")
    labels = names
    for wheres in ([path.name for path in paths], [str(path) for path in paths]):
        if len(set(labels)) == len(labels):
            break
        labels = [f"{name} ({where})" for name, where in zip(names, wheres, strict=True)]
    return labels


def print_table(title: str, heads: Sequence[str], rows: Iterable[Sequence[str | Text]], whole: int = 1) -> None:
    """Print a table: cells as they are, numbers to the right, and in the first ``whole`` columns no line breaks."""
    cells = [[cell if isinstance(cell, Text) else Text(cell) for cell in row] for row in rows]
    table = Table(title=Text(title), box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for k, head in enumerate(heads):
        number = all(NUMBER.fullmatch(row[k].plain) for row in cells)
        table.add_column(Text(head), no_wrap=number or k < whole, justify="right" if number else "left")
    for row in cells:
        table.add_row(*row)
    out.print(table)


def say(text: str) -> None:
    """Print a line as it is: nothing in it is markup, and it breaks where the terminal does."""
    out.print(text, markup=False, highlight=False, soft_wrap=True)


def print_json(content: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(content, allow_nan=False) + "\n")


def print_names(key: str, found: Mapping[str, str], about: str, as_json: bool) -> None:
    """List what there is, a line each: name and what it is ``about``; as JSON under ``key``."""
    if as_json:
        print_json({key: [{"name": name, about: text} for name, text in found.items()]})
        return
    for name, text in found.items():
        out.print(f"[bold]{name:16}[/] {escape(text)}", highlight=False, soft_wrap=True)


def flat(content: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, float]]:
    for name, value in content.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value
