"""The command that lists figures of merit, as study files name them."""

from typing import Annotated

import typer

from ehamj.cli.frame import Command, Json, ScenarioName, Set, app
from ehamj.cli.printing import print_names


@app.command(cls=Command)
def merits(
    scenario: ScenarioName = "recorded",
    find: Annotated[
        str, typer.Option("--find", metavar="WORD", help="Only names with this in them, every one by itself.")
    ] = "",
    overrides: Set = None,
    as_json: Json = False,
) -> None:
    """List the figures of merit that studies of a scenario's designs can ask for.

    Names that differ by an axis, a band, a mount, a class or the like stand in one line, as AXIS, BAND, …; --find WORD
    shows each. Those of nonlinear runs are the numbers of summary.json.
    """
    from ehamj.merits.catalogue import SOURCES
    from ehamj.merits.listing import listing
    from ehamj.merits.merit import Machine
    from ehamj.scenario.load import load_scenario

    machine = Machine(load_scenario(scenario, overrides or ()))
    found = {name: one for source in SOURCES.values() for name, one in source.merits(machine).items()}
    shown = listing(found, machine.scenario, find)
    print_names("merits", {name: f"[{one.unit}] {one.text}" for name, one in shown.items()}, "description", as_json)
