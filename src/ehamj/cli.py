"""The command line: printing, paths and exit codes, nothing else."""

import cmath
import itertools
import json
import math
import os
import re
import secrets
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from ehamj.errors import InputError
from ehamj.layout import DOFS

if TYPE_CHECKING:
    from ehamj.analysis.modes import Mode
    from ehamj.result import Result
    from ehamj.scenario import Scenario

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    help="""Simulate a machine on active hydraulic isolators.

    Begin with `ehamj run`: it simulates the shipped scenario *recorded* and writes numbers and a replay.
    `ehamj scenarios` lists what else ships; copy one, change a value, run it again.
    Results go to standard output (with `--json` one JSON object), progress and messages to standard error.
    Exit codes: 0 done, 2 bad input, 3 the simulation failed.""",
)
log = Console(stderr=True)
out = Console()

SHOWN_BANDS = ("2", "5", "10", "20", "50", "100")
"""Third-octave bands whose attenuation a run prints [Hz]."""

JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
ScenarioArgument = Annotated[str, typer.Argument(help="A TOML file, or the name of a shipped scenario.")]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Override a key of the scenario, e.g. machine.mass=4500."),
]
OutOption = Annotated[Path | None, typer.Option("--out", help="Folder for the result [default: a new runs/NNNN].")]
OverwriteOption = Annotated[bool, typer.Option("--overwrite", help="Replace an existing --out.")]
RUNS = Path("runs")


def main() -> NoReturn:
    """Run the command line; every error becomes one message and an exit code."""
    from ehamj.errors import SimulationFailed

    try:
        app()
    except (InputError, SimulationFailed) as error:
        log.print(f"[bold red]ehamj:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        sys.exit(2 if isinstance(error, InputError) else 3)
    sys.exit(0)


@app.command()
def run(
    scenario: ScenarioArgument = "recorded",
    out_folder: OutOption = None,
    overwrite: OverwriteOption = False,
    overrides: SetOption = None,
    no_replay: Annotated[bool, typer.Option("--no-replay", help="Do not write replay.rrd.")] = False,
    no_report: Annotated[bool, typer.Option("--no-report", help="Do not write report.html and figures/.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Simulate one scenario into a result folder.

    The folder holds report.html (read it first), replay.rrd (open it with `ehamj replay`), result.nc (all time
    histories, opens with xarray), summary.json, scenario.toml (complete; runs again to the same result) and model.xml
    (opens in any MuJoCo viewer). Variants named in the scenario's `compare` get folders of their own inside it.
    """
    from ehamj.result import RESULT_FILES
    from ehamj.scenario import load_scenario
    from ehamj.store import write_run

    _check_out(out_folder, overwrite, RESULT_FILES)
    loaded = load_scenario(scenario, overrides or ())
    if no_replay or no_report:
        wanted = {"replay": loaded.output.replay and not no_replay, "report": loaded.output.report and not no_report}
        loaded = loaded.model_copy(update={"output": loaded.output.model_copy(update=wanted)})
    results, failures = _simulate(loaded)
    with _new_folder(out_folder, overwrite) as (folder, target), log.status("writing the result"):
        write_run(target, results)
    summary = results[loaded.name].summary
    if as_json:
        variants = {name: results[loaded.variant(name).name].summary for name in loaded.compare}
        _print_json({"folder": str(folder), "summary": summary, "variants": variants})
    else:
        _print_summary(summary, folder)
    if failures:
        raise failures[0]


@app.command()
def scenarios(as_json: JsonOption = False) -> None:
    """List the scenarios that ship, one line each; run one with `ehamj run NAME`."""
    from ehamj.scenario import load_scenario, shipped_scenarios

    found = {name: load_scenario(name).description for name in shipped_scenarios()}
    if as_json:
        _print_json({"scenarios": [{"name": name, "description": text} for name, text in found.items()]})
        return
    for name, text in found.items():
        out.print(f"[bold]{name:16}[/] {text}", highlight=False, soft_wrap=True)


@app.command()
def schema() -> None:
    """Print the JSON schema of a scenario file (for editors that complete and check TOML)."""
    from ehamj.scenario import scenario_schema

    sys.stdout.write(scenario_schema() + "\n")


@app.command()
def modes(scenario: ScenarioArgument = "recorded", overrides: SetOption = None, as_json: JsonOption = False) -> None:
    """Natural frequencies, damping and shapes of the machine: passive, and under the scenario's digital controller.

    Frequencies are |λ|/2π, damping ratios −Re λ/|λ|; shapes are the motion of the mount plane's centre, its largest
    part one. A feedforward does not move modes, so its closed loop adds only the controller's own.
    """
    from ehamj.analysis.linear import linear_model
    from ehamj.analysis.modes import modes as find
    from ehamj.scenario import load_scenario

    loaded = load_scenario(scenario, overrides or ())
    model, controller = linear_model(loaded), loaded.controller()
    found = {"modes": find(model)}
    if controller is not None:
        found["closed_loop"] = find(model, controller)
    if as_json:
        _print_json({key: [mode.to_dict() for mode in modes] for key, modes in found.items()})
        return
    for key, title in (("modes", "valves held"), ("closed_loop", "closed loop")):
        if key in found:
            out.print(_mode_table(found[key], f"{loaded.name}: {title}"))


def _mode_table(modes: "Sequence[Mode]", title: str) -> Table:
    """Modes with their shapes in words: the parts above 1 %, and their phases where they are not in step."""
    table = Table("mode", "f [Hz]", "ζ [-]", "shape (m and rad, largest part 1)", title=title)
    for mode in modes:
        parts = [(dof, abs(part), math.degrees(cmath.phase(part))) for dof, part in zip(DOFS, mode.shape, strict=True)]
        words = [
            f"{dof} {size:.2f}" + (f"∠{angle:.0f}°" if abs(angle) > 1 else "")
            for dof, size, angle in parts
            if size > 0.01
        ]
        moved = mode.name not in ("valve", "controller")
        table.add_row(
            mode.name, f"{mode.frequency:.2f}", f"{mode.damping_ratio:.4f}", ", ".join(words) if moved else ""
        )
    return table


@app.command()
def paper(
    out_folder: Annotated[Path | None, typer.Option("--out", help="Folder [default: a new runs/NNNN].")] = None,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Reproduce the source paper: figures 3 to 7, and every number it states beside the computed one.

    Beyond the paper, amplitude.svg shows how its actuator answers commands of ±1 to ±90 % in the nonlinear simulation.
    """
    from ehamj.scenario import load_scenario
    from ehamj.studies.amplitude import AmplitudeStudy, amplitude_response, write_amplitude
    from ehamj.studies.paper import reproduce, write_paper

    _check_out(out_folder, overwrite, ("paper.json", "table.csv"))
    found = reproduce()
    with _new_folder(out_folder, overwrite) as (folder, target), log.status("drawing"):
        write_paper(target)
        write_amplitude(target, amplitude_response(AmplitudeStudy(load_scenario("single-actuator"))))
    if as_json:
        _print_json({"folder": str(folder), **found.to_dict()})
        return
    table = Table("number", "paper", "computed", "deviation", "comment", title="the paper, number by number")
    for row in found.table:
        table.add_row(row.name, row.stated, row.computed, row.deviation, row.comment)
    out.print(table)
    out.print(f"figures, table and record: {folder}", highlight=False, soft_wrap=True)


@app.command()
def replay(
    folder: Annotated[Path, typer.Argument(metavar="RESULT", help="A result folder.")],
    compare: Annotated[list[Path] | None, typer.Option("--compare", help="Another result, shown beside it.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Build the Rerun recording of a stored result, and open it where there is a screen.

    With `--compare` (repeatable) the recording shows the results side by side with one exaggeration and one clock, in
    RESULT/replay-compare.rrd.
    """
    from ehamj.replay import open_viewer, write_replay
    from ehamj.result import load_result

    folders = [folder, *(compare or [])]
    loaded = [load_result(one) for one in folders]
    labels = _distinct([result.scenario.name for result in loaded], folders)
    path = folder / ("replay-compare.rrd" if compare else "replay.rrd")
    write_replay(path, dict(zip(labels, loaded, strict=True)), loaded[0].scenario.output.exaggeration)
    opened = open_viewer(path)
    if as_json:
        _print_json({"replay": str(path), "opened": opened})
    else:
        hint = "" if opened else f"  (no screen here; open it with: rerun {path})"
        out.print(f"replay: {path}{hint}", markup=False, highlight=False, soft_wrap=True)


@app.command()
def bench(
    repetitions: Annotated[int, typer.Option(min=1, help="Repetitions of each timing; medians are given.")] = 5,
    as_json: JsonOption = False,
) -> None:
    """Time the simulator against the bare engine and against the same equations without any engine, as ratios."""
    from ehamj.bench import bench as measure

    with log.status("timing"):
        figures = measure(repetitions)
    if as_json:
        _print_json(figures)
        return
    table = Table("figure", "value", title="ehamj bench (medians; ratios are what to compare)")
    for name, value in _flat(figures):
        table.add_row(name, f"{value:.4g}")
    out.print(table)


@app.command()
def verify(
    out_file: Annotated[Path | None, typer.Option("--out", help="Also write the table as an HTML page.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Check the simulator against independent solutions, and print the table of errors; exit 1 if a case fails.

    Closed forms, an independent SciPy model of the whole machine with every option, conservation of oil and energy,
    convergence orders, modes and equilibria. It takes about a minute.
    """
    from ehamj.verify import to_dict, write_table
    from ehamj.verify import verify as check

    with log.status("verifying") as status:
        outcomes = check(progress=lambda done: status.update(f"verified: {done.name}"))
    if out_file is not None:
        try:
            write_table(outcomes, out_file)
        except OSError as error:
            raise InputError(f"--out {str(out_file)!r}: cannot be written ({error.strerror})") from error
    if as_json:
        _print_json(to_dict(outcomes))
    else:
        table = Table("case", "error", "tolerance", "unit", "", "why the tolerance is what it is")
        for one in outcomes:
            verdict = "passed" if one.passed else "[bold red]FAILED[/]"
            table.add_row(
                one.name, f"{one.error:.3g}", f"{one.tolerance:.3g}", escape(one.unit), verdict, escape(one.why)
            )
        out.print(table)
    if not all(one.passed for one in outcomes):
        raise typer.Exit(1)


def _simulate(scenario: "Scenario") -> "tuple[dict[str, Result], list[Exception]]":
    """Results of the scenario and of its variants by name, side by side on threads, and what cut them short."""
    from concurrent.futures import ThreadPoolExecutor

    from ehamj.simulate import Incomplete, simulate

    wanted = [scenario, *(scenario.variant(name) for name in scenario.compare)]
    bar = Progress(TextColumn("simulating {task.description}"), BarColumn(), TimeRemainingColumn(), console=log)

    def one(variant: "Scenario") -> "tuple[Result, Exception | None]":
        task = bar.add_task(escape(variant.name), total=1.0)
        try:
            return simulate(variant, lambda fraction: bar.update(task, completed=fraction)), None
        except Incomplete as failure:
            return failure.result, failure

    with bar, ThreadPoolExecutor() as pool:
        outcomes = list(pool.map(one, wanted))
    results = {variant.name: result for variant, (result, _) in zip(wanted, outcomes, strict=True)}
    return results, [failure for _, failure in outcomes if failure is not None]


def _check_out(folder: Path | None, overwrite: bool, marks: Sequence[str]) -> None:
    """Raise InputError unless ``folder`` may be written; called before anything is computed.

    Only a folder that holds the files ``marks`` is replaced: it is of the kind that will be written.
    """
    if folder is not None and folder.exists():
        if not overwrite:
            raise InputError(f"--out {str(folder)!r}: exists already; name another folder or add --overwrite")
        if not folder.is_dir():
            raise InputError(f"--out {str(folder)!r}: is a file, not a folder")
        if any(folder.iterdir()) and not all((folder / name).is_file() for name in marks):
            raise InputError(
                f"--out {str(folder)!r}: --overwrite replaces a folder of its own kind only, and this is none"
            )
        if Path.cwd().is_relative_to(folder.resolve()):
            raise InputError(f"--out {str(folder)!r}: is where you stand; replace it from a folder above")
    folder = folder or RUNS
    above = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        raise InputError(f"--out {str(folder)!r}: cannot be written, since {str(above)!r} is no writable folder")


def _numbered() -> Path:
    """Make the next number under runs/; of two runs that end together each gets its own."""
    RUNS.mkdir(exist_ok=True)
    numbers = [int(found.group()) for path in RUNS.glob("*") if (found := re.match(r"\d+", path.name))]
    for number in itertools.count(max(numbers, default=0) + 1):
        with suppress(FileExistsError):
            (RUNS / f"{number:04d}").mkdir()
            break
    return RUNS / f"{number:04d}"


@contextmanager
def _new_folder(wanted: Path | None, overwrite: bool) -> Iterator[tuple[Path, Path]]:
    """The result's folder, and a temporary one that takes its place when everything in it is written."""
    try:
        folder = wanted or _numbered()
        final = folder.resolve()
        final.parent.mkdir(parents=True, exist_ok=True)
        temporary = final.with_name(f".{final.name}-{secrets.token_hex(4)}")
        temporary.mkdir()
    except OSError as error:
        raise InputError(f"--out {str(wanted or RUNS)!r}: cannot be written ({error.strerror})") from error
    try:
        yield folder, temporary
        if overwrite and final.is_dir():
            shutil.rmtree(final)
        temporary.replace(final)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
        if wanted is None:
            with suppress(OSError):
                final.rmdir()  # only succeeds where nothing took its place


def _distinct(names: list[str], folders: list[Path]) -> list[str]:
    """Labels for results: their scenario's name, and the folder's where that is not enough."""
    if len(set(names)) == len(names):
        return names
    return [f"{name} ({folder.resolve().name})" for name, folder in zip(names, folders, strict=True)]


def _print_json(content: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(content, allow_nan=False) + "\n")


def _flat(content: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, float]]:
    for name, value in content.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _print_summary(summary: dict[str, Any], folder: Path) -> None:
    """The few numbers that say how it went, and where everything is."""
    timing = summary["timing"]
    state = "complete" if summary["complete"] else "INCOMPLETE"
    times = f"{timing['simulated_s']:g} s simulated in {timing['wall_s']:.2g} s"
    out.print(f"[bold]{escape(summary['name'])}[/]: {times}, {state}", highlight=False)
    table = Table("about equilibrium", "unit", "peak", "RMS")
    rows: list[tuple[str, str, float, Callable[[dict[str, Any]], float]]] = []
    for axis in "xyz":
        rows.append((f"ground velocity {axis} (front-left)", "µm/s", 1e6, _pick("ground_velocity", "front-left", axis)))
        rows.append((f"machine velocity {axis} (CG)", "µm/s", 1e6, _pick("cg_velocity", axis)))
    for dof in ("rx", "ry"):
        rows.append((f"machine rotation {dof}", "µrad", 1e6, _pick("machine_displacement", dof)))
    rows.append(("stroke (front-left)", "µm", 1e6, _pick("stroke", "front-left")))
    rows.append(("spool (front-left)", "mA", 1.0, _pick("spool", "front-left")))
    for label, unit, factor, pick in rows:
        table.add_row(label, unit, f"{factor * pick(summary['peak']):.3g}", f"{factor * pick(summary['rms']):.3g}")
    if summary["peak"]:
        out.print(table)
    verdict = summary["criterion"]["verdict"]
    out.print(f"vibration class, vertical: {verdict['vertical']}", highlight=False, soft_wrap=True)
    out.print(f"vibration class, horizontal: {verdict['horizontal']}", highlight=False, soft_wrap=True)
    quiet = {band: dB for band, dB in summary["attenuation_db"]["z"].items() if dB is not None and band in SHOWN_BANDS}
    if quiet:
        words = ", ".join(f"{dB:.0f} dB at {band} Hz" for band, dB in quiet.items())
        out.print(f"vertical attenuation, floor to machine: {words}", highlight=False, soft_wrap=True)
    for warning in summary["warnings"]:
        out.print(f"note: {warning}", markup=False, highlight=False, soft_wrap=True)
    out.print(f"result: {folder}", markup=False, highlight=False, soft_wrap=True)
    for name, text in (("report.html", "report"), ("replay.rrd", "replay")):
        if (folder / name).is_file():
            out.print(f"{text}: {folder / name}", markup=False, highlight=False, soft_wrap=True)


def _pick(*keys: str) -> Callable[[dict[str, Any]], float]:
    def pick(levels: dict[str, Any]) -> float:
        value: Any = levels
        for key in keys:
            value = value[key]
        return float("nan") if value is None else float(value)

    return pick
