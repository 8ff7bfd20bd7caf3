"""The tables in which the command ``modes`` prints its findings, each within 80 columns."""

import math
import re
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.cli.printing import print_table, say
from ehamj.identification.modal.told import Pair, Pairing
from ehamj.linear.modes import Mode
from ehamj.linear.shapes import Axis, Energies
from ehamj.pages.words import motion, number
from ehamj.plain.glue import GLUE
from ehamj.plant.axes import AXES, DOFS
from ehamj.rig.modal_test import ModalTest

NOTABLE = 0.005
"""Share, or slope, below which a table leaves a part out."""
LEAST = 0.01
"""Share of a shape's largest part below which a part is left out."""
PARTS = 8
"""Shares up to which each is named; of more the larger half of so many."""
MOST = 7
"""Parameters named per mode."""


def print_modes(
    title: str, modes: Sequence[Mode], everything: bool, points: Sequence[str], slopes: xr.Dataset | None
) -> None:
    """Print modes and their shapes, where their energy is, how points move and which parameters move them.

    Poles of the controller are named in one line unless ``everything`` is wanted; one that grows always stands in the
    table.
    """
    hidden = [mode for mode in modes if not everything and mode.name.split()[0] == "controller"]
    hidden = [mode for mode in hidden if mode.damping_ratio > 0.0]
    names = {mode.name for mode in hidden}
    heads: tuple[str, ...] = ("mode", "f [Hz]", "ζ [-]", "shape (m, rad),\nlargest 1", "turns about [m]")
    heads += ("out of\nstep",)
    print_table(title, heads, (_mode_row(mode) for mode in modes if mode.name not in names), gap=1)
    if hidden:
        least = min(hidden, key=lambda mode: mode.damping_ratio)
        where = f"least damped {least.damping_ratio:.3f} at {least.frequency:.4g} Hz"
        say(f"and {len(hidden)} of the controller alone, {where}: --all\n")
    energies = {mode.name: mode.energies for mode in modes if mode.energies is not None}
    if energies:
        _print_energies(title, energies, {mode.name: mode.damping_ratio for mode in modes})
    if points:
        moved = (
            [mode.name, *(motion(dict(zip(AXES, mode.points[name].tolist(), strict=True)), LEAST) for name in points)]
            for mode in modes
            if mode.machine_moves
        )
        heads = ("mode", *(f"{name} [m]" for name in points))
        print_table(f"{title}; motion of points, as the shape is scaled", heads, moved)
    if slopes is not None:
        about = f"{title}; change in per cent with one per cent of a parameter"
        print_table(about, ("mode", "frequency", "damping ratio"), _slope_rows(modes, slopes))


def print_measured(title: str, test: ModalTest) -> None:
    """Print what was found beside what was computed; spreads are standard deviations, rounded up, over fits and
    records."""
    heads = ("mode", "f [Hz]", "found", "off %", "ζ [%]", "found", "off %", "MAC")
    rows = []
    for mode in test.modes:
        hertz = _with_spread(mode.frequency, mode.frequency_spread)
        damping = _with_spread(100.0 * mode.damping_ratio, 100.0 * mode.damping_spread)
        row = [mode.name, "", hertz, "", "", damping, "", ""]
        if (other := mode.computed) is not None:
            row[1], row[3] = f"{other.frequency:.2f}", _signed(100.0 * (mode.frequency / other.frequency - 1.0))
            row[4] = f"{100.0 * other.damping_ratio:.2f}"
            row[6:] = [_signed(100.0 * (mode.damping_ratio / other.damping_ratio - 1.0)), f"{mode.likeness:.3f}"]
        rows.append(row)
    print_table(title, heads, rows, gap=1)
    say(f"found: {test.words}")
    for name in test.missed:
        say(f"note: {name} was not found in the signals")


def print_paired(title: str, found: Pairing) -> None:
    """Print measured modes beside computed ones; what is behind ± is the standard deviation, stated or assumed."""
    heads = ("measured [Hz]", "mode", "f [Hz]", "off %", "ζ [%]", "computed", "MAC", "close\nones")
    print_table(title, heads, (_pair_row(pair) for pair in found.pairs), gap=1)
    say(f"measured: {found.words}")
    for pair in found.pairs:
        if pair.why:
            say(f"{pair.frequency:.4g} Hz has no pair: {pair.why}")
    for name in found.missed:
        say(f"note: {name} was not measured")
    for note in found.notes:
        say(f"note: {note}")


def _pair_row(pair: Pair) -> list[str]:
    """Blank where nothing was measured, or there is no pair."""
    row = [_with_spread(pair.frequency, pair.frequency_deviation), pair.name, "", "", "", "", "", ""]
    if not math.isnan(pair.damping_ratio):
        row[4] = _with_spread(100.0 * pair.damping_ratio, 100.0 * pair.damping_deviation)
    if pair.name:
        row[2] = f"{pair.computed_frequency:.2f}"
        row[3] = _signed(100.0 * (pair.computed_frequency / pair.frequency - 1.0))
        row[5] = f"{100.0 * pair.computed_damping_ratio:.2f}"
        row[6:] = ["" if math.isnan(value) else f"{value:.3f}" for value in (pair.mac, pair.together)]
    return row


def _with_spread(value: float, spread: float) -> str:
    return f"{value:.2f} ±{math.ceil(100.0 * spread) / 100.0:.2f}".replace("-", "−")


def _signed(value: float) -> str:
    """To two digits with a sign; zero has none."""
    return f"{value:+.2f}".replace("+0.00", "0.00").replace("-0.00", "0.00").replace("-", "−")


def _mode_row(mode: Mode) -> list[str]:
    moves = ["", "", ""]
    if mode.machine_moves:
        shape = motion(dict(zip(DOFS, mode.shape.tolist(), strict=True)), LEAST)
        moves = [shape, _turns(mode.centre), f"{mode.out_of_phase:.1f}°"]
    return [
        mode.name,
        f"{mode.frequency:.{2 if mode.frequency < 1000.0 else 1}f}",
        f"{mode.damping_ratio:.4f}".replace("-", "−"),
        *moves,
    ]


def _turns(centre: Axis | None) -> str:
    """The axis that a shape turns about, without units; far ones to the decimetre."""
    words = "translates" if centre is None else str(centre).replace(" axis", "").removesuffix(" m")
    return re.sub(r"(\d\d\.\d)\d", r"\1", words).replace("0.00", "0")


def _print_energies(title: str, energies: Mapping[str, Energies], ratios: Mapping[str, float]) -> None:
    """Shares of energy, and what damps; of the damping ratio, what is left beside membranes and leakage is the
    valves' doing."""
    kinetic = {name: _shares(one.kinetic, "%") for name, one in energies.items()}
    strain = {name: {what: 100.0 * part for what, part in one.strain_by.items()} for name, one in energies.items()}
    each = {name: _shares(one.strain, "%", alike=True) for name, one in energies.items()}
    causes = _columns(strain)
    heads = ("mode", "kinetic at CG", *(cause.replace(" ", "\n") for cause in causes), "strain by\nactuator")
    rows = [[name, kinetic[name], *_cells(strain[name], causes), each[name]] for name in energies]
    print_table(f"{title}; where the energy is, strain in %", heads, rows, gap=1)
    damping = {
        name: {what: 100.0 * part for what, part in one.damping_by.items()}
        | {"valves": 100.0 * (ratios[name] - sum(one.damping_by.values()))}
        for name, one in energies.items()
    }
    causes = _columns(damping)
    heads = ("mode", "ζ [%]", *(cause.replace(" ", "\n") for cause in causes), "by actuator")
    rows = [
        [
            name,
            f"{100.0 * ratios[name]:.2f}".replace("-", "−"),
            *_cells(damping[name], causes),
            _shares({mount: 100.0 * part for mount, part in one.damping.items()}, alike=True),
        ]
        for name, one in energies.items()
    ]
    print_table(f"{title}; what the damping ratio consists of, in %", heads, rows, gap=1)


def _columns(parts: Mapping[str, Mapping[str, float]]) -> list[str]:
    """What is notable in any mode, in the order in which it is given."""
    seen = {
        what: None
        for own in parts.values()
        for what, part in own.items()
        if abs(part) > NOTABLE * sum(map(abs, own.values()))
    }
    return list(seen)


def _cells(parts: Mapping[str, float], causes: Sequence[str]) -> list[str]:
    """Shares to three digits; what is not notable stays empty."""
    least = NOTABLE * sum(map(abs, parts.values()))
    return [number(parts[cause], 2) if abs(parts.get(cause, 0.0)) > least else "" for cause in causes]


def _shares(parts: Mapping[str, float], unit: str = "", alike: bool = False) -> str:
    """Parts above `NOTABLE` of all, largest first; one value where they may be, and are, ``alike``."""
    least, factor = NOTABLE * sum(map(abs, parts.values())), 100.0 if unit == "%" else 1.0
    values = sorted(parts.items(), key=lambda part: -abs(part[1]))
    if alike and max(parts.values()) - min(parts.values()) <= least:
        return f"{factor * next(iter(parts.values())):.2g}{unit} each"
    shares = [(name, factor * value) for name, value in values if abs(value) > least]
    if len(shares) > PARTS:
        left = shares[PARTS // 2 :]
        shares = [*shares[: PARTS // 2], (f"the other {len(left)} together", sum(share for _, share in left))]
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
    return "; ".join(
        f"{key.removeprefix(only)}{GLUE}{_signed(slope)}" for key, slope in steepest if abs(slope) > NOTABLE
    )
