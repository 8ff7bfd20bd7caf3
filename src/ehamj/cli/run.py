"""The command that simulates."""

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from ehamj.cli.frame import Command, Json, Out, Overwrite, ScenarioName, Set, app, log
from ehamj.cli.printing import print_json
from ehamj.cli.progress import doing
from ehamj.cli.timing import Clock, Marks
from ehamj.errors import InputError, NotShown, SimulationFailed
from ehamj.folders import RESULT_FILES, RUNS, check_out, new_folder
from ehamj.unfinished import NO_ROOM

if TYPE_CHECKING:
    from ehamj.result import Result
    from ehamj.scenario.model import Output, Scenario


@app.command(cls=Command)
def run(
    context: typer.Context,
    scenario: ScenarioName = "recorded",
    out_folder: Out = None,
    overwrite: Overwrite = False,
    overrides: Set = None,
    engine: Annotated[
        str | None,
        typer.Option("--engine", help="mujoco, or small-motion, which is many times faster; as --set engine=…"),
    ] = None,
    no_replay: Annotated[bool, typer.Option("--no-replay", help="Do not write replay.rrd.")] = False,
    no_report: Annotated[bool, typer.Option("--no-report", help="Do not write report.html and figures/.")] = False,
    as_json: Json = False,
) -> None:
    """Simulate one scenario into a result folder.

    The folder holds report.html (read it first), replay.rrd (open it with `ehamj replay`), result.nc (all time
    histories, opens with xarray), summary.json, scenario.toml (complete; runs again to the same result) and model.xml
    (opens in any MuJoCo viewer). Variants named in the scenario's `compare` get folders of their own inside it.
    """
    from ehamj.run.budget import check_rows
    from ehamj.scenario.load import load_scenario

    check_out(out_folder, overwrite, RESULT_FILES)
    off = [f"output.{name}=false" for name, given in (("replay", no_replay), ("report", no_report)) if given]
    chosen = [] if engine is None else [f"engine={engine}"]
    loaded = load_scenario(scenario, [*(overrides or ()), *chosen, *off])
    check_rows(loaded, 1 + len(loaded.compare), out_folder or RUNS, loaded.output.report or loaded.output.replay)
    clock = context.obj
    results, failures = _simulate(loaded, clock, RUNS if out_folder is None else out_folder.resolve().parent)
    from ehamj.store import check_shown, write_run

    try:
        with new_folder(out_folder, overwrite) as place, doing("writing") as step, clock.during("writing"):
            left_out, lost = write_run(place.target, results, step, apart=True)
    except OSError as error:
        if error.errno not in NO_ROOM:
            raise
        raise InputError(f"--out {str(out_folder or RUNS)!r}: {error.strerror}; nothing of the run is kept") from error
    if left_out:
        log.print(f"note: {left_out}", markup=False, highlight=False, soft_wrap=True)
    summary = results[loaded.name].summary
    if as_json:
        variants = {name: results[loaded.variant(name).name].summary.to_dict() for name in loaded.compare}
        print_json({"folder": str(place.folder), "summary": summary.to_dict(), "variants": variants})
    else:
        from ehamj.cli.told import print_run

        print_run(results, place.folder, clock.words("reading and compiling"))
    try:
        check_shown(place.folder, lost, () if failures else results.values())
    except NotShown as error:
        if failures:
            raise SimulationFailed(f"{failures[0]}. {error}") from error
        raise
    if failures:
        raise failures[0]


def _simulate(scenario: "Scenario", clock: Clock, within: Path) -> "tuple[dict[str, Result], list[Exception]]":
    """Results of the scenario and of its variants by name, side by side on threads, and what cut them short.

    The ``clock`` counts the stages of the scenario's own run, and for how long its variants went on. Rows that are too
    many for memory go into files ``within`` a folder.
    """
    from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

    from ehamj.compiled.told import telling
    from ehamj.ground.shared import Floors
    from ehamj.interruption import pool_of
    from ehamj.mujoco import hydraulics
    from ehamj.run.simulate import Ready, ready, stepped

    wanted = [scenario, *(scenario.variant(name) for name in scenario.compare)]
    bar = Progress(TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn(), console=log)
    tasks: dict[str, TaskID] = {}

    def compiling(what: str, done: int, of: int) -> None:
        if what not in tasks:
            tasks[what] = bar.add_task(f"compiling {what}, once", total=of)
        bar.update(tasks[what], completed=done, visible=log.is_terminal)

    marks = {variant.name: Marks() for variant in wanted}
    floors, importing = Floors(len(wanted)), cache(lambda: pool.submit(_import_writers, scenario.output))

    def one(run: Ready) -> "tuple[Result, Exception | None]":
        name = run.prepared.scenario.name
        task = bar.add_task(f"simulating {escape(name)}", total=1.0)
        marked = marks[name]

        def done(fraction: float) -> None:
            marked(fraction)
            importing()
            bar.update(task, completed=fraction)

        try:
            return stepped(run, done), None
        except SimulationFailed as failure:
            from ehamj.run.failures import Incomplete

            if not isinstance(failure, Incomplete):
                raise
            return failure.result, failure
        finally:
            marked.end()

    with bar, telling(compiling), hydraulics(), pool_of() as pool:
        # All are made ready before any steps: what cannot run is refused while nothing is lost by it.
        runs = list(pool.map(lambda variant: ready(variant, floors=floors, within=within), wanted))
        outcomes = list(pool.map(one, runs))
    results = {variant.name: result for variant, (result, _) in zip(wanted, outcomes, strict=True)}
    summary = outcomes[0][0].summary
    finding = 0.0 if summary.law is None else summary.law.seconds
    marks[scenario.name].count(clock, finding, summary.timing.stepping_s)
    clock.add("variants", max(one.ended for one in marks.values()) - marks[scenario.name].ended)
    return results, [failure for _, failure in outcomes if failure is not None]


def _import_writers(output: "Output") -> None:
    """Import what judges and writes the result while it is simulated: stepping leaves the interpreter free, what comes
    before the first step does not."""
    from importlib import import_module

    from ehamj.run.judging import import_judging

    import_judging()
    wanted = ["ehamj.store", "h5netcdf"]
    wanted += ["matplotlib.figure", "matplotlib.backends.backend_svg"] if output.report else []
    wanted += ["ehamj.replay"] if output.replay else []
    for name in wanted:
        import_module(name)
