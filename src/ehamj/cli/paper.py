"""The command ``paper``: the paper's actuator."""

from pathlib import Path
from typing import Annotated

import typer

from ehamj.cli.frame import Json, Overwrite, app
from ehamj.cli.printing import print_json, print_table, say
from ehamj.cli.progress import doing
from ehamj.folders import check_out, new_folder


@app.command()
def paper(
    out_folder: Annotated[Path | None, typer.Option("--out", help="Folder [default: a new runs/NNNN].")] = None,
    overwrite: Overwrite = False,
    as_json: Json = False,
) -> None:
    """Reproduce the source paper: figures 3 to 7, and every number it states beside the computed one.

    Beyond the paper, amplitude.svg shows how its actuator answers commands of ±1 to ±90 % in the nonlinear simulation.
    """
    from ehamj.paper.amplitude import AmplitudeStudy, amplitude_response, write_amplitude
    from ehamj.paper.page import write_paper
    from ehamj.paper.reproduction import reproduce
    from ehamj.scenario.load import load_scenario

    check_out(out_folder, overwrite, ("paper.json", "table.csv"))
    found = reproduce()
    with new_folder(out_folder, overwrite) as (folder, target), doing("paper") as step:
        step("page and figures")
        write_paper(target, found)
        step("nonlinear runs of the amplitudes")
        write_amplitude(target, amplitude_response(AmplitudeStudy(load_scenario("single-actuator"))))
    if as_json:
        print_json({"folder": str(folder), **found.to_dict()})
        return
    rows = ((row.name, row.stated, row.computed, row.deviation, row.comment) for row in found.table)
    print_table("the paper, number by number", ("number", "paper", "computed", "deviation", "comment"), rows, whole=0)
    say(f"figures, table and record: {folder}", whole=True)
