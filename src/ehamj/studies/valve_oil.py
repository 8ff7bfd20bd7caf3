"""Valve and oil: what their parameters do to the machine's modes, and how fast a position loop may be."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.control.sensors import IDEAL
from ehamj.designs.designs import Designs
from ehamj.designs.many import RIGID_MODES, modes_of
from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.plots.charts import Line, lines_chart
from ehamj.scenario.model import Scenario
from ehamj.studies.gains import highest_factor, inertial_position
from ehamj.studies.outcome import Drawing, Outcome, Progress, labelled, silent
from ehamj.studies.variants import changed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

OIL: Final = ("bulk_modulus", "chamber_volume", "piston_area", "flow_pressure", "membrane_stiffness")
"""What decides the modes with valves held."""
VALVE: Final = ("valve_frequency", "valve_damping")
"""What decides, besides, how fast a loop may be."""
TRIED: Final = 20.0
"""Crossover of the loop whose gain is raised [Hz]."""


@dataclass(frozen=True)
class ValveOilStudy:
    """Factors on one parameter of every actuator at a time, and shares of entrained air.

    Raises:
        InputError: if a factor is not positive, or a share of air not below one.
    """

    scenario: Scenario
    factors: tuple[float, ...] = tuple(np.geomspace(0.25, 4.0, 33).tolist())
    loops: tuple[float, ...] = (0.25, 0.5, 1.0, 2.0, 4.0)
    """Factors at which the fastest position loop is looked for."""
    looped: tuple[str, ...] = (*VALVE, *OIL)
    """Parameters that are changed for it."""
    air: tuple[float, ...] = tuple(np.linspace(0.0, 0.05, 26).tolist())
    """Entrained air at 1 atm [-], the given modulus being the liquid's."""

    def __post_init__(self) -> None:
        for factor in (*self.factors, *self.loops):
            if not 0.0 < factor < np.inf:
                raise InputError(f"factors: {factor!r} must be positive and finite")
        for share in self.air:
            if not 0.0 <= share < 1.0:
                raise InputError(f"air: {share!r} must be from 0 to below 1")


def _every(scenario: Scenario, name: str, values: xr.DataArray, relative: bool = True) -> dict[str, xr.DataArray]:
    """One quantity of all actuators in use, varied together."""
    used = sorted({mount.actuator for mount in scenario.mount})
    own = {one: getattr(scenario.actuators[one], name) if relative else 1.0 for one in used}
    return {f"actuators.{one}.{name}": values * own[one] for one in used}


def modes_over_factors(study: ValveOilStudy) -> xr.Dataset:
    """Modes with valves held over (parameter, factor, mode), one parameter of `OIL` at a time."""
    factor = xr.DataArray(np.array(study.factors), dims="factor")
    parts = [modes_of(Designs.of(study.scenario, _every(study.scenario, name, factor))) for name in OIL]
    table = xr.concat(
        [part[["frequency", "damping_ratio"]].reset_coords(drop=True).drop_vars("factor") for part in parts],
        "parameter",
    )
    return table.assign_coords(
        parameter=labelled(("parameter",), list(OIL), "", "parameter"),
        factor=labelled(("factor",), list(study.factors), "1", "factor"),
    ).assign_attrs(title="modes over oil and cylinder, one at a time")


def modes_over_air(study: ValveOilStudy) -> xr.Dataset:
    """Modes with valves held over the share of entrained air."""
    share = xr.DataArray(np.array(study.air), dims="air")
    part = modes_of(Designs.of(study.scenario, _every(study.scenario, "air_fraction", share, relative=False)))
    return part[["frequency", "damping_ratio"]].reset_coords(drop=True).assign_coords(
        air=labelled(("air",), list(study.air), "1", "entrained air at 1 atm, by volume")
    ).assign_attrs(title="modes over entrained air")  # fmt: skip


def fastest_loops(study: ValveOilStudy, progress: Progress = silent) -> xr.Dataset:
    """Crossover [Hz] at which position loops of all four valves become unstable, over (parameter, factor).

    The loop is `ehamj.studies.gains.inertial_position`, built for the changed actuators.
    """
    names = study.looped
    crossover = np.empty((len(names), len(study.loops)))
    for i, name in enumerate(names):
        progress(f"loops: {name}")
        for j, factor in enumerate(study.loops):
            scenario = _scaled(study.scenario, name, factor)
            loop = Loop(inertial_position(scenario.plant, TRIED), IDEAL, 0)
            crossover[i, j] = TRIED * highest_factor(linear_model(scenario.plant), loop)
    return xr.Dataset(
        {"crossover": labelled(("parameter", "factor"), crossover, "Hz", "crossover at the limit of stability")},
        {
            "parameter": labelled(("parameter",), list(names), "", "parameter"),
            "factor": labelled(("factor",), list(study.loops), "1", "factor"),
        },
        {"title": "fastest position loop"},
    )


def _scaled(scenario: Scenario, name: str, factor: float) -> Scenario:
    tables = {
        key: one.with_values({name: factor * getattr(one, name)}).model_dump()
        for key, one in scenario.actuators.items()
    }
    return changed(scenario, actuators=tables)


def valve_and_oil(study: ValveOilStudy, progress: Progress = silent) -> Outcome:
    """Run the study.

    Raises:
        InputError: if the machine has no linear model in closed form.
    """
    progress("modes")
    table, air = modes_over_factors(study), modes_over_air(study)
    loops = fastest_loops(study, progress)
    return Outcome(
        title="Valve and oil",
        question="What do valve and oil do to the machine's modes, and to the speed of a loop?",
        answers=_answers(study, table, air, loops),
        tables={"modes": table, "air": air, "loops": loops},
        drawings={
            "heave": Drawing(
                "Heave, which compresses the oil of all mounts: frequency and damping over one parameter at a time.",
                lambda: _modes_chart(table, "heave"),
            ),
            "sway": Drawing(
                "The lower sway-rocking mode about x, which oil reaches only through rocking.",
                lambda: _modes_chart(table, "lower about x"),
            ),
            "air": Drawing("Frequencies of the modes over entrained air.", lambda: _air_chart(air)),
            "loops": Drawing(
                "Crossover at which position loops of all valves become unstable, over one parameter at a time.",
                lambda: _loops_chart(loops),
            ),
        },
        notes=(
            "All actuators are changed alike. Modes are those with valves held, at rest under gravity.",
            "The loop feeds each foot's absolute position back to its valve at 10 kHz with one sample of delay; it is "
            "built for the changed actuator, and its gain raised until the machine becomes unstable. A margin of 6 dB "
            "halves the crossover.",
        ),
    )


def _answers(study: ValveOilStudy, table: xr.Dataset, air: xr.Dataset, loops: xr.Dataset) -> tuple[str, ...]:
    heave = table.sel(mode="heave")
    here = heave.sel(parameter="bulk_modulus").sel(factor=1.0, method="nearest")
    leak = heave.sel(parameter="flow_pressure").sel(factor=2.0, method="nearest")
    with_air = air.sel(mode="heave").sel(air=0.01, method="nearest")
    crossing = loops["crossover"]
    at_one = float(crossing.isel(parameter=0).sel(factor=1.0))
    gain = {
        str(name): float(crossing.sel(parameter=name, factor=2.0)) / at_one for name in crossing["parameter"].values
    }
    best, worst = max(gain, key=lambda name: gain[name]), min(gain, key=lambda name: gain[name])
    return (
        f"Heave lies at {float(here['frequency']):.0f} Hz with {100 * float(here['damping_ratio']):.1f} % "
        "damping; twice the "
        f"leakage {Actuator.quantities()['flow_pressure'][1]} gives {100 * float(leak['damping_ratio']):.1f} %.",
        f"{100 * float(with_air['air']):.1f} % of entrained air brings it down to "
        f"{float(with_air['frequency']):.0f} Hz.",
        f"Position loops of all valves become unstable when they cross at {at_one:.0f} Hz; twice the "
        f"{best.replace('_', ' ')} "
        f"allows {gain[best]:.2f} times that, twice the {worst.replace('_', ' ')} {gain[worst]:.2f} times.",
    )


def _modes_chart(table: xr.Dataset, mode: str) -> "Figure":
    one = table.sel(mode=mode)
    panels = {
        quantity: [
            Line(name.replace("_", " "), one["factor"].values, factor * one[what].sel(parameter=name).values, k, k)
            for k, name in enumerate(OIL)
        ]
        for quantity, what, factor in (
            ("frequency [Hz]", "frequency", 1.0),
            ("damping ratio [%]", "damping_ratio", 100.0),
        )
    }
    return lines_chart(mode.capitalize(), "factor on the parameter", panels, "x", {"as it is": 1.0})


def _air_chart(air: xr.Dataset) -> "Figure":
    share = 100 * air["air"].values
    lines = [Line(mode, share, air["frequency"].sel(mode=mode).values, k, k % 2) for k, mode in enumerate(RIGID_MODES)]
    return lines_chart("Modes over entrained air", "air at 1 atm [% by volume]", {"frequency [Hz]": lines})


def _loops_chart(loops: xr.Dataset) -> "Figure":
    f = loops["factor"].values
    lines = [
        Line(str(name).replace("_", " "), f, loops["crossover"].sel(parameter=name).values, k, k)
        for k, name in enumerate(loops["parameter"].values)
    ]
    panels = {"crossover at the limit [Hz]": lines}
    return lines_chart("Fastest position loop", "factor on the parameter", panels, "x", {"as it is": 1.0})
