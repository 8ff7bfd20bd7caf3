"""The frame of the command line: the app and its commands, its two streams, and the options that commands share."""

import ast
import platform
import sys
from importlib import import_module, resources
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from rich.console import Console
from typer.core import TyperCommand, TyperGroup
from typer.exceptions import TyperException

from ehamj.cli.early import check_early
from ehamj.cli.timing import Clock
from ehamj.interruption import Interrupted
from ehamj.scenario_files import scenario_path

COMMANDS: Final = {
    "run": "run",
    "scenarios": "scenarios",
    "schema": "scenarios",
    "design": "design",
    "modes": "modes",
    "statics": "statics",
    "paper": "paper",
    "transmissibility": "transmissibility",
    "export": "export",
    "study": "study",
    "merits": "merits",
    "identify": "identify",
    "replay": "stored",
    "report": "stored",
    "bench": "bench",
    "verify": "verify",
}
"""Every command, in the order in which `ehamj --help` lists them, and the module of this room that registers it."""


class Command(TyperCommand):
    """A command that simulates or computes; its scenario is sought before anything is imported that could do either.

    That is once all words of the command line are understood: one too many is what is said first.
    """

    example = "duration=3"
    """Of a key of the scenario that is set."""

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        """Understand the words; what is no option, and like none, may be meant as a key of the scenario."""
        try:
            return super().parse_args(ctx, args)
        except TyperException as error:
            unknown = getattr(error, "message", "").startswith("No such option")
            if unknown and not getattr(error, "possibilities", ()):
                error.message += f"; keys of the scenario are set by --set, such as --set {self.example}"
            raise

    def invoke(self, ctx: Any) -> Any:
        if "scenario" in ctx.params:
            scenario_path(ctx.params["scenario"])
        return super().invoke(ctx)


class _Commands(TyperGroup):
    """The commands, of which each is imported when it is asked for: neither help nor a mistyped word waits for one."""

    def __init__(self, *, commands: Any = None, **more: Any) -> None:
        told: dict[str, Any] = dict.fromkeys(COMMANDS)
        super().__init__(commands=told | (commands or {}), **more)

    def invoke(self, ctx: Any) -> Any:
        """Run the command; an interruption leaves it as one, of which Typer would say no more than that."""
        ctx.obj = Clock()
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise Interrupted from None

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command; where its module was not imported, only what its source says of it."""
        if cmd_name in COMMANDS and not self.commands[cmd_name]:
            self.commands[cmd_name] = TyperCommand(cmd_name, help=_documented(cmd_name))
        return super().get_command(ctx, cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if ctx and ctx.resilient_parsing and args[0] in COMMANDS:  # a shell asks what a word may become
            from ehamj.cli.completion import Completing

            return args[0], Completing(args[0], COMMANDS[args[0]]), args[1:]
        if args[0] in COMMANDS:
            check_early(args[0], args[1:])
            import_module(f"ehamj.cli.{COMMANDS[args[0]]}")
            self.commands.update({name: one for name, one in typer.main.get_group(app).commands.items() if one})
        return super().resolve_command(ctx, args)


def _documented(name: str) -> str:
    """Docstring of a command, read without importing what it needs."""
    source = resources.files("ehamj.cli").joinpath(f"{COMMANDS[name]}.py").read_text(encoding="utf-8")
    functions = (node for node in ast.parse(source).body if isinstance(node, ast.FunctionDef) and node.name == name)
    return ast.get_docstring(next(functions)) or ""


app = typer.Typer(
    cls=_Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    help="""Simulate a machine on active hydraulic isolators.

    Begin with `ehamj run`: it simulates the shipped scenario *recorded* and writes numbers and a replay.
    `ehamj scenarios` lists what else ships; copy one, change a value, run it again.
    Results go to standard output (with `--json` one JSON object), progress and messages to standard error.
    Exit codes: 0 done, 2 bad input, 3 the simulation failed or a file could not be written, 130 interrupted.""",
)


def _version(asked: bool) -> None:
    """Say what runs, in a line."""
    if asked:
        from importlib.metadata import version

        sys.stdout.write(f"ehamj {version('ehamj')}, Python {platform.python_version()}, MuJoCo {version('mujoco')}\n")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Versions of ehamj, Python and MuJoCo.")
    ] = False,
) -> None:
    """Without options of its own but that."""


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
