"""Time histories: which channels are shown, in which units, order and colours, and how a long run is thinned."""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import rerun as rr

from ehamj.replay.recording import (
    FAULT_COLOR,
    GROUND_COLOR,
    MOUNT_COLORS,
    Array,
    Color,
    entity,
    fixed,
    moving,
    result_color,
)
from ehamj.replay.scene import fitted_slab
from ehamj.result import Result

ROOT: Final = "plots"

MOST_ROWS = 200_000
"""Rows of a plot above which the envelope is drawn in place of every sample."""

NEGLIGIBLE = 1e-6
"""Values below this, in the plots' units (1 pm, 1 pm/s, 1 prad, 1 µV), are rounding."""

COMPARED: Final = {
    "vertical": "vertical velocity [µm/s]",
    "along_x": "velocity along x [µm/s]",
    "along_y": "velocity along y [µm/s]",
    "roll": "rotation rx [µrad]",
    "pitch": "rotation ry [µrad]",
    "yaw": "rotation rz [µrad]",
}
"""Plots of floor and machine over each other, by name."""


@dataclass(frozen=True)
class Trace:
    """The lines of one entity: names with units, colours, values (n, line) at times [s]."""

    path: str
    names: tuple[str, ...]
    colors: tuple[Color, ...]
    time: Array
    values: Array
    width: float = 1.0


@dataclass(frozen=True)
class Plot:
    """One view: a title and what it shows."""

    title: str
    traces: tuple[Trace, ...]

    @property
    def peak(self) -> float:
        """Largest absolute value on any line."""
        return max((float(np.nanmax(np.abs(trace.values), initial=0.0)) for trace in self.traces), default=0.0)


def compared_plots(results: Mapping[str, Result]) -> dict[str, Plot]:
    """Motion of floor and machine by plot (`COMPARED`), a line per result; rotations count from the equilibrium.

    The floor is the mounts' mean, and for rotations the slab fitted to them; results that share it share its line.
    """
    floors = {label: _floor(result) for label, result in results.items()}
    machines = {label: _machine(result) for label, result in results.items()}
    plots = {}
    for column, (name, title) in enumerate(COMPARED.items()):
        unit = title[title.index("[") :]
        # The viewer draws in the order of the paths: floors behind, then the loudest, which would hide quieter ones.
        lines = [(who, label, floors[label], GROUND_COLOR, 3.0) for label, who in _distinct(floors).items()]
        for label in sorted(machines, key=lambda label: -_rms(machines[label][:, column])):
            lines.append((label, label, machines[label], result_color(list(results).index(label)), 1.5))
        traces = [
            Trace(
                path=entity(ROOT, name, f"{place:02d}-{who}"),
                names=(f"{who} {unit}",),
                colors=(color,),
                time=results[label].dataset.time.values,
                values=values[:, column : column + 1],
                width=width,
            )
            for place, (who, label, values, color, width) in enumerate(lines)
        ]
        plots[name] = Plot(title, tuple(traces))
    return {name: with_faults(name, plot, results.values()) for name, plot in plots.items()}


def with_faults(name: str, plot: Plot, results: Iterable[Result]) -> Plot:
    """The plot with an upright line at each time at which something failed."""
    times = dict.fromkeys(one.time_s for result in results for one in result.summary.fault)
    high = np.array([[-plot.peak], [plot.peak]])
    lines = [
        Trace(entity(ROOT, name, f"fault {number}"), ("fault",), (FAULT_COLOR,), np.array([at, at + 1e-9]), high, 1.5)
        for number, at in enumerate(times, 1)
    ]
    return Plot(plot.title, (*plot.traces, *lines))


def mount_groups(label: str, mounts: Sequence[str]) -> dict[str, slice]:
    """Mounts that are shown in plots of their own, by what to call them: not more than there are colours in any."""
    count = -(-len(mounts) // len(MOUNT_COLORS))
    ends = np.linspace(0, len(mounts), count + 1).round().astype(int)
    groups = [slice(int(first), int(last)) for first, last in itertools.pairwise(ends)]
    if count == 1:
        return {label: groups[0]}
    return {f"{mounts[group][0]} to {mounts[group][-1]} of {label}": group for group in groups}


def isolator_plots(label: str, result: Result) -> dict[str, dict[str, Plot]]:
    """One result, by groups of mounts: strokes from the equilibrium [µm], commands [V], spools [% of stroke], absolute
    pressures [bar]."""
    data = {name: result.dataset[name].values for name in ("stroke", "valve_command", "spool", "chamber_pressure")}
    plant = result.scenario.plant
    full = np.array([actuator.spool_stroke for actuator in plant.actuators])
    contents = {
        "stroke": ("stroke, from equilibrium [µm]", 1e6 * (data["stroke"] - data["stroke"][:1])),
        "command": ("valve command [V]", data["valve_command"]),
        "spool": ("spool, of its stroke [%]", 100.0 * data["spool"] / full),
        "pressure_1": ("pressure in chamber 1 (lifts), absolute [bar]", 1e-5 * data["chamber_pressure"][:, :, 0]),
        "pressure_2": ("pressure in chamber 2, absolute [bar]", 1e-5 * data["chamber_pressure"][:, :, 1]),
    }
    found: dict[str, dict[str, Plot]] = {}
    for which, group in mount_groups(label, plant.mounts).items():
        own = found[which] = {}
        for name, (title, values) in contents.items():
            names = tuple(f"{mount} {title[title.index('[') :]}" for mount in plant.mounts[group])
            colors, time = MOUNT_COLORS[: len(names)], result.dataset.time.values
            trace = Trace(entity(ROOT, name, which), names, colors, time, values[:, group])
            own[name] = with_faults(f"{name} {which}", Plot(title, (trace,)), [result])
    return found


def log_plot(recording: rr.RecordingStream, plot: Plot) -> None:
    """Log a plot: one entity per trace, with a vector per row."""
    for trace in plot.traces:
        # Zoomed out, several rows share a pixel: the default draws their average, which hides peaks.
        style = rr.SeriesLines(
            names=trace.names,
            colors=trace.colors,
            widths=[trace.width] * len(trace.names),
            aggregation_policy="minmax",
        )
        fixed(recording, trace.path, style)
        if not len(trace.time):
            continue
        time, values = thinned(trace.time, trace.values)
        # In single precision, which no eye can tell apart, the file compresses better.
        rounded = values.astype(np.float32).astype(np.float64)
        columns = rr.Scalars.columns(scalars=rounded.ravel()).partition([values.shape[1]] * len(values))
        moving(recording, trace.path, time, columns)


def thinned(time: Array, values: Array) -> tuple[Array, Array]:
    """At most `MOST_ROWS` rows that keep every peak: lowest and highest value of each line per block of rows."""
    if len(values) <= MOST_ROWS:
        return time, values
    size = -(-2 * len(values) // MOST_ROWS)
    starts = np.arange(0, len(values), size)
    middles = np.minimum(starts + size // 2, len(values) - 1)
    low, high = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    order = np.column_stack([time[starts], time[middles]]).ravel()
    pairs = np.stack([low, high], axis=1).reshape(-1, values.shape[1])
    kept = np.concatenate([[True], np.diff(order) > 0])  # a last block of one row has one time
    return order[kept], pairs[kept]


def _floor(result: Result) -> Array:
    """Columns of `COMPARED` for the floor."""
    velocity = result.dataset.ground_velocity.values.mean(axis=1)
    displacement = result.dataset.ground_displacement.values
    slab = fitted_slab(displacement - displacement[:1], result.scenario.plant)
    return 1e6 * np.column_stack([velocity[:, [2, 0, 1]], slab[:, 3:6]])


def _machine(result: Result) -> Array:
    """Columns of `COMPARED` for the machine: velocities of its CG, its rotations."""
    rotation = result.dataset.machine_displacement.values[:, 3:6]
    return 1e6 * np.column_stack([result.dataset.cg_velocity.values[:, [2, 0, 1]], rotation - rotation[:1]])


def _rms(values: Array) -> float:
    return float(np.sqrt(np.nansum(values**2) / max(1, values.size)))


def _distinct(floors: Mapping[str, Array]) -> dict[str, str]:
    """Labels whose floor no earlier result has, and what to call it."""
    found: list[str] = []
    for label, floor in floors.items():
        if not any(np.array_equal(floor, floors[other]) for other in found):
            found.append(label)
    return {label: "ground" if len(found) == 1 else f"ground of {label}" for label in found}
