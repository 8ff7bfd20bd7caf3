"""The command that answers questions about a machine."""

from typing import Annotated

import typer
from rich.markup import escape

from ehamj.cli.frame import (
    JsonOption,
    OutOption,
    OverwriteOption,
    ScenarioArgument,
    SetOption,
    app,
    check_out,
    log,
    new_folder,
    out,
    print_json,
)


@app.command()
def study(
    name: Annotated[str | None, typer.Argument(help="Which study; without, they are listed.")] = None,
    scenario: ScenarioArgument = "recorded",
    out_folder: OutOption = None,
    overwrite: OverwriteOption = False,
    overrides: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Answer one question about a machine: maps, boundaries of stability, failures, waves, soft mounts.

    `ehamj study` lists the questions. Each writes study.html (read it first), tables as NetCDF and CSV with units,
    figures as SVG, study.json, and scenario.toml with which it comes out the same.
    """
    from ehamj.scenario.load import load_scenario
    from ehamj.studies.catalogue import STUDIES
    from ehamj.studies.catalogue import study as find
    from ehamj.studies.page import STUDY_FILES, to_dict, write_outcome

    if name is None:
        if as_json:
            print_json({"studies": [{"name": key, "question": one.question} for key, one in STUDIES.items()]})
            return
        for key, one in STUDIES.items():
            out.print(f"[bold]{key:16}[/] {one.question}", highlight=False, soft_wrap=True)
        return
    chosen = find(name)
    check_out(out_folder, overwrite, STUDY_FILES)
    loaded = load_scenario(scenario, overrides or ())
    with log.status(f"study {name}") as status:
        outcome = chosen.run(loaded, lambda doing: status.update(f"study {name}: {escape(doing)}"))
        with new_folder(out_folder, overwrite) as (folder, target):
            write_outcome(target, name, outcome, loaded)
    if as_json:
        print_json({"folder": str(folder), **to_dict(name, outcome)})
        return
    out.print(f"[bold]{escape(outcome.title)}[/]: {escape(outcome.question)}", highlight=False, soft_wrap=True)
    for answer in outcome.answers:
        out.print(f"- {answer}", markup=False, highlight=False, soft_wrap=True)
    out.print(f"page, tables and figures: {folder / 'study.html'}", markup=False, highlight=False, soft_wrap=True)
