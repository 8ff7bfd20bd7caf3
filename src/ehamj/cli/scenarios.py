"""Commands that list what can be simulated, and how a scenario is written."""

import sys
from enum import StrEnum
from typing import Annotated

import typer

from ehamj.cli.frame import Json, app
from ehamj.cli.printing import print_names


@app.command()
def scenarios(as_json: Json = False) -> None:
    """List the scenarios that ship, one line each; run one with `ehamj run NAME`."""
    from ehamj.scenario_files import scenario_table, shipped_scenarios

    found = {name: scenario_table(path)["description"] for name, path in shipped_scenarios().items()}
    print_names("scenarios", found, "description", as_json)


class Kind(StrEnum):
    """Kinds of files that have a schema."""

    SCENARIO = "scenario"
    STUDY = "study"
    IDENTIFY = "identify"


@app.command()
def schema(kind: Annotated[Kind, typer.Argument(help="Of which file.")] = Kind.SCENARIO) -> None:
    """Print the JSON schema of a scenario, a study or an identification file (for editors that complete TOML)."""
    if kind is Kind.STUDY:
        from ehamj.campaign.file import StudyFile
        from ehamj.settings import schema_of

        said = schema_of(StudyFile)
    elif kind is Kind.IDENTIFY:
        from ehamj.identification.file import IdentifyFile
        from ehamj.settings import schema_of

        said = schema_of(IdentifyFile)
    else:
        from ehamj.scenario.load import scenario_schema

        said = scenario_schema()
    sys.stdout.write(said + "\n")
