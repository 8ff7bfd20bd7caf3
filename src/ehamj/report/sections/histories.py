"""Figures over time: velocities, strokes, commands, spools, flows and pressures against their limits."""

from collections.abc import Collection, Iterator
from typing import Final

import numpy as np
import xarray as xr

from ehamj import plots
from ehamj.arrays import Array
from ehamj.pages import Picture, Section
from ehamj.pages.words import BAR, LITRE_PER_MINUTE, MICRO
from ehamj.plots import Limit, Moment, Trace
from ehamj.report.sections.limits import limits_of
from ehamj.report.shown import Shown
from ehamj.result import Result

Window = tuple[float, float] | None

HISTORIES: Final = ("velocity", "stroke", "command", "spool", "flow", "pressure")
"""What is drawn over time: floor and machines, and what the mounts of the first result have."""
LINES: Final = 8
"""Mounts up to which each has a line."""
LOUDEST: Final = 4
"""Of more mounts, how many have one."""
ZOOM: Final = 1.0
"""Length of the part of a run that is drawn in full [s]."""


def histories(shown: Shown) -> Section:
    """What belongs to single mounts is that of the first result."""
    figures, notes = list(figures_of(shown)), list(_notes(shown))
    return Section("histories", "Time histories", figures, notes=[" ".join(notes)])


def _notes(shown: Shown) -> Iterator[str]:
    if shown.first.dataset.time.size < 2:
        yield "Nothing was recorded."
        return
    if not shown.alone:
        yield f"What belongs to single mounts is that of {shown.label}."
    if window := characteristic_part(shown.first):
        yield f"The lower part of each figure shows {window[0]:.4g} to {window[1]:.4g} s."
    if not np.any(shown.first.dataset.valve_command.values):
        yield "There is no command: the valves stay centred."


def figures_of(shown: Shown, wanted: Collection[str] = HISTORIES) -> Iterator[Picture]:
    """Some of the `HISTORIES`, those in which anything moves."""
    data = shown.first.dataset
    if data.time.size < 2:
        return
    window, time = characteristic_part(shown.first), data.time.values
    if "velocity" in wanted:
        yield _velocity_history(shown, window)
    for name, title, quantity, values, bound, caption in _quantities(shown.first):
        if name in wanted and np.any(values):
            whole = [Trace("all mounts", time, values, shown.colors[shown.label])]
            detail = _per_mount(data, values)
            figure = plots.history(title, quantity, whole, detail, [bound], window, (), moments_of(shown.first))
            yield Picture(f"history-{name}", figure, caption)
    if "pressure" in wanted:
        yield _pressure_history(shown.first, window)


def _quantities(result: Result) -> Iterator[tuple[str, str, str, Array, Limit, str]]:
    """Name, title, axis, values (time, mount), limit and caption of what each mount has."""
    data, limits = result.dataset, limits_of(result)
    stroke = MICRO * (data.stroke.values - data.stroke.values[:1])
    above, below = (sign * limits.stroke - data.stroke.values[0] for sign in (1.0, -1.0))
    travel = Limit(
        f"end of stroke, {1e3 * limits.stroke.min():.3g} mm",
        (MICRO * float(above.min()), MICRO * float(below.max())),
    )
    yield "stroke", "Strokes of the plates, from equilibrium", "stroke [µm]", stroke, travel, "Plate over ground."
    commands = data.valve_command.values
    yield "command", "Valve commands", "command [V]", commands, _both("range", limits.voltage, "V"), ""
    yield "spool", "Spools", "spool [mA]", data.spool.values, _both("fully open", limits.spool, "mA"), ""
    yield (
        "flow",
        "Oil into chamber 1, which lifts",
        "flow [l/min]",
        LITRE_PER_MINUTE * data.chamber_flow.values[:, :, 0],
        _both("rated flow, fully open", LITRE_PER_MINUTE * limits.flow, "l/min"),
        "Positive into the chamber. Rated: at half the supply pressure per edge.",
    )


def characteristic_part(result: Result) -> Window:
    """From when to when a run is drawn in full [s]; None for a run that is hardly longer.

    Around the first fault; without any, around the vertical peak of the floor, or of the machine if the floor rests;
    the end of a run that failed.
    """
    time = result.dataset.time.values
    if time[-1] - time[0] < 1.5 * ZOOM:
        return None
    if result.summary.fault:
        begin = min(max(result.summary.fault[0].time_s - 0.4 * ZOOM, float(time[0])), float(time[-1]) - ZOOM)
        return begin, begin + ZOOM
    ground = result.dataset.ground_velocity.values[:, :, 2].mean(axis=1)
    signal = np.abs(ground if np.any(ground) else result.dataset.cg_velocity.values[:, 2])
    peak = float(time[int(np.argmax(np.nan_to_num(signal)))]) if result.complete else float(time[-1])
    begin = min(max(peak - 0.4 * ZOOM, float(time[0])), float(time[-1]) - ZOOM)
    return begin, begin + ZOOM


def moments_of(result: Result) -> list[Moment]:
    """When its faults struck."""
    return [Moment(f"fault: {one.where}, {one.what}", one.time_s) for one in result.summary.fault]


def _velocity_history(shown: Shown, window: Window) -> Picture:
    first = shown.first.dataset
    floor = MICRO * first.ground_velocity.values[:, :, 2].mean(axis=1)
    traces = [Trace("floor", first.time.values, floor, plots.FLOOR_COLOR, width=2.4)]
    machines = [
        Trace(label, result.dataset.time.values, MICRO * result.dataset.cg_velocity.values[:, 2], shown.colors[label])
        for label, result in shown.results.items()
    ]
    traces += sorted(machines, key=lambda trace: -float(np.nan_to_num(trace.values).std()))  # the quietest on top
    title, quantity = "Vertical velocity of floor and machine", "velocity [µm/s]"
    closer = plots.quieter([trace.within(window) for trace in traces])
    figure = plots.history(title, quantity, traces, traces, (), window, closer, moments_of(shown.first))
    caption = "Floor: mean of the mounts; machine: its centre of gravity."
    if closer:
        caption += f" Below, at their own scale: {'; '.join(trace.label for trace in closer[0])}."
    return Picture("history-velocity", figure, caption)


def _pressure_history(first: Result, window: Window) -> Picture:
    """About the mean of each chamber, which a supply of 70 bar would hide the motion behind."""
    time, pressure = first.dataset.time.values, BAR * first.dataset.chamber_pressure.values
    fault = next(iter(first.summary.fault), None)
    until, before = (time[-1], "") if fault is None else (max(fault.time_s, time[0]), " before the fault")
    mean = np.nanmean(plots.finite(pressure[time <= until]), axis=0)
    supply, off = first.scenario.supply, pressure - mean
    whole = [
        Trace(f"chamber {k + 1}, all mounts", time, off[:, :, k], color)
        for k, color in enumerate((plots.SKY, plots.ORANGE))
    ]
    detail = [*_per_mount(first.dataset, off[:, :, 0]), *_per_mount(first.dataset, off[:, :, 1], "--")]
    manifold = BAR * first.dataset.supply_pressure.values
    if np.ptp(manifold) > 0:
        whole.append(Trace("manifold", time, manifold - np.nanmean(plots.finite(manifold)), plots.FLOOR_COLOR))
    above, below = BAR * supply.pressure - float(mean.max()), BAR * supply.tank_pressure - float(mean.min())
    words = f"supply {BAR * supply.pressure:.4g}, tank {BAR * supply.tank_pressure:.4g} bar"
    title, moments = f"Chamber pressures, about their mean{before}", moments_of(first)
    figure = plots.history(title, "pressure [bar]", whole, detail, [Limit(words, (above, below))], window, (), moments)
    means = "; ".join(f"chamber {k + 1}: {_range(mean[:, k])} bar" for k in range(2))
    caption = f"Chamber 1, which lifts, solid; chamber 2 dashed. Means, absolute: {means}."
    if np.ptp(manifold) > 0:
        caption += f" Manifold: {np.nanmean(plots.finite(manifold)):.4g} bar."
    return Picture("history-pressure", figure, caption)


def _range(values: Array) -> str:
    """One number where all mounts have the same."""
    low, high = (f"{value:.2f}" for value in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


def _per_mount(data: xr.Dataset, values: Array, dash: str = "-") -> list[Trace]:
    """A trace per mount, (n, mount); lines get thinner, so that those which coincide all show.

    Of many mounts those that move most have lines, and a band shows between what values all others are.
    """
    time, names = data.time.values, [str(name) for name in data.mount.values]
    shown = list(range(len(names)))
    rest: list[Trace] = []
    if len(names) > LINES:
        about = np.nan_to_num(plots.finite(values - np.nanmean(plots.finite(values), axis=0)))
        shown = sorted(np.argsort(-np.abs(about).max(axis=0), kind="stable")[:LOUDEST].tolist())
        others = [k for k in range(len(names)) if k not in shown]
        rest = [Trace(f"the other {len(others)}, lowest to highest", time, values[:, others], plots.BAND_COLOR)]
    return rest + [
        Trace(names[k], time, values[:, k], color, width if dash == "-" else 1.0, dash)
        for k, (color, width) in zip(shown, plots.mount_styles(len(shown)), strict=True)
    ]


def _both(label: str, values: Array, unit: str) -> Limit:
    """A limit on both sides; that of the weakest mount."""
    least = float(min(values))
    return Limit(f"{label}, ±{least:.3g} {unit}", (least, -least))
