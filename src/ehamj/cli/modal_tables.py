"""The tables in which the command ``modes`` prints its findings."""

import cmath
import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.cli.frame import print_table, say
from ehamj.linear.modes import Mode
from ehamj.plant.axes import AXES, DOFS
from ehamj.rig.modal_test import ModalTest

NOTABLE = 0.005
"""Share, or slope, below which a table leaves a part out."""
MOST = 7
"""Parameters named per mode."""


def print_modes(
    title: str, modes: Sequence[Mode], energies: bool, points: Sequence[str], slopes: xr.Dataset | None
) -> None:
    """Print modes and their shapes, where their energy is, how points move and which parameters move them."""
    heads: tuple[str, ...] = ("mode", "f [Hz]", "ζ [-]", "shape (m, rad; largest 1)", "turns about", "out of step")
    print_table(title, heads, [_mode_row(mode) for mode in modes])
    if energies:
        heads = ("mode", "kinetic, at the CG", "strain", "… by actuator", "ζ from", "… by actuator")
        rows = [_energy_row(mode) for mode in modes if mode.energies is not None]
        print_table(f"{title}; where the energy is, and what damps it", heads, rows)
    if points:
        swinging = [mode for mode in modes if mode.machine_moves]
        moved = [[mode.name, *(_parts(mode.points[name].tolist(), AXES) for name in points)] for mode in swinging]
        heads = ("mode", *(f"{name} [m]" for name in points))
        print_table(f"{title}; motion of points, as the shape is scaled", heads, moved)
    if slopes is not None:
        heads = ("mode", "frequency", "damping ratio")
        rows = _slope_rows(modes, slopes)
        print_table(f"{title}; change in per cent with one per cent of a parameter", heads, rows)


def print_measured(title: str, test: ModalTest) -> None:
    """Print what was found beside what was computed; spreads are standard deviations over fits and records."""
    heads = ("mode", "f found [Hz]", "computed", "off", "ζ found [-]", "computed", "off", "MAC")
    rows = []
    for mode in test.modes:
        row = [mode.name, f"{mode.frequency:.2f} ± {mode.frequency_spread:.2g}", "", ""]
        row += [f"{mode.damping_ratio:.4f} ± {mode.damping_spread:.1g}", "", "", ""]
        if (other := mode.computed) is not None:
            row[2:4] = [f"{other.frequency:.2f}", f"{100 * (mode.frequency / other.frequency - 1):+.3f} %"]
            off = 100 * (mode.damping_ratio / other.damping_ratio - 1)
            row[5:8] = [f"{other.damping_ratio:.4f}", f"{off:+.2f} %", f"{mode.likeness:.4f}"]
        rows.append(row)
    print_table(title, heads, rows)
    say(f"measured: {test.words}")
    for name in test.missed:
        say(f"note: {name} was not found in the signals")


def _parts(motion: Sequence[complex], names: Sequence[str], least: float = 0.01) -> str:
    """A complex motion in words: the parts above a share of the largest, and their phases where not in step."""
    largest = max(map(abs, motion))
    words = []
    for name, part in zip(names, motion, strict=True):
        if abs(part) > least * largest and largest > 0.0:
            angle = math.degrees(cmath.phase(part))
            words.append(f"{name} {abs(part):.2g}" + (f"∠{angle:.0f}°" if abs(angle) > 1 else ""))
    return ", ".join(words)


def _mode_row(mode: Mode) -> list[str]:
    row = [mode.name, f"{mode.frequency:.2f}", f"{mode.damping_ratio:.4f}"]
    if not mode.machine_moves:
        return [*row, "", "", ""]
    return [*row, _parts(mode.shape.tolist(), DOFS), str(mode.centre or "translates"), f"{mode.out_of_phase:.1f}°"]


def _energy_row(mode: Mode) -> list[str]:
    """Shares of energy; of the damping ratio, what is left beside membranes and leakage is the valves' doing."""
    e = mode.energies
    assert e is not None
    by = e.damping_by | {"valves": mode.damping_ratio - sum(e.damping_by.values())}
    shares = [_shares(part, "%", 100.0) for part in (e.kinetic, e.strain_by)]
    return [
        mode.name,
        *shares,
        _shares(e.strain, "%", 100.0, True),
        _shares(by, "", 1.0),
        _shares(e.damping, "", 1.0, True),
    ]


def _shares(parts: Mapping[str, float], unit: str, factor: float, alike: bool = False) -> str:
    """Parts above `NOTABLE` of all, largest first; one value where they may be, and are, ``alike``."""
    total = sum(map(abs, parts.values()))
    values = list(parts.values())
    if alike and max(values) - min(values) <= NOTABLE * total:
        return f"{factor * values[0]:.2g}{unit} each"
    order = sorted((name for name in parts if abs(parts[name]) > NOTABLE * total), key=lambda name: -abs(parts[name]))
    return "; ".join(f"{name} {_short(factor * parts[name])}{unit}" for name in order)


def _short(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 9.5 else f"{value:.2g}"


def _slope_rows(modes: Sequence[Mode], slopes: xr.Dataset) -> list[list[str]]:
    """The parameters that move a mode most, of frequency and of damping ratio; of modes alike the first."""
    kinds = [mode.name.split()[0] for mode in modes]
    rows = []
    for k, mode in enumerate(modes):
        if mode.machine_moves or kinds.index(kinds[k]) == k:
            relative = (slopes["frequency"].values[:, k], slopes["damping"].values[:, k] / mode.damping_ratio)
            rows.append([mode.name, *(_steepest(slopes["parameter"].values.tolist(), slope) for slope in relative)])
    return rows


def _steepest(keys: Sequence[str], slopes: NDArray[np.float64]) -> str:
    """Up to `MOST` parameters by how much they change; those of the only kind of actuator without its name."""
    names = {key.split(".")[1] for key in keys if key.startswith("actuators.")}
    order = sorted(range(len(keys)), key=lambda k: -abs(slopes[k]))[:MOST]
    short = {key: key.split(".", 2)[2] if key.startswith("actuators.") and len(names) == 1 else key for key in keys}
    return "; ".join(f"{short[keys[k]]} {slopes[k]:+.2f}" for k in order if abs(slopes[k]) > NOTABLE)
