"""The command that shows how the floor's motion reaches the machine."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from ehamj.cli.frame import Json, Out, Overwrite, Set, app
from ehamj.cli.options import with_options
from ehamj.cli.printing import print_json, print_table, say
from ehamj.cli.progress import doing
from ehamj.errors import InputError
from ehamj.findings import finite
from ehamj.folders import check_out, new_folder
from ehamj.pages.words import decibel, number
from ehamj.result import load_result
from ehamj.rig.comparison import Agreement, Comparison, TransmissibilitySettings, compare_result, compare_scenario
from ehamj.rig.tables import write_tables
from ehamj.run.simulate import simulate
from ehamj.scenario.explain import checked
from ehamj.scenario.load import load_scenario

SHOWN_BANDS = ("1", "2", "5", "10", "20", "50", "100", "200")
"""Third-octave bands whose attenuation is printed [Hz]."""
NONLINEAR, SMALL = 0.5, -34.0
"""Deviation from linear above which a reader wants to know why [dB], where it is this small against the floor [dB]."""
OF_METHOD = {
    "lines": "multisine",
    "realisations": "multisine",
    "velocity": "multisine",
    "segment": "welch",
    "joint": "welch",
}
"""Options that only one way of measuring has."""
FILES = ("transmissibility.html", "transmissibility.nc", "transmissibility.csv", "attenuation.csv")


@app.command()
@with_options(TransmissibilitySettings, {"first": "from", "last": "to"}, without=("per_octave",))
def transmissibility(
    given: dict[str, Any],
    source: Annotated[
        str, typer.Argument(metavar="SCENARIO", help="A TOML file, a shipped scenario's name, or a result folder.")
    ] = "recorded",
    out_folder: Out = None,
    overwrite: Overwrite = False,
    overrides: Set = None,
    as_json: Json = False,
) -> None:
    """Floor to machine: the linear transmissibility beside the one measured in nonlinear runs, with coherence.

    Passive and under the scenario's control. A result folder is measured by Welch's method unless --method says
    otherwise. The folder holds transmissibility.html (read it first), transmissibility.nc (all responses, those of
    single mounts too), transmissibility.csv and attenuation.csv (per third-octave), figures/ and scenario.toml.
    """
    from ehamj.report.comparison import write_transmissibility

    check_out(out_folder, overwrite, FILES)
    stored = Path(source).is_dir()
    settings = checked(TransmissibilitySettings, {"method": "welch" if stored else "multisine"} | given)
    for name in given:
        if OF_METHOD.get(name, settings.method) != settings.method:
            raise InputError(f"--{name}: belongs to --method {OF_METHOD[name]}; this measures by {settings.method}")
    found = _compare(source, stored, overrides or [], settings)
    with new_folder(out_folder, overwrite) as place, doing("writing"):
        (place.target / "scenario.toml").write_text(found.scenario.to_toml(), encoding="utf-8")
        write_tables(place.target, found)
        write_transmissibility(place.target, found)
    if as_json:
        print_json({"folder": str(place.folder), **_plain(found)})
        return
    _print_attenuation(found)
    for variant, rows in found.agreement().items():
        _say_agreement(variant, list(rows.values()))
    say(f"page, figures and tables: {place.folder}", whole=True)


def _say_agreement(variant: str, rows: Sequence[Agreement]) -> None:
    """How far measured and linear are apart, in lines of a terminal's width."""
    known = [row for row in rows if row.magnitude_db is not None and row.phase_deg is not None]
    if not known:
        say(f"{variant}: measured, but nowhere coherent: nothing to hold against linear")
        return
    within = max(row.magnitude_db or 0.0 for row in known)
    phase = max(row.phase_deg or 0.0 for row in known)
    words = f"within {math.ceil(10.0 * within) / 10.0:g} dB and {math.ceil(phase):g}° of linear"
    say(f"{variant}: measured {words}, where coherent")
    floor = max((row.of_floor_db for row in known if row.of_floor_db is not None), default=-999.0)
    say(f"  no direction off by more than {number(math.ceil(floor), 2)} dB of the floor's motion")
    if within > NONLINEAR and floor < SMALL:
        smaller = "a smaller --velocity shows less of it"
        say(f"  note: what the control leaves is not linear in the floor, by the valves; {smaller}")


def _compare(source: str, stored: bool, overrides: list[str], settings: TransmissibilitySettings) -> Comparison:
    if stored and overrides:
        raise InputError(f"--set {overrides[0]!r}: a stored result cannot be changed; name its scenario.toml")
    result = load_result(source) if stored else None
    scenario = result.scenario if result else load_scenario(source, overrides)
    with doing("measuring", steps=True) as step:
        if settings.method == "welch":
            return compare_result(result or simulate(scenario), settings)
        return compare_scenario(scenario, settings, step)


def _plain(found: Comparison) -> dict[str, Any]:
    """Attenuation and agreement as plain data."""
    attenuation: dict[str, Any] = {}
    for variant, kind, dof, levels in found.attenuation():
        bands = {band.name: finite(level) for band, level in zip(found.chosen, levels, strict=True)}
        attenuation.setdefault(variant, {}).setdefault(kind, {})[dof] = bands
    return {
        "reference": found.settings.reference,
        "outputs": list(found.outputs),
        "method": {one.name: list(dict.fromkeys(part.method for part in one.measured)) for one in found.variants},
        "attenuation_db": attenuation,
        "largest_deviation": {
            variant: {output: row._asdict() for output, row in rows.items()}
            for variant, rows in found.agreement().items()
        },
    }


def _print_attenuation(found: Comparison) -> None:
    """Attenuation in a few bands."""
    bands = [(k, band.name) for k, band in enumerate(found.chosen) if band.name in SHOWN_BANDS]
    by_floor = sorted(found.attenuation(), key=lambda row: found.settings.dofs.index(row[2]))
    rows = [
        (dof, variant, kind, *(decibel(finite(levels[k])) for k, _ in bands)) for variant, kind, dof, levels in by_floor
    ]
    title = f"{found.scenario.name}: attenuation floor to machine [dB], third-octave bands [Hz]"
    print_table(title, ("floor", "control", "", *(name for _, name in bands)), rows, whole=3)
