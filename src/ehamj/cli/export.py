"""The command that writes a scenario, a result or a design in the forms that other tools take."""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from ehamj.cli.frame import Command, Json, Set, app
from ehamj.cli.printing import print_json, say
from ehamj.cli.progress import doing
from ehamj.export.formats import FORMATS
from ehamj.export.placed import check_targets, export_to
from ehamj.export.subject import subject_of

Source = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO|RESULT|DESIGN",
        help="A shipped scenario, a TOML file, or the folder of a result or a design, with exactly its law.",
    ),
]
Replace = Annotated[
    bool,
    typer.Option(
        "--overwrite", help="Replace files; in a folder of the same kind those that are written, others stay."
    ),
]


def _with_formats(command: Callable[..., None]) -> Callable[..., None]:
    """The command with an option for every format; its parameter ``targets`` gets what was named, by format."""

    def called(**arguments: Any) -> None:
        given = {name: arguments.pop(one.parameter) for name, one in FORMATS.items()}
        command(targets={name: path for name, path in given.items() if path is not None}, **arguments)

    parameters = []
    for parameter in inspect.signature(command).parameters.values():
        if parameter.name != "targets":
            parameters.append(parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY))
            continue
        for one in FORMATS.values():
            option: Any = Annotated[
                Path | None, typer.Option(one.option, metavar=one.takes, help=f"{one.what[0].upper()}{one.what[1:]}.")
            ]
            keyword = inspect.Parameter.KEYWORD_ONLY
            parameters.append(inspect.Parameter(one.parameter, keyword, default=None, annotation=option))
    called.__name__, called.__doc__ = command.__name__, command.__doc__
    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    called.__annotations__ = {one.name: one.annotation for one in parameters}
    return called


@app.command(cls=Command)
@_with_formats
def export(
    targets: dict[str, Path],
    scenario: Source = "recorded",
    overrides: Set = None,
    overwrite: Replace = False,
    as_json: Json = False,
) -> None:
    """Write the machine, and its law, in the forms that other tools take; several at once.

    Of a scenario the law is the one that a run would have; of a result or a design exactly its own.
    What a format cannot hold is said in a note.
    """
    check_targets(targets, overwrite)
    with doing("exporting") as progress:
        found = export_to(subject_of(scenario, overrides or ()), targets, overwrite, progress)
    if as_json:
        files = {str(path): said for path, said in found.files.items()}
        print_json({"files": files, "notes": list(found.notes)})
        return
    for path, said in found.files.items():
        say(f"{path}: {said}")
    for note in found.notes:
        say(f"note: {note}")
