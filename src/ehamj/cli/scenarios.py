"""Commands that list what can be simulated, and how a scenario is written."""

import sys

from ehamj.cli.frame import JsonOption, app, out, print_json


@app.command()
def scenarios(as_json: JsonOption = False) -> None:
    """List the scenarios that ship, one line each; run one with `ehamj run NAME`."""
    from ehamj.scenario.load import load_scenario, shipped_scenarios

    found = {name: load_scenario(name).description for name in shipped_scenarios()}
    if as_json:
        print_json({"scenarios": [{"name": name, "description": text} for name, text in found.items()]})
        return
    for name, text in found.items():
        out.print(f"[bold]{name:16}[/] {text}", highlight=False, soft_wrap=True)


@app.command()
def schema() -> None:
    """Print the JSON schema of a scenario file (for editors that complete and check TOML)."""
    from ehamj.scenario.load import scenario_schema

    sys.stdout.write(scenario_schema() + "\n")
