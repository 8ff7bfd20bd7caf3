"""Travelling waves in the floor: which direction, speed and frequency rock the machine most.

A wave of vertical velocity v and frequency f that runs at speed c turns the floor at the rate v·2πf/c; a machine on
stiff mounts follows the plane through its mounts, and most where half a wave lies between them. Rotation rates are
given over the floor's velocity: [rad/s per m/s] = [rad/m].
"""

from functools import partial
from typing import Any, Literal

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.arrays import Array, ComplexArray
from ehamj.labels import table
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.machine import LinearModel
from ehamj.linear.response import ground_response, rigid_floor
from ehamj.plant.axes import AXES, DOFS
from ehamj.plots import Figure, Line, direction_chart, map_chart
from ehamj.run.simulate import observed
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress
from ehamj.studies.study import Positive, WholeHertz, study
from ehamj.studies.variants import still

HELD = "valves held"
TURNS = ("machine_velocity rx", "machine_velocity ry")
EDGE = " That is the highest frequency looked at; above it rocks more still."
SETTLED = 2.0
"""Time from which a run is evaluated, for one second [s]."""


class WaveSettings(Settings):
    """Which waves pass below the machine."""

    axis: Literal["x", "y", "z"] = Field("z", description="direction in which the floor's particles move")
    speeds: tuple[Positive, ...] = Field(
        tuple(np.geomspace(100.0, 2000.0, 27).tolist()), min_length=1, description="apparent wave speeds [m/s]"
    )
    directions: tuple[float, ...] = Field(
        tuple(np.arange(0.0, 360.0, 2.5).tolist()),
        min_length=1,
        description="directions of travel, from +x towards +y [deg]",
    )
    frequencies: tuple[WholeHertz, ...] = Field(
        tuple(np.arange(1.0, 121.0).tolist()), min_length=1, description="frequencies, whole numbers [Hz]"
    )


def wave_motion(places: Array, hertz: Array, speed: float, direction: float, axis: str) -> ComplexArray:
    """Displacement [m] of each mount's ground, (frequency, mount, axis), in a wave of unit velocity [m/s]."""
    angle = np.radians(direction)
    delay = places @ np.array([np.cos(angle), np.sin(angle)]) / speed
    omega = 2j * np.pi * np.asarray(hertz, float)
    motion = np.zeros((omega.size, len(delay), len(AXES)), complex)
    motion[:, :, AXES.index(axis)] = np.exp(-omega[:, None] * delay) / omega[:, None]
    return motion


def largest_turn(rx: ComplexArray, ry: ComplexArray) -> Array:
    """Largest length that the vector (rx, ry) of two phasors reaches in a period: the ellipse's longer half axis."""
    total = np.abs(rx) ** 2 + np.abs(ry) ** 2
    return np.asarray(np.sqrt(0.5 * (total + np.abs(rx**2 + ry**2))))


def rocking(
    model: LinearModel,
    loop: Loop | None,
    settings: WaveSettings = WaveSettings(),  # noqa: B008  # frozen
) -> Array:
    """Largest rotation rate over floor velocity [rad/m], (direction, speed, frequency)."""
    f, places = np.array(settings.frequencies), np.array(model.plant.positions)[:, :2]
    k = AXES.index(settings.axis)
    transfer = ground_response(model, f, TURNS, loop)[:, :, k :: len(AXES)]  # (frequency, output, mount)
    found = np.empty((len(settings.directions), len(settings.speeds), f.size))
    for i, direction in enumerate(settings.directions):
        for j, speed in enumerate(settings.speeds):
            motion = wave_motion(places, f, speed, direction, settings.axis)[:, :, k]
            turns = np.einsum("fm,fom->of", motion, transfer)
            found[i, j] = largest_turn(*turns)
    return found


@study(
    "waves",
    WaveSettings,
    "which travelling wave in the floor rocks the machine most",
    small={"speeds": (150.0, 300.0), "directions": (0.0, 90.0), "frequencies": (30.0, 60.0)},
)
def waves(scenario: Scenario, settings: WaveSettings, progress: Progress) -> Outcome:
    """A machine that has no operating point is refused."""
    progress("linear response")
    law = scenario.controller()
    model, loop = linear_under(scenario.plant, law), Loop.of(scenario, law)
    systems: dict[str, Loop | None] = {HELD: None} | ({} if loop is None else {"controlled": loop})
    found = rocking_table(settings, {name: rocking(model, one, settings) for name, one in systems.items()})
    worst = {name: worst_wave(found, name) for name in systems}
    coupling = coupling_table(model, np.array(settings.frequencies))
    progress("nonlinear run of the worst wave")
    simulated = simulated_rocking(scenario, settings.axis, worst[HELD])
    maps = {f"map-{name.replace(' ', '-')}": name for name in systems}
    return Outcome(
        title="Waves that rock the machine",
        question=f"Which wave of {settings.axis}-motion in the floor rocks this machine most?",
        answers=_answers(settings, worst, simulated),
        tables={
            "directions": _largest(found),
            **{key: _at(found, worst[name], name).to_dataset() for key, name in maps.items()},
            "coupling": coupling,
        },
        drawings={
            key: Drawing(
                f"Rotation rate over the floor's velocity, {name}, for waves towards {worst[name]['direction']:.0f}°.",
                partial(_map, found, worst[name], name),
            )
            for key, name in maps.items()
        }
        | {
            key.replace("map", "directions"): Drawing(
                f"Largest rotation rate over the floor's velocity at any frequency, {name}, by the direction in which "
                "the wave travels, seen from above.",
                partial(_directions, found, name),
            )
            for key, name in maps.items()
        },
        notes=(
            "Plane waves of one frequency; every mount sees the same motion at its own time (coherent floor).",
            "coupling.csv says what a rigid floor's six motions do to the machine's six, as the largest gain at any of "
            "the frequencies; on a symmetric machine a floor that rolls moves y and rx only, one that heaves z only.",
        ),
        numbers={"worst": worst, "simulated_rocking": simulated},
    )


def _answers(settings: WaveSettings, worst: dict[str, dict[str, float]], simulated: float) -> tuple[str, ...]:
    held = worst[HELD]
    slope = 2 * np.pi * held["frequency"] / held["speed"]
    off = simulated / held["rocking"] - 1.0
    return (
        *(
            f"{name.capitalize()}, the wave that rocks the machine most goes towards {one['direction']:.0f}° at "
            f"{one['speed']:.0f} m/s and {one['frequency']:.0f} Hz: {one['rocking']:.3g} rad/s per m/s of floor "
            f"velocity.{EDGE if one['frequency'] == settings.frequencies[-1] else ''}"
            for name, one in worst.items()
        ),
        f"The floor itself turns at {slope:.3g} rad/m in the first of these waves; the mounts' distance averages, and "
        "the sway-rocking modes add.",
        f"A nonlinear run of the first wave gives {simulated:.4g} rad/m, {100 * off:+.2f} % off the linear model.",
    )


def rocking_table(settings: WaveSettings, found: dict[str, Array]) -> xr.Dataset:
    """Label what `rocking` found for each system."""
    return table(
        f"rocking in waves of {settings.axis}-motion",
        {
            "system": (list(found), "", "machine"),
            "direction": (list(settings.directions), "deg", "direction of travel"),
            "speed": (list(settings.speeds), "m/s", "wave speed"),
            "frequency": (list(settings.frequencies), "Hz", "frequency"),
        },
        rocking=(np.array(list(found.values())), "rad/m", "rotation rate over floor velocity"),
    )


def worst_wave(found: xr.Dataset, system: str) -> dict[str, float]:
    """Direction [deg], speed [m/s], frequency [Hz] and rocking [rad/m] of the wave that rocks most."""
    values = found["rocking"].sel(system=system)
    at = np.unravel_index(int(np.argmax(values.values)), values.shape)
    place = {str(name): float(values[name][k]) for name, k in zip(values.dims, at, strict=True)}
    return place | {"rocking": float(values.values[at])}


def _at(found: xr.Dataset, wave: dict[str, float], system: str) -> xr.DataArray:
    """Rocking of one system over speed and frequency, in the direction of one wave."""
    return found["rocking"].sel(system=system, direction=wave["direction"], drop=True)


def _largest(found: xr.Dataset) -> xr.Dataset:
    """Largest rocking at any frequency, and that frequency, over system, direction and speed."""
    values = found["rocking"]
    largest = xr.Dataset({"rocking": values.max("frequency"), "frequency": values.idxmax("frequency")})
    largest["rocking"].attrs, largest["frequency"].attrs = values.attrs, {"units": "Hz", "long_name": "at frequency"}
    return largest.assign_attrs(found.attrs)


def coupling_table(model: LinearModel, hertz: Array) -> xr.Dataset:
    """Largest gain at ``hertz`` from each motion of a rigid floor to each of the machine's mount plane, 6 by 6."""
    outputs = tuple(f"machine_displacement {dof}" for dof in DOFS)
    gains = np.abs(rigid_floor(model, hertz, None, outputs).response).max(axis=0).T
    return table(
        "what a rigid floor's motions move",
        {"floor": (list(DOFS), "", "floor"), "machine": (list(DOFS), "", "machine")},
        gain=(np.array(gains), "m/m, rad/m, m/rad, rad/rad", "largest gain"),
    )


def simulated_rocking(scenario: Scenario, axis: str, wave: dict[str, float], velocity: float = 1e-5) -> float:
    """Rotation rate over floor velocity [rad/m] in a nonlinear run of one wave with valves held.

    ``velocity`` is the floor's amplitude [m/s]. Frequencies are whole numbers of Hz: a second has whole periods.
    """
    hertz = wave["frequency"]
    ground: dict[str, Any] = {
        "kind": "sine",
        "dof": axis,
        "amplitude": velocity / (2 * np.pi * hertz),
        "frequency": hertz,
    }
    ground |= {"wave": {"speed": wave["speed"], "direction": wave["direction"]}, "fade_in": 0.5}
    run = observed(still(scenario, ground=ground, duration=SETTLED + 1.0, record_rate=2000.0))
    part = run.dataset["machine_velocity"].sel(time=slice(SETTLED + 1e-9, None))
    line = np.exp(-2j * np.pi * hertz * part["time"].values)
    phasors = [2.0 * np.mean(part.sel(dof=dof).values * line) for dof in ("rx", "ry")]
    return float(largest_turn(*map(np.asarray, phasors))) / velocity


def _map(found: xr.Dataset, worst: dict[str, float], system: str) -> Figure:
    values = _at(found, worst, system)
    return map_chart(
        f"Rocking in waves, {system}",
        ("frequency [Hz]", values["frequency"].values),
        ("wave speed [m/s]", values["speed"].values),
        ("rotation rate over floor velocity [rad/m]", values.values),
        points=[Line("worst wave", [worst["frequency"]], [worst["speed"]], color=1, marker="o")],
        logarithmic="y",
    )


def _directions(found: xr.Dataset, system: str) -> Figure:
    speeds = found["speed"].values
    chosen = [int(np.argmin(np.abs(np.log(speeds / speed)))) for speed in (100.0, 200.0, 500.0)]
    values = found["rocking"].sel(system=system)
    lines = [
        Line(f"{speeds[k]:.0f} m/s", [], values.isel(speed=k).max("frequency"), c)
        for c, k in enumerate(dict.fromkeys(chosen))
    ]
    over = "rotation rate over floor velocity [rad/m]"
    return direction_chart(f"Rocking by the wave's direction, {system}", over, found["direction"].values, lines)
