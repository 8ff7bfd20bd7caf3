"""The command that checks the simulator itself."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.text import Text

from ehamj.cli.frame import Json, app
from ehamj.cli.printing import print_json, print_table
from ehamj.cli.progress import doing
from ehamj.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from ehamj.verify.case import Case


@app.command()
def verify(
    words: Annotated[
        list[str] | None, typer.Argument(metavar="[WORD]...", help="Cases whose names hold one of these; else all.")
    ] = None,
    out_file: Annotated[Path | None, typer.Option("--out", help="Also write the table as an HTML page.")] = None,
    as_json: Json = False,
) -> None:
    """Check the simulator against independent solutions, and print the table of errors; exit 1 if a case fails.

    Closed forms, an independent SciPy model of the whole machine with every option, conservation of oil and energy,
    convergence orders, modes and equilibria. It takes about a minute; `ehamj verify valve` checks the cases of valves.
    """
    from ehamj.verify import to_dict, write_table
    from ehamj.verify import verify as check

    if out_file is not None and not out_file.absolute().parent.is_dir():
        raise InputError(f"--out {str(out_file)!r}: cannot be written, since {str(out_file.parent)!r} is no folder")
    chosen = _named(words or [])
    with doing("verifying", steps=True) as step:
        outcomes = check(progress=lambda done: step(done.case.name), cases=chosen)
    if out_file is not None:
        try:
            write_table(outcomes, out_file)
        except OSError as error:
            raise InputError(f"--out {str(out_file)!r}: cannot be written ({error.strerror})") from error
    if as_json:
        print_json(to_dict(outcomes))
    else:
        verdicts: dict[bool, str | Text] = {True: "passed", False: Text("FAILED", "bold red")}
        rows = []
        for one in outcomes:
            case, verdict = one.case, verdicts[one.passed]
            rows.append((case.name, f"{one.error:.3g}", f"{case.tolerance:.3g}", case.unit, verdict, case.why))
        heads = ("case", "error", "tolerance", "unit", "", "why the tolerance is what it is")
        print_table("verification", heads, rows, whole=0)
    if not all(one.passed for one in outcomes):
        raise typer.Exit(1)


def _named(words: list[str]) -> "list[Case] | None":
    """Cases whose names hold one of some words; None, all, where there are no words.

    Raises:
        InputError: if a word is in no name.
    """
    from ehamj.verify import CASES

    for word in words:
        if not any(word.casefold() in name.casefold() for name in CASES):
            near = did_you_mean(word, {part for name in CASES for part in name.split()})
            raise InputError(f"{word!r}: is in no name of a case; {near}there are {', '.join(CASES)}")
    if not words:
        return None
    return [one for name, one in CASES.items() if any(word.casefold() in name.casefold() for word in words)]
