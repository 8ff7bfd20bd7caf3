"""The command that shows how the floor's motion reaches the machine."""

import math
from pathlib import Path
from typing import Annotated, Any

import typer

from ehamj.cli.frame import Json, Out, Overwrite, Set, app, log
from ehamj.cli.options import with_options
from ehamj.cli.printing import print_json, print_table, say
from ehamj.errors import InputError
from ehamj.findings import finite
from ehamj.folders import check_out, new_folder
from ehamj.result import load_result
from ehamj.rig.comparison import Comparison, TransmissibilitySettings, compare_result, compare_scenario
from ehamj.rig.tables import write_tables
from ehamj.run.simulate import simulate
from ehamj.scenario.explain import checked
from ehamj.scenario.load import load_scenario

SHOWN_BANDS = ("1", "2", "5", "10", "20", "50", "100", "200")
"""Third-octave bands whose attenuation is printed [Hz]."""
NONLINEAR = 0.02
"""Deviation from linear above which a reader wants to know why [-]."""
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
    with new_folder(out_folder, overwrite) as (folder, target), log.status("writing"):
        (target / "scenario.toml").write_text(found.scenario.to_toml(), encoding="utf-8")
        write_tables(target, found)
        write_transmissibility(target, found)
    if as_json:
        print_json({"folder": str(folder), **_plain(found)})
        return
    _print_attenuation(found)
    for variant, rows in found.agreement().items():
        worst = [max(row[key] or 0.0 for row in rows.values()) for key in ("of_linear", "of_floor")]
        words = f"{_percent(worst[0])} of linear, {_percent(worst[1])} of the floor's motion"
        say(f"{variant}: measured within {words}, where coherent")
        if worst[0] > NONLINEAR > worst[1]:
            words = "what little the control leaves of the floor is not linear in it, by the valves"
            say(f"note: {variant}: {words}; a smaller --velocity shows less of it")
    say(f"page, figures and tables: {folder}")


def _percent(share: float) -> str:
    return f"{100 * share:.{0 if share >= 0.1 else 2}{'f' if share >= 0.1 else 'g'}} %"


def _compare(source: str, stored: bool, overrides: list[str], settings: TransmissibilitySettings) -> Comparison:
    if stored and overrides:
        raise InputError(f"--set {overrides[0]!r}: a stored result cannot be changed; name its scenario.toml")
    result = load_result(source) if stored else None
    scenario = result.scenario if result else load_scenario(source, overrides)
    with log.status("measuring"):
        if settings.method == "welch":
            return compare_result(result or simulate(scenario), settings)
        return compare_scenario(scenario, settings)


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
        "largest_deviation": found.agreement(),
    }


def _print_attenuation(found: Comparison) -> None:
    """Attenuation in a few bands."""
    bands = [(k, band.name) for k, band in enumerate(found.chosen) if band.name in SHOWN_BANDS]
    by_floor = sorted(found.attenuation(), key=lambda row: found.settings.dofs.index(row[2]))
    rows = [
        (dof, variant, kind, *("–" if math.isnan(level) else f"{level:.1f}".replace("-0.0", "0.0")
                               for level in (levels[k] for k, _ in bands)))
        for variant, kind, dof, levels in by_floor
    ]  # fmt: skip
    title = f"{found.scenario.name}: attenuation floor to machine [dB], third-octave bands [Hz]"
    print_table(title, ("floor", "control", "", *(name for _, name in bands)), rows, whole=3)
