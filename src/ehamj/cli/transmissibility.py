"""The command that shows how the floor's motion reaches the machine."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from rich import box
from rich.markup import escape
from rich.table import Table

from ehamj.cli.frame import (
    JsonOption,
    OutOption,
    OverwriteOption,
    SetOption,
    app,
    check_out,
    log,
    new_folder,
    out,
    print_json,
)
from ehamj.errors import InputError

if TYPE_CHECKING:
    from ehamj.rig.comparison import Comparison, TransmissibilitySettings

SHOWN_BANDS = ("1", "2", "5", "10", "20", "50", "100", "200")
"""Third-octave bands whose attenuation is printed [Hz]."""
NONLINEAR = 0.02
"""Deviation from linear above which a reader wants to know why [-]."""
OF_METHOD = {"multisine": ("lines", "realisations", "velocity"), "welch": ("segment", "joint")}
"""Options that only one way of measuring has."""
FILES = ("transmissibility.html", "transmissibility.nc", "transmissibility.csv", "attenuation.csv")


@app.command()
def transmissibility(
    context: typer.Context,
    source: Annotated[
        str, typer.Argument(metavar="SCENARIO", help="A TOML file, a shipped scenario's name, or a result folder.")
    ] = "recorded",
    out_folder: OutOption = None,
    overwrite: OverwriteOption = False,
    overrides: SetOption = None,
    method: Annotated[
        Literal["multisine", "welch"] | None,
        typer.Option(help="multisine: runs made for it; welch: the run with its own floor [default of a result]."),
    ] = None,
    estimator: Annotated[Literal["h1", "h2", "hv"], typer.Option(help="Estimator of measured responses.")] = "h1",
    reference: Annotated[
        Literal["cg", "mounts"], typer.Option(help="Point of the machine: centre of gravity, or mount plane's centre.")
    ] = "cg",
    dofs: Annotated[str, typer.Option(help="Degrees of freedom of the floor, with commas.")] = "x,y,z,rx,ry,rz",
    first: Annotated[float, typer.Option("--from", help="Lowest frequency [Hz].")] = 1.0,
    last: Annotated[float, typer.Option("--to", help="Highest frequency [Hz].")] = 300.0,
    lines: Annotated[int, typer.Option(help="About how many lines the multisine has, on whole Hz.")] = 40,
    realisations: Annotated[int, typer.Option(help="Realisations of the multisine's random phases.")] = 2,
    velocity: Annotated[float, typer.Option(help="RMS velocity of each line of the multisine [m/s].")] = 1e-6,
    segment: Annotated[
        float | None, typer.Option(help="Length of Welch segments [s] [default: by the run's length, at most 4].")
    ] = None,
    joint: Annotated[
        bool, typer.Option("--joint", help="welch: all --dofs as inputs together, not each by itself.")
    ] = False,
    confidence: Annotated[float, typer.Option(help="Probability of the confidence bands.")] = 0.95,
    as_json: JsonOption = False,
) -> None:
    """Floor to machine: the linear transmissibility beside the one measured in nonlinear runs, with coherence.

    Passive and under the scenario's control. The folder holds transmissibility.html (read it first),
    transmissibility.nc (all responses, those of single mounts too), transmissibility.csv and attenuation.csv (per
    third-octave), figures/ and scenario.toml.
    """
    from ehamj.report.comparison import write_transmissibility
    from ehamj.rig.tables import write_tables

    check_out(out_folder, overwrite, FILES)
    stored = Path(source).is_dir()
    chosen = method or ("welch" if stored else "multisine")
    _refuse_unused(context, chosen)
    settings = _settings(
        method=chosen, estimator=estimator, reference=reference,
        dofs=tuple(dof.strip() for dof in dofs.split(",")), first=first, last=last, lines=lines,
        realisations=realisations, velocity=velocity, segment=segment, joint=joint, confidence=confidence,
    )  # fmt: skip
    found = _compare(source, stored, overrides or [], settings)
    with new_folder(out_folder, overwrite) as (folder, target), log.status("writing"):
        (target / "scenario.toml").write_text(found.scenario.to_toml(), encoding="utf-8")
        write_tables(target, found)
        write_transmissibility(target, found)
    if as_json:
        print_json({"folder": str(folder), **_plain(found)})
        return
    out.print(_table(found))
    for variant, rows in found.agreement().items():
        worst = [max(row[key] or 0.0 for row in rows.values()) for key in ("of_linear", "of_floor")]
        words = f"{_percent(worst[0])} of linear, {_percent(worst[1])} of the floor's motion"
        out.print(f"{variant}: measured within {words}, where coherent", highlight=False, soft_wrap=True)
        if worst[0] > NONLINEAR > worst[1]:
            words = "what little the control leaves of the floor is not linear in it, by the valves"
            out.print(
                f"note: {variant}: {words}; a smaller --velocity shows less of it", highlight=False, soft_wrap=True
            )
    out.print(f"page, figures and tables: {folder}", markup=False, highlight=False, soft_wrap=True)


def _percent(share: float) -> str:
    return f"{100 * share:.{0 if share >= 0.1 else 2}{'f' if share >= 0.1 else 'g'}} %"


def _refuse_unused(context: typer.Context, method: str) -> None:
    """Raise InputError if an option was given that the way of measuring does not have."""
    for other, names in OF_METHOD.items():
        for name in names:
            source = context.get_parameter_source(name)
            if other != method and source is not None and source.name == "COMMANDLINE":
                raise InputError(f"--{name}: belongs to --method {other}; this measures by {method}")


def _settings(**values: Any) -> "TransmissibilitySettings":
    from pydantic import ValidationError

    from ehamj.rig.comparison import TransmissibilitySettings
    from ehamj.scenario.explain import explain

    try:
        return TransmissibilitySettings(**values)
    except ValidationError as error:
        raise InputError(explain(error)) from None


def _compare(source: str, stored: bool, overrides: list[str], settings: "TransmissibilitySettings") -> "Comparison":
    from ehamj.result import load_result
    from ehamj.rig.comparison import compare_result, compare_scenario
    from ehamj.run.simulate import simulate
    from ehamj.scenario.load import load_scenario

    if stored:
        if overrides:
            raise InputError(f"--set {overrides[0]!r}: a stored result cannot be changed; name its scenario.toml")
        result = load_result(source)
        if settings.method == "welch":
            return compare_result(result, settings)
        scenario = result.scenario
    else:
        scenario = load_scenario(source, overrides)
    with log.status("measuring"):
        if settings.method == "welch":
            return compare_result(simulate(scenario), settings)
        return compare_scenario(scenario, settings)


def _plain(found: "Comparison") -> dict[str, Any]:
    """Attenuation and agreement as plain data."""
    attenuation: dict[str, Any] = {}
    for variant, kind, dof, levels in found.attenuation():
        bands = {
            band.name: None if math.isnan(level) else float(level)
            for band, level in zip(found.chosen, levels, strict=True)
        }
        attenuation.setdefault(variant, {}).setdefault(kind, {})[dof] = bands
    measured = {variant.name: [one.method for one in variant.measured] for variant in found.variants}
    return {
        "reference": found.settings.reference,
        "outputs": list(found.outputs),
        "method": {name: list(dict.fromkeys(methods)) for name, methods in measured.items()},
        "attenuation_db": attenuation,
        "largest_deviation": found.agreement(),
    }


def _table(found: "Comparison") -> Table:
    """Attenuation in a few bands."""
    bands = [(k, band.name) for k, band in enumerate(found.chosen) if band.name in SHOWN_BANDS]
    title = f"{found.scenario.name}: attenuation floor to machine [dB], third-octave bands [Hz]"
    table = Table(title=escape(title), box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for head in ("floor", "control", ""):
        table.add_column(head, no_wrap=True)
    for _, name in bands:
        table.add_column(name, justify="right", no_wrap=True)
    rows = {(dof, variant, kind): levels for variant, kind, dof, levels in found.attenuation()}
    for (dof, variant, kind), levels in sorted(rows.items(), key=lambda row: found.settings.dofs.index(row[0][0])):
        shown = ("–" if math.isnan(levels[k]) else f"{levels[k]:.1f}".replace("-0.0", "0.0") for k, _ in bands)
        table.add_row(dof, variant, kind, *shown)
    return table
