"""Travelling waves in the floor: which direction, speed and frequency rock the machine most.

A wave of vertical velocity v and frequency f that runs at speed c turns the floor at the rate v·2πf/c; a machine on
stiff mounts follows the plane through its four mounts, and most where half a wave lies between them. Rotation rates are
given over the floor's velocity: [rad/s per m/s] = [rad/m].
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.errors import InputError
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.response import ground_response, rigid_floor
from ehamj.plant.axes import AXES, DOFS
from ehamj.plots.charts import Line, direction_chart, map_chart
from ehamj.run.simulate import simulate
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Drawing, Outcome, Progress, labelled, silent
from ehamj.studies.variants import changed, positions, still

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

TURNS = ("machine_velocity rx", "machine_velocity ry")
SETTLED = 2.0
"""Time from which a run is evaluated, for one second [s]."""


@dataclass(frozen=True)
class WaveStudy:
    """Which waves pass below which machine.

    Raises:
        InputError: if a speed or frequency is not positive.
    """

    scenario: Scenario
    axis: Literal["x", "y", "z"] = "z"
    """Direction in which the floor's particles move."""
    speeds: tuple[float, ...] = tuple(np.geomspace(100.0, 2000.0, 27).tolist())
    """Apparent wave speeds [m/s]."""
    directions: tuple[float, ...] = tuple(np.arange(0.0, 360.0, 5.0).tolist())
    """Directions of travel, from +x towards +y [deg]."""
    frequencies: tuple[float, ...] = tuple(np.arange(1.0, 121.0).tolist())
    """Frequencies [Hz]."""

    def __post_init__(self) -> None:
        for name in ("speeds", "frequencies"):
            for value in getattr(self, name):
                if not 0.0 < value < np.inf:
                    raise InputError(f"{name}: {value!r} must be positive and finite")


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


def rocking(study: WaveStudy, model: LinearModel, loop: Loop | None) -> Array:
    """Largest rotation rate over floor velocity [rad/m], (direction, speed, frequency)."""
    f, places = np.array(study.frequencies), positions(study.scenario)
    k = AXES.index(study.axis)
    transfer = ground_response(model, f, TURNS, loop)[:, :, k :: len(AXES)]  # (frequency, output, mount)
    found = np.empty((len(study.directions), len(study.speeds), f.size))
    for i, direction in enumerate(study.directions):
        for j, speed in enumerate(study.speeds):
            motion = wave_motion(places, f, speed, direction, study.axis)[:, :, k]
            turns = np.einsum("fm,fom->of", motion, transfer)
            found[i, j] = largest_turn(*turns)
    return found


def waves(study: WaveStudy, progress: Progress = silent) -> Outcome:
    """Run the study.

    Raises:
        InputError: if the machine has no operating point.
    """
    progress("linear response")
    model, loop = linear_model(study.scenario.plant), Loop.of(study.scenario, study.scenario.controller())
    systems: dict[str, Loop | None] = {"valves held": None} | ({} if loop is None else {"controlled": loop})
    table = rocking_table(study, {name: rocking(study, model, one) for name, one in systems.items()})
    worst = {name: worst_wave(table, name) for name in systems}
    coupling = coupling_table(model, np.array(study.frequencies))
    progress("nonlinear run of the worst wave")
    simulated = simulated_rocking(study, worst["valves held"])
    slope = 2 * np.pi * worst["valves held"]["frequency"] / worst["valves held"]["speed"]
    answers = [
        f"{name.capitalize()}, the wave that rocks the machine most goes towards {one['direction']:.0f}° at "
        f"{one['speed']:.0f} m/s and {one['frequency']:.0f} Hz: {one['rocking']:.3g} rad/s per m/s of floor velocity."
        for name, one in worst.items()
    ]
    answers.append(
        f"The floor itself turns at {slope:.3g} rad/m in the first of these waves; the mounts' distance averages, and "
        "the sway-rocking modes add."
    )
    off = simulated / worst["valves held"]["rocking"] - 1.0
    answers.append(
        f"A nonlinear run of the first wave gives {simulated:.4g} rad/m, {100 * off:+.2f} % off the linear model."
    )
    return Outcome(
        title="Waves that rock the machine",
        question=f"Which wave of {study.axis}-motion in the floor rocks this machine most?",
        answers=tuple(answers),
        tables={
            "directions": _largest(table),
            **{f"map-{_slug(name)}": _at(table, one, name).to_dataset() for name, one in worst.items()},
            "coupling": coupling,
        },
        drawings={
            f"map-{_slug(name)}": Drawing(
                f"Rotation rate over the floor's velocity, {name}, for waves towards {worst[name]['direction']:.0f}°.",
                lambda name=name: _map(table, worst[name], name),  # type: ignore[misc]
            )
            for name in systems
        }
        | {
            "directions": Drawing(
                "Largest rotation rate over the floor's velocity at any frequency, by the direction in which the wave "
                "travels, seen from above.",
                lambda: _directions(table),
            )
        },
        notes=(
            "Plane waves of one frequency; every mount sees the same motion at its own time (coherent floor).",
            "coupling.csv says what a rigid floor's six motions do to the machine's six, as the largest gain at any of "
            "the frequencies; on a symmetric machine a floor that rolls moves y and rx only, one that heaves z only.",
        ),
        numbers={"worst": worst, "simulated_rocking": simulated},
    )


def rocking_table(study: WaveStudy, found: dict[str, Array]) -> xr.Dataset:
    """Label what `rocking` found for each system."""
    over = ("system", "direction", "speed", "frequency")
    return xr.Dataset(
        {"rocking": labelled(over, np.array(list(found.values())), "rad/m", "rotation rate over floor velocity")},
        {
            "system": labelled(("system",), list(found), "", "machine"),
            "direction": labelled(("direction",), list(study.directions), "deg", "direction of travel"),
            "speed": labelled(("speed",), list(study.speeds), "m/s", "wave speed"),
            "frequency": labelled(("frequency",), list(study.frequencies), "Hz", "frequency"),
        },
        {"title": f"rocking in waves of {study.axis}-motion"},
    )


def worst_wave(table: xr.Dataset, system: str) -> dict[str, float]:
    """Direction [deg], speed [m/s], frequency [Hz] and rocking [rad/m] of the wave that rocks most."""
    values = table["rocking"].sel(system=system)
    at = np.unravel_index(int(np.argmax(values.values)), values.shape)
    place = {str(name): float(values[name][k]) for name, k in zip(values.dims, at, strict=True)}
    return place | {"rocking": float(values.values[at])}


def _at(table: xr.Dataset, wave: dict[str, float], system: str) -> xr.DataArray:
    """Rocking of one system over speed and frequency, in the direction of one wave."""
    return table["rocking"].sel(system=system, direction=wave["direction"], drop=True)


def _largest(table: xr.Dataset) -> xr.Dataset:
    """Largest rocking at any frequency, and that frequency, over system, direction and speed."""
    values = table["rocking"]
    found = xr.Dataset({"rocking": values.max("frequency"), "frequency": values.idxmax("frequency")})
    found["rocking"].attrs, found["frequency"].attrs = values.attrs, {"units": "Hz", "long_name": "at frequency"}
    return found.assign_attrs(table.attrs)


def _slug(name: str) -> str:
    return name.replace(" ", "-")


def coupling_table(model: LinearModel, hertz: Array) -> xr.Dataset:
    """Largest gain at ``hertz`` from each motion of a rigid floor to each of the machine's mount plane, 6 by 6."""
    outputs = tuple(f"machine_displacement {dof}" for dof in DOFS)
    gains = np.abs(rigid_floor(model, hertz, None, outputs).response).max(axis=0).T
    return xr.Dataset(
        {"gain": labelled(("floor", "machine"), gains, "m/m, rad/m, m/rad, rad/rad", "largest gain")},
        {
            "floor": labelled(("floor",), list(DOFS), "", "floor"),
            "machine": labelled(("machine",), list(DOFS), "", "machine"),
        },
        {"title": "what a rigid floor's motions move"},
    )


def simulated_rocking(study: WaveStudy, wave: dict[str, float], velocity: float = 1e-5) -> float:
    """Rotation rate over floor velocity [rad/m] in a nonlinear run of one wave with valves held.

    ``velocity`` is the floor's amplitude [m/s]. Frequencies are whole numbers of Hz: a second has whole periods.
    """
    hertz = wave["frequency"]
    ground: dict[str, Any] = {
        "kind": "sine",
        "dof": study.axis,
        "amplitude": velocity / (2 * np.pi * hertz),
        "frequency": hertz,
    }
    ground |= {"wave": {"speed": wave["speed"], "direction": wave["direction"]}, "fade_in": 0.5}
    run = simulate(changed(still(study.scenario), ground=ground, duration=SETTLED + 1.0, record_rate=2000.0))
    part = run.dataset["machine_velocity"].sel(time=slice(SETTLED + 1e-9, None))
    line = np.exp(-2j * np.pi * hertz * part["time"].values)
    phasors = [2.0 * np.mean(part.sel(dof=dof).values * line) for dof in ("rx", "ry")]
    return float(largest_turn(*map(np.asarray, phasors))) / velocity


def _map(table: xr.Dataset, worst: dict[str, float], system: str) -> "Figure":
    values = _at(table, worst, system)
    return map_chart(
        f"Rocking in waves, {system}",
        ("frequency [Hz]", values["frequency"].values),
        ("wave speed [m/s]", values["speed"].values),
        ("rotation rate over floor velocity [rad/m]", values.values),
        points=[Line("worst wave", [worst["frequency"]], [worst["speed"]], color=1, marker="o")],
        logarithmic="y",
    )


def _directions(table: xr.Dataset) -> "Figure":
    speeds = table["speed"].values
    chosen = [int(np.argmin(np.abs(np.log(speeds / speed)))) for speed in (100.0, 200.0, 500.0)]
    lines = [
        Line(
            f"{speeds[k]:.0f} m/s, {system}",
            [],
            table["rocking"].sel(system=system).isel(speed=k).max("frequency"),
            c,
            d,
        )
        for d, system in enumerate(table["system"].values)
        for c, k in enumerate(dict.fromkeys(chosen))
    ]
    return direction_chart("Rocking by the wave's direction", "rad/s per m/s", table["direction"].values, lines)
