"""Figures over time: velocities, strokes, commands, spools, flows and pressures against their limits."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from ehamj import plots
from ehamj.pages import Picture
from ehamj.pages.words import BAR, LITRE_PER_MINUTE, MICRO
from ehamj.plant.mounts import MOUNTS
from ehamj.plots import Limit, Trace
from ehamj.report.shown import Array, Results
from ehamj.result import Result

Window = tuple[float, float] | None

ZOOM: Final = 1.0
"""Length of the part of a run that is drawn in full [s]."""


def histories(results: Results, colors: Mapping[str, str]) -> Iterator[Picture]:
    label, first = next(iter(results.items()))
    if first.dataset.time.size < 2:
        return
    window = characteristic_part(first)
    yield _velocity_history(results, colors, window)
    data, time = first.dataset, first.dataset.time.values
    plant, color = first.scenario.plant, colors[label]
    stroke = MICRO * (data.stroke.values - data.stroke.values[:1])
    at_rest = data.stroke.values[0]
    ends = [actuator.maximum_stroke for actuator in plant.actuators]
    travel = Limit(
        f"end of stroke, {1e3 * min(ends):.3g} mm",
        (MICRO * float(np.min(ends - at_rest)), MICRO * float(np.max(-np.array(ends) - at_rest))),
    )
    voltages = [actuator.voltage_limit for actuator in plant.actuators]
    if first.controller is not None:
        voltages = [min(voltage, first.controller.voltage_limit) for voltage in voltages]
    openings = [actuator.spool_stroke for actuator in plant.actuators]
    flows = [LITRE_PER_MINUTE * actuator.flow_gain * actuator.spool_stroke for actuator in plant.actuators]
    quantities = (
        ("stroke", "Strokes of the plates, from equilibrium", "stroke [µm]", stroke, travel, "Plate over ground."),
        ("command", "Valve commands", "command [V]", data.valve_command.values, _both("range", voltages, "V"), ""),
        ("spool", "Spools", "spool [mA]", data.spool.values, _both("fully open", openings, "mA"), ""),
        (
            "flow",
            "Oil into chamber 1, which lifts",
            "flow [l/min]",
            LITRE_PER_MINUTE * data.chamber_flow.values[:, :, 0],
            _both("rated flow, fully open", flows, "l/min"),
            "Positive into the chamber. Rated: at half the supply pressure per edge.",
        ),
    )
    for name, title, quantity, values, bound, caption in quantities:
        if not np.any(values):
            continue
        whole = [Trace("all mounts", time, values, color)]
        figure = plots.history(title, quantity, whole, _per_mount(time, values), [bound], window)
        yield Picture(f"history-{name}", figure, caption)
    yield _pressure_history(results, window)


def characteristic_part(result: Result) -> Window:
    """From when to when a run is drawn in full [s]; None for a run that is hardly longer.

    Around the vertical peak of the floor, or of the machine if the floor rests; the end of a run that failed.
    """
    time = result.dataset.time.values
    if time[-1] - time[0] < 1.5 * ZOOM:
        return None
    ground = result.dataset.ground_velocity.values[:, :, 2].mean(axis=1)
    signal = np.abs(ground if np.any(ground) else result.dataset.cg_velocity.values[:, 2])
    peak = float(time[int(np.argmax(np.nan_to_num(signal)))]) if result.complete else float(time[-1])
    begin = min(max(peak - 0.4 * ZOOM, float(time[0])), float(time[-1]) - ZOOM)
    return begin, begin + ZOOM


def _velocity_history(results: Results, colors: Mapping[str, str], window: Window) -> Picture:
    first = next(iter(results.values())).dataset
    floor = MICRO * first.ground_velocity.values[:, :, 2].mean(axis=1)
    traces = [Trace("floor", first.time.values, floor, plots.FLOOR_COLOR, width=2.4)]
    machines = [
        Trace(label, result.dataset.time.values, MICRO * result.dataset.cg_velocity.values[:, 2], colors[label])
        for label, result in results.items()
    ]
    traces += sorted(machines, key=lambda trace: -float(np.nan_to_num(trace.values).std()))  # the quietest on top
    figure = plots.history("Vertical velocity of floor and machine", "velocity [µm/s]", traces, traces, (), window)
    caption = "Floor: mean of the mounts; machine: its centre of gravity."
    return Picture("history-velocity", figure, caption)


def _pressure_history(results: Results, window: Window) -> Picture:
    first = next(iter(results.values()))
    time, pressure = first.dataset.time.values, BAR * first.dataset.chamber_pressure.values
    supply = first.scenario.supply
    whole = [
        Trace(f"chamber {k + 1}, all mounts", time, pressure[:, :, k], color)
        for k, color in enumerate((plots.SKY, plots.ORANGE))
    ]
    detail = [*_per_mount(time, pressure[:, :, 0]), *_per_mount(time, pressure[:, :, 1], "--")]
    manifold = BAR * first.dataset.supply_pressure.values
    if np.ptp(manifold) > 0:
        whole.append(Trace("manifold", time, manifold, plots.FLOOR_COLOR))
    limits = [
        Limit(
            f"supply {BAR * supply.pressure:.4g}, tank {BAR * supply.tank_pressure:.4g} bar",
            (BAR * supply.pressure, BAR * supply.tank_pressure),
        ),
    ]
    figure = plots.history("Chamber pressures, absolute", "pressure [bar]", whole, detail, limits, window)
    caption = "Chamber 1, which lifts, solid; chamber 2 dashed."
    return Picture("history-pressure", figure, caption)


def _per_mount(time: Array, values: Array, dash: str = "-") -> list[Trace]:
    """A trace per mount, (n, mount); lines get thinner, so that those which coincide all show."""
    return [
        Trace(name, time, values[:, k], color, width if dash == "-" else 1.0, dash)
        for k, (name, (color, width)) in enumerate(zip(MOUNTS, plots.MOUNT_STYLES, strict=True))
    ]


def _both(label: str, values: Sequence[float], unit: str) -> Limit:
    """A limit on both sides; that of the weakest mount."""
    least = min(values)
    return Limit(f"{label}, ±{least:.3g} {unit}", (least, -least))
