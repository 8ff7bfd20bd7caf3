"""The frame of the command line: the app, its two streams, and the options that commands share."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

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

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
ScenarioName = Annotated[str, typer.Argument(help="A TOML file, or the name of a shipped scenario.")]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Override a key of the scenario, e.g. machine.mass=4500."),
]
Out = Annotated[Path | None, typer.Option("--out", help="Folder for the result [default: a new runs/NNNN].")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace an existing --out.")]
