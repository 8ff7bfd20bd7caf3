"""The command that times the simulator."""

from pathlib import Path
from typing import Annotated

import typer

from ehamj.cli.frame import Json, app
from ehamj.cli.printing import print_json, print_names, print_table, say
from ehamj.cli.progress import doing
from ehamj.errors import InputError

SUFFIX = ".svg"


@app.command()
def bench(
    parts: Annotated[
        list[str] | None,
        typer.Argument(help="Parts to time, by name [default: all but peer]."),
    ] = None,
    repetitions: Annotated[int, typer.Option(min=1, help="Repetitions of each timing; medians are given.")] = 5,
    peer: Annotated[bool, typer.Option("--peer", help="Also time Exudyn, where it is installed.")] = False,
    figure: Annotated[Path | None, typer.Option("--figure", help="Also draw the figures into this SVG file.")] = None,
    listed: Annotated[bool, typer.Option("--list", help="List the parts, and time nothing.")] = False,
    as_json: Json = False,
) -> None:
    """Time the simulator against the bare engine and against the same equations without any engine, as ratios.

    `--list` names its parts, such as *engines* (one machine alone) and *lanes* (many side by side). All but *peer* take
    about a minute.
    """
    from ehamj.bench.bench import PARTS, bench_chart, bench_tables, chosen, measured, together

    if listed:
        print_names("parts", {name: part.about for name, part in PARTS.items()}, "about", as_json)
        return
    if figure is not None:
        _check(figure)
    wanted = chosen(parts or (), ("peer",) if peer else ())
    with doing("timing") as step:
        found = measured(repetitions, wanted, step)
    if figure is not None:
        from ehamj.plots.files import svg

        try:
            figure.write_text(svg(bench_chart(together(found), wanted), "bench"), encoding="utf-8")
        except OSError as error:
            raise InputError(f"--figure {str(figure)!r}: cannot be written ({error.strerror})") from error
    tables = bench_tables(found)
    if as_json:
        print_json(together(found) | {"how_to_read": {table.title: table.words for table in tables}})
        return
    say("Medians of interleaved repetitions on this machine, now; ratios are what compares.")
    for table in tables:
        say(f"\n{table.title}: {table.words}")
        print_table("", table.heads, table.rows)
    if figure is not None:
        say(f"figure: {figure}", whole=True)


def _check(figure: Path) -> None:
    """Raise InputError unless the figure may be written; called before anything is timed."""
    if figure.suffix != SUFFIX:
        raise InputError(f"--figure {str(figure)!r}: must end with {SUFFIX}, which is what is drawn")
    if not figure.absolute().parent.is_dir():
        raise InputError(f"--figure {str(figure)!r}: cannot be written, since {str(figure.parent)!r} is no folder")
