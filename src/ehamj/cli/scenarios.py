"""Commands that list what can be simulated, and how a scenario is written."""

import sys

from ehamj.cli.frame import Json, app
from ehamj.cli.printing import print_names


@app.command()
def scenarios(as_json: Json = False) -> None:
    """List the scenarios that ship, one line each; run one with `ehamj run NAME`."""
    from ehamj.scenario_files import scenario_table, shipped_scenarios

    found = {name: scenario_table(path)["description"] for name, path in shipped_scenarios().items()}
    print_names("scenarios", found, "description", as_json)


@app.command()
def schema() -> None:
    """Print the JSON schema of a scenario file (for editors that complete and check TOML)."""
    from ehamj.scenario.load import scenario_schema

    sys.stdout.write(scenario_schema() + "\n")
