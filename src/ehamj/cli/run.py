"""The command that simulates."""

from functools import cache, reduce
from operator import getitem
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from ehamj.cli.frame import Command, Json, Out, Overwrite, ScenarioName, Set, app, log, out
from ehamj.cli.printing import print_json, print_table, say
from ehamj.cli.progress import doing
from ehamj.errors import SimulationFailed
from ehamj.folders import RESULT_FILES, RUNS, check_out, new_folder

if TYPE_CHECKING:
    from ehamj.judge import Summary
    from ehamj.result import Result
    from ehamj.scenario.model import Output, Scenario


@app.command(cls=Command)
def run(
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
    check_rows(loaded, 1 + len(loaded.compare), out_folder or RUNS)
    results, failures = _simulate(loaded, RUNS if out_folder is None else out_folder.resolve().parent)
    from ehamj.store import write_run

    with new_folder(out_folder, overwrite) as (folder, target), doing("writing") as step:
        write_run(target, results, step, apart=True)
    summary = results[loaded.name].summary
    if as_json:
        variants = {name: results[loaded.variant(name).name].summary.to_dict() for name in loaded.compare}
        print_json({"folder": str(folder), "summary": summary.to_dict(), "variants": variants})
    else:
        _print_summary(summary, loaded.plant.mounts[0], folder)
        if not loaded.output.replay and summary.complete:
            say(f"replay: none (output.replay = false); `ehamj replay {folder}` builds it")
    if failures:
        raise failures[0]


def _simulate(scenario: "Scenario", within: Path) -> "tuple[dict[str, Result], list[Exception]]":
    """Results of the scenario and of its variants by name, side by side on threads, and what cut them short; rows that
    are too many for memory go into files ``within`` a folder."""
    from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

    from ehamj.compiled.told import telling
    from ehamj.ground.shared import Floors
    from ehamj.interruption import pool_of
    from ehamj.run.simulate import simulate

    wanted = [scenario, *(scenario.variant(name) for name in scenario.compare)]
    bar = Progress(TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn(), console=log)
    tasks: dict[str, TaskID] = {}

    def compiling(what: str, done: int, of: int) -> None:
        if what not in tasks:
            tasks[what] = bar.add_task(f"compiling {what}, once", total=of)
        bar.update(tasks[what], completed=done, visible=log.is_terminal)

    floors, importing = Floors(len(wanted)), cache(lambda: pool.submit(_import_writers, scenario.output))

    def one(variant: "Scenario") -> "tuple[Result, Exception | None]":
        task = bar.add_task(f"simulating {escape(variant.name)}", total=1.0)

        def done(fraction: float) -> None:
            importing()
            bar.update(task, completed=fraction)

        try:
            return simulate(variant, done, floors=floors, within=within), None
        except SimulationFailed as failure:
            from ehamj.run.failures import Incomplete

            if not isinstance(failure, Incomplete):
                raise
            return failure.result, failure

    with bar, telling(compiling), pool_of() as pool:
        outcomes = list(pool.map(one, wanted))
    results = {variant.name: result for variant, (result, _) in zip(wanted, outcomes, strict=True)}
    return results, [failure for _, failure in outcomes if failure is not None]


def _import_writers(output: "Output") -> None:
    """Import what judges and writes the result while it is simulated: stepping leaves the interpreter free, what comes
    before the first step does not."""
    from importlib import import_module

    from ehamj.run.simulate import import_judging

    import_judging()
    wanted = ["ehamj.store", "h5netcdf"]
    wanted += ["matplotlib.figure", "matplotlib.backends.backend_svg"] if output.report else []
    wanted += ["ehamj.replay"] if output.replay else []
    for name in wanted:
        import_module(name)


def _print_summary(summary: "Summary", mount: str, folder: Path) -> None:
    """The few numbers that say how it went, and where everything is."""
    from ehamj.judge.brief import simulated

    state = "complete" if summary.complete else "INCOMPLETE"
    out.print(f"[bold]{escape(summary.name)}[/]: {simulated(summary)}, {state}", highlight=False)
    if summary.complete:
        _print_judgement(summary, mount)
    else:
        say(f"{summary.failure}")
        say("nothing is judged; histories, report and replay show what led there")
    if summary.law is not None:
        say(f"law: {summary.law.words}")
    for warning in summary.warnings:
        say(f"note: {warning}")
    say(f"result: {folder}")
    for name, text in (("report.html", "report"), ("replay.rrd", "replay")):
        if (folder / name).is_file():
            say(f"{text}: {folder / name}")
        elif not summary.complete:
            say(f"{text}: none; `ehamj {text} {folder}` writes it")


def _print_judgement(summary: "Summary", mount: str) -> None:
    """Levels, classes and attenuation of a run that is complete."""
    from ehamj.judge.brief import told_attenuation

    if summary.peak:
        _print_levels(summary, mount)
    for direction, said in summary.lines().items():
        say(f"vibration class, {direction}: {said}")
    mixed = f" ({summary.mixed})" if summary.mixed else ""
    for motion, places in told_attenuation(summary).items():
        for place, words in places.items():
            if words:
                whose = "machine" if place == "rotation" else f"machine's {place}"
                say(f"{motion} attenuation, floor to {whose}{mixed}: {words}")


def _print_levels(summary: "Summary", mount: str) -> None:
    """Peaks and RMS values of the motions, strokes and spools at one mount."""
    rows: list[tuple[Any, ...]] = []
    for axis in "xyz":
        rows.append((f"ground velocity {axis} ({mount})", "µm/s", 1e6, "ground_velocity", mount, axis))
        rows.append((f"machine velocity {axis} (CG)", "µm/s", 1e6, "cg_velocity", axis))
    rows += [(f"machine rotation {dof}", "µrad", 1e6, "machine_displacement", dof) for dof in ("rx", "ry", "rz")]
    rows += [(f"stroke ({mount})", "µm", 1e6, "stroke", mount), (f"spool ({mount})", "mA", 1.0, "spool", mount)]

    def level(levels: dict[str, Any], factor: float, keys: list[str]) -> str:
        value: Any = reduce(getitem, keys, levels)
        return "nan" if value is None else f"{factor * value:.3g}"

    cells = [
        (name, unit, *(level(levels, factor, keys) for levels in (summary.peak, summary.rms)))
        for name, unit, factor, *keys in rows
    ]
    print_table("about equilibrium", ("motion", "unit", "peak", "RMS"), cells)
