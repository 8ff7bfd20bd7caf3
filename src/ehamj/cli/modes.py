"""The command that gives the machine's modes."""

import cmath
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Column, Table

from ehamj.cli.frame import JsonOption, ScenarioArgument, SetOption, app, log, out, print_json
from ehamj.errors import InputError
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.mounts import MOUNTS

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import NDArray

    from ehamj.linear.modes import Mode
    from ehamj.rig.modal_test import ModalTest

VARIANTS = {"modes": "valves held", "bypassed": "chambers bypassed, membranes only", "closed_loop": "closed loop"}
"""What modes are given of, by the key in the JSON object."""

KINDS = ("ring-down", "random", "sweep", "hammer")
"""Measurements that `ehamj.rig.modal_test` makes; named here so that --help need not load it."""

SHORT = {"modes": "valves held", "closed_loop": "closed loop", "bypassed": "membranes only"}
"""What the replay calls them, in its order."""

NOTABLE = 0.005
"""Share, or slope, below which a table leaves a part out."""
MOST = 7
"""Parameters named per mode."""


def _mode_column() -> Column:
    return Column("mode", no_wrap=True)


@app.command()
def modes(
    scenario: ScenarioArgument = "recorded",
    overrides: SetOption = None,
    points: Annotated[
        list[str] | None,
        typer.Option("--point", metavar="NAME=X,Y,Z", help="A point beside the scenario's whose motion is given [m]."),
    ] = None,
    sensitivity: Annotated[
        bool, typer.Option("--sensitivity", help="What each parameter does to each mode: d ln f/d ln p, dζ/d ln p.")
    ] = False,
    measured: Annotated[
        str | None,
        typer.Option(
            "--measured", metavar="KIND", help=f"Identify them from a simulated measurement too: {', '.join(KINDS)}."
        ),
    ] = None,
    noise: Annotated[
        float, typer.Option("--noise", help="Noise of the measurement's sensors, as a share of each signal's RMS.")
    ] = 0.0,
    replay: Annotated[
        Path | None,
        typer.Option("--replay", metavar="FILE.rrd", help="Also write the modes as an animated Rerun recording."),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing recording.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Natural frequencies, damping and shapes of the machine: passive, and under the scenario's digital controller.

    Passive it is twice: with its valves held (membranes and oil), and with its chambers bypassed (membranes only).
    Frequencies are |λ|/2π, damping ratios −Re λ/|λ|; shapes are the motion of the mount plane's centre, its largest
    part one. A feedforward does not move modes, so its closed loop adds only the controller's own.

    `--measured` simulates a test of the machine with valves held and sets what is identified beside what is computed:
    `ring-down` jolts of the floor and free decays, `random` periodic noise and `sweep` a sine sweep of the floor,
    `hammer` blows on an upper corner of the machine.

    With `--replay` the modes are drawn exaggerated, the variants beside each other; open it with `rerun FILE.rrd`.
    """
    from ehamj.designs.sensitivity import sensitivities
    from ehamj.linear.loop import Loop
    from ehamj.linear.machine import linear_model
    from ehamj.linear.modes import modes as find
    from ehamj.rig.modal_test import kind_of, modal_test
    from ehamj.scenario.load import load_scenario

    if noise != 0.0 and measured is None:
        raise InputError(f"--noise {noise:g}: belongs to a measurement; add --measured, one of {', '.join(KINDS)}")
    if replay is not None:
        _check_recording(replay, overwrite)
    loaded = load_scenario(scenario, overrides or ())
    places = {**loaded.points, **_points(points or [])}
    model, loop = linear_model(loaded.plant), Loop.of(loaded, loaded.controller())
    settings: dict[str, dict[str, Any]] = {"modes": {}, "bypassed": {"bypassed": True}}
    if loop is not None:
        settings["closed_loop"] = {"loop": loop}
    found = {key: find(model, points=places, **setting) for key, setting in settings.items()}
    test = None
    if measured is not None:
        with log.status(f"measuring: {measured}"):
            test = modal_test(loaded, kind_of(measured), noise)
    if replay is not None:
        from ehamj.replay.mode_replay import replay_modes

        with log.status("drawing"):
            replay_modes(replay, loaded, {SHORT[key]: found[key] for key in SHORT if key in found})
    slopes = {}
    if sensitivity:
        with log.status("changing every parameter"):
            law = None if loop is None else loop.law
            kinds = {"modes": (None, False), "bypassed": (None, True), "closed_loop": (law, False)}
            slopes = {key: sensitivities(loaded, *kinds[key]) for key in settings}
    if as_json:
        content: dict[str, Any] = {key: [mode.to_dict() for mode in modes] for key, modes in found.items()}
        if sensitivity:
            content["sensitivity"] = {key: _plain(slope) for key, slope in slopes.items()}
        if test is not None:
            content["measured"] = test.to_dict()
        if replay is not None:
            content["replay"] = str(replay)
        print_json(content)
        return
    for key, modes in found.items():
        title = f"{loaded.name}: {VARIANTS[key]}"
        out.print(_mode_table(modes, title))
        if key != "bypassed":
            out.print(_energy_table(modes, f"{title}; where the energy is, and what damps it"))
        if places:
            out.print(_point_table(modes, places, title))
        if key in slopes:
            out.print(_slope_table(modes, slopes[key], f"{title}; change in per cent with one per cent of a parameter"))
    if test is not None:
        out.print(_measured_table(test, f"{loaded.name}: identified from signals, valves held"))
        out.print(f"measured: {test.words}", highlight=False, soft_wrap=True)
        for name in test.missed:
            out.print(f"note: {name} was not found in the signals", highlight=False, soft_wrap=True)
    if replay is not None:
        out.print(f"modes, animated: {replay}  (open it with: rerun {replay})", markup=False, soft_wrap=True)


def _check_recording(path: Path, overwrite: bool) -> None:
    """Raise InputError unless a recording may be written there; called before anything is computed."""
    if path.suffix != ".rrd":
        raise InputError(f"--replay {str(path)!r}: must end in .rrd")
    if path.exists() and not (overwrite and path.is_file()):
        raise InputError(f"--replay {str(path)!r}: exists already; name another file or add --overwrite")
    if not path.absolute().parent.is_dir():
        raise InputError(f"--replay {str(path)!r}: {str(path.parent)!r} is no folder")


def _points(given: Sequence[str]) -> dict[str, tuple[float, float, float]]:
    found: dict[str, tuple[float, float, float]] = {}
    for text in given:
        name, equals, place = text.partition("=")
        try:
            x, y, z = (float(part) for part in place.split(","))
        except ValueError:
            x = y = z = math.nan
        if not (name and equals and all(map(math.isfinite, (x, y, z)))):
            raise InputError(f"--point {text!r}: must be a name and three numbers in m, such as spindle=0.2,0,1.4")
        if name in ("cg", *MOUNTS):
            raise InputError(f"--point {text!r}: {name} is given anyway; choose another name")
        found[name] = (x, y, z)
    return found


def _parts(motion: Sequence[complex], names: Sequence[str], least: float = 0.01) -> str:
    """A complex motion in words: the parts above a share of the largest, and their phases where not in step."""
    largest = max(map(abs, motion))
    words = []
    for name, part in zip(names, motion, strict=True):
        if abs(part) > least * largest and largest > 0.0:
            angle = math.degrees(cmath.phase(part))
            words.append(f"{name} {abs(part):.2g}" + (f"∠{angle:.0f}°" if abs(angle) > 1 else ""))
    return ", ".join(words)


def _mode_table(modes: "Sequence[Mode]", title: str) -> Table:
    """Modes with their shapes in words."""
    table = Table(
        _mode_column(), "f [Hz]", "ζ [-]", "shape (m, rad; largest 1)", "turns about", "out of step", title=title
    )
    for mode in modes:
        row = [mode.name, f"{mode.frequency:.2f}", f"{mode.damping_ratio:.4f}"]
        if mode.machine_moves:
            row += [_parts(mode.shape.tolist(), DOFS), str(mode.centre or "translates"), f"{mode.out_of_phase:.1f}°"]
        table.add_row(*row)
    return table


def _energy_table(modes: "Sequence[Mode]", title: str) -> Table:
    """Shares of energy; of the damping ratio, what is left beside membranes and leakage is the valves' doing."""
    table = Table(
        _mode_column(), "kinetic, at the CG", "strain", "… by actuator", "ζ from", "… by actuator", title=title
    )
    for mode in modes:
        if mode.energies is None:
            continue
        e = mode.energies
        by = e.damping_by | {"valves": mode.damping_ratio - sum(e.damping_by.values())}
        row = [_shares(part, "%", 100.0) for part in (e.kinetic, e.strain_by, e.strain)]
        table.add_row(mode.name, *row, _shares(by, "", 1.0), _shares(e.damping, "", 1.0))
    return table


def _shares(parts: Mapping[str, float], unit: str, factor: float) -> str:
    """Parts above `NOTABLE` of all, largest first; one value where all are alike."""
    total = sum(map(abs, parts.values()))
    values = list(parts.values())
    if len(values) == len(MOUNTS) and max(values) - min(values) <= NOTABLE * total:
        return f"{factor * values[0]:.2g}{unit} each"
    order = sorted((name for name in parts if abs(parts[name]) > NOTABLE * total), key=lambda name: -abs(parts[name]))
    return "; ".join(f"{name} {_short(factor * parts[name])}{unit}" for name in order)


def _short(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 9.5 else f"{value:.2g}"


def _point_table(modes: "Sequence[Mode]", points: Mapping[str, Any], title: str) -> Table:
    table = Table(
        _mode_column(), *(f"{name} [m]" for name in points), title=f"{title}; motion of points, as the shape is scaled"
    )
    for mode in modes:
        if mode.machine_moves:
            table.add_row(mode.name, *(_parts(mode.points[name].tolist(), AXES) for name in points))
    return table


def _slope_table(modes: "Sequence[Mode]", slopes: "xr.Dataset", title: str) -> Table:
    """The parameters that move a mode most, of frequency and of damping ratio; of modes alike the first."""
    table = Table(_mode_column(), "frequency", "damping ratio", title=title)
    kinds = [mode.name.split()[0] for mode in modes]
    for k, mode in enumerate(modes):
        if mode.machine_moves or kinds.index(kinds[k]) == k:
            relative = (slopes["frequency"].values[:, k], slopes["damping"].values[:, k] / mode.damping_ratio)
            table.add_row(mode.name, *(_steepest(slopes["parameter"].values.tolist(), slope) for slope in relative))
    return table


def _steepest(keys: Sequence[str], slopes: "NDArray[np.float64]") -> str:
    """Up to `MOST` parameters by how much they change; those of the only kind of actuator without its name."""
    names = {key.split(".")[1] for key in keys if key.startswith("actuators.")}
    order = sorted(range(len(keys)), key=lambda k: -abs(slopes[k]))[:MOST]
    short = {key: key.split(".", 2)[2] if key.startswith("actuators.") and len(names) == 1 else key for key in keys}
    return "; ".join(f"{short[keys[k]]} {slopes[k]:+.2f}" for k in order if abs(slopes[k]) > NOTABLE)


def _measured_table(test: "ModalTest", title: str) -> Table:
    """What was found beside what was computed; spreads are standard deviations over fits and records."""
    table = Table(
        _mode_column(), "f found [Hz]", "computed", "off", "ζ found [-]", "computed", "off", "MAC", title=title
    )
    for mode in test.modes:
        row = [
            f"{mode.frequency:.2f} ± {mode.frequency_spread:.2g}",
            "",
            "",
            f"{mode.damping_ratio:.4f} ± {mode.damping_spread:.1g}",
        ]
        if (other := mode.computed) is not None:
            row[1:3] = [f"{other.frequency:.2f}", f"{100 * (mode.frequency / other.frequency - 1):+.3f} %"]
            row += [f"{other.damping_ratio:.4f}", f"{100 * (mode.damping_ratio / other.damping_ratio - 1):+.2f} %"]
            row += [f"{mode.likeness:.4f}"]
        table.add_row(mode.name, *row)
    return table


def _plain(slopes: "xr.Dataset") -> dict[str, Any]:
    """d ln f/d ln p and dζ/d ln p by parameter, one number per mode in the modes' order; null where there is none."""
    return {
        str(key): {
            "value": float(slopes["value"].sel(parameter=key)),
            "unit": slopes["unit"].sel(parameter=key).item(),
            "frequency": [_finite(value) for value in slopes["frequency"].sel(parameter=key).values],
            "damping": [_finite(value) for value in slopes["damping"].sel(parameter=key).values],
        }
        for key in slopes["parameter"].values
    }


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
