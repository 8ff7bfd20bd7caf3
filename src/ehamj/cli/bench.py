"""The command that times the simulator."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from ehamj.cli.frame import Json, app
from ehamj.cli.printing import print_json, print_table
from ehamj.cli.progress import doing


@app.command()
def bench(
    repetitions: Annotated[int, typer.Option(min=1, help="Repetitions of each timing; medians are given.")] = 5,
    as_json: Json = False,
) -> None:
    """Time the simulator against the bare engine and against the same equations without any engine, as ratios."""
    from ehamj.bench.bench import bench as measure

    with doing("timing"):
        figures = measure(repetitions)
    if as_json:
        print_json(figures)
        return
    rows = ((name, f"{value:.4g}") for name, value in _flat(figures))
    print_table("ehamj bench (medians; ratios are what to compare)", ("figure", "value"), rows)


def _flat(content: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, float]]:
    for name, value in content.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value
