"""The tables in which the command ``modes`` prints its findings."""

import cmath
import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.cli.printing import print_table, say
from ehamj.linear.modes import Mode
from ehamj.linear.shapes import Energies
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
    print_table(title, heads, map(_mode_row, modes))
    if energies:
        heads = ("mode", "kinetic, at the CG", "strain", "… by actuator", "ζ from", "… by actuator")
        rows = (_energy_row(mode, mode.energies) for mode in modes if mode.energies is not None)
        print_table(f"{title}; where the energy is, and what damps it", heads, rows)
    if points:
        moved = (
            [mode.name, *(_parts(mode.points[name].tolist(), AXES) for name in points)]
            for mode in modes
            if mode.machine_moves
        )
        heads = ("mode", *(f"{name} [m]" for name in points))
        print_table(f"{title}; motion of points, as the shape is scaled", heads, moved)
    if slopes is not None:
        about = f"{title}; change in per cent with one per cent of a parameter"
        print_table(about, ("mode", "frequency", "damping ratio"), _slope_rows(modes, slopes))


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
    motion = ["", "", ""]
    if mode.machine_moves:
        motion = [_parts(mode.shape.tolist(), DOFS), str(mode.centre or "translates"), f"{mode.out_of_phase:.1f}°"]
    return [mode.name, f"{mode.frequency:.2f}", f"{mode.damping_ratio:.4f}", *motion]


def _energy_row(mode: Mode, of: Energies) -> list[str]:
    """Shares of energy; of the damping ratio, what is left beside membranes and leakage is the valves' doing."""
    by = of.damping_by | {"valves": mode.damping_ratio - sum(of.damping_by.values())}
    energy = [_shares(of.kinetic, "%"), _shares(of.strain_by, "%"), _shares(of.strain, "%", alike=True)]
    return [mode.name, *energy, _shares(by), _shares(of.damping, alike=True)]


def _shares(parts: Mapping[str, float], unit: str = "", alike: bool = False) -> str:
    """Parts above `NOTABLE` of all, largest first; one value where they may be, and are, ``alike``."""
    least, factor = NOTABLE * sum(map(abs, parts.values())), 100.0 if unit == "%" else 1.0
    values = sorted(parts.items(), key=lambda part: -abs(part[1]))
    if alike and max(parts.values()) - min(parts.values()) <= least:
        return f"{factor * next(iter(parts.values())):.2g}{unit} each"
    shares = ((name, factor * value) for name, value in values if abs(value) > least)
    return "; ".join(f"{name} {share:.{'0f' if abs(share) >= 9.5 else '2g'}}{unit}" for name, share in shares)


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
    only = f"actuators.{names.pop()}." if len(names) == 1 else ""
    steepest = sorted(zip(keys, slopes, strict=True), key=lambda one: -abs(one[1]))[:MOST]
    return "; ".join(f"{key.removeprefix(only)} {slope:+.2f}" for key, slope in steepest if abs(slope) > NOTABLE)
