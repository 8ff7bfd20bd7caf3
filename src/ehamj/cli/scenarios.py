"""Commands that list what can be simulated, and how a scenario is written."""

import sys

from ehamj.cli.frame import Json, app
from ehamj.cli.printing import print_names


@app.command()
def scenarios(as_json: Json = False) -> None:
    """List the scenarios that ship, one line each; run one with `ehamj run NAME`."""
    from ehamj.scenario.load import load_scenario, shipped_scenarios

    found = {name: load_scenario(name).description for name in shipped_scenarios()}
    print_names("scenarios", found, "description", as_json)


@app.command()
def schema() -> None:
    """Print the JSON schema of a scenario file (for editors that complete and check TOML)."""
    from ehamj.scenario.load import scenario_schema

    sys.stdout.write(scenario_schema() + "\n")
