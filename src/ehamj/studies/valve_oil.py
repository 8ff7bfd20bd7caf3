"""Valve and oil: what their parameters do to the machine's modes, and how fast a position loop may be."""

from typing import Annotated, Final

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.control.sensors import IDEAL
from ehamj.designs.designs import Designs
from ehamj.designs.many import modes_of
from ehamj.isolator.actuator import Actuator
from ehamj.labels import labelled, table
from ehamj.linear.loop import Loop, linear_under
from ehamj.plots import Figure, lines_chart
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress, curves, silent
from ehamj.studies.position_loop import highest_factor, inertial_position
from ehamj.studies.study import Positive, among, study
from ehamj.studies.variants import every_value

OIL: Final = ("bulk_modulus", "chamber_volume", "piston_area", "flow_pressure", "membrane_stiffness")
"""What decides the modes with valves held."""
VALVE: Final = ("valve_frequency", "valve_damping")
"""What decides, besides, how fast a loop may be."""
TRIED: Final = 20.0
"""Crossover of the loop whose gain is raised [Hz]."""


class ValveOilSettings(Settings):
    """Factors on one parameter of every actuator at a time, and shares of entrained air."""

    factors: tuple[Positive, ...] = Field(
        tuple(np.geomspace(0.25, 4.0, 33).tolist()), min_length=1, description="factors on a parameter"
    )
    loops: tuple[Positive, ...] = Field(
        (0.25, 0.5, 1.0, 2.0, 4.0), description="factors at which the fastest position loop is looked for; 1 and 2 too"
    )
    looped: tuple[Annotated[str, among((*VALVE, *OIL))], ...] = Field(
        (*VALVE, *OIL), min_length=1, description="parameters that are changed for it"
    )
    air: tuple[Annotated[float, Field(ge=0, lt=1)], ...] = Field(
        tuple(np.linspace(0.0, 0.05, 26).tolist()),
        min_length=1,
        description="entrained air at 1 atm, the given modulus being the liquid's [-]",
    )


def modes_over_factors(scenario: Scenario, settings: ValveOilSettings) -> xr.Dataset:
    """Modes with valves held over (parameter, factor, mode), one parameter of `OIL` at a time."""
    factor = xr.DataArray(np.array(settings.factors), dims="factor")
    parts = [_modes(scenario, every_value(scenario, name, factor)).drop_vars("factor") for name in OIL]
    return xr.concat(parts, "parameter").assign_coords(
        parameter=labelled(("parameter",), list(OIL), "", "parameter"),
        factor=labelled(("factor",), list(settings.factors), "1", "factor"),
    ).assign_attrs(title="modes over oil and cylinder, one at a time")  # fmt: skip


def modes_over_air(scenario: Scenario, settings: ValveOilSettings) -> xr.Dataset:
    """Modes with valves held over the share of entrained air."""
    share = xr.DataArray(np.array(settings.air), dims="air")
    found = _modes(scenario, every_value(scenario, "air_fraction", share, relative=False))
    column = labelled(("air",), list(settings.air), "1", "entrained air at 1 atm, by volume")
    return found.assign_coords(air=column).assign_attrs(title="modes over entrained air")


def _modes(scenario: Scenario, vary: dict[str, xr.DataArray]) -> xr.Dataset:
    return modes_of(Designs.of(scenario, vary))[["frequency", "damping_ratio"]].reset_coords(drop=True)


def fastest_loops(scenario: Scenario, settings: ValveOilSettings, progress: Progress = silent) -> xr.Dataset:
    """Crossover [Hz] at which position loops of all valves become unstable, over (parameter, factor).

    The loop is `ehamj.studies.position_loop.inertial_position`, built for the changed actuators.
    """
    factors = sorted({1.0, 2.0, *settings.loops})
    crossover = np.empty((len(settings.looped), len(factors)))
    for i, name in enumerate(settings.looped):
        progress(f"loops: {name}")
        for j, factor in enumerate(factors):
            one = _scaled(scenario, name, factor)
            loop = Loop(inertial_position(one.plant, TRIED), IDEAL, 0)
            crossover[i, j] = TRIED * highest_factor(linear_under(one.plant, loop.law), loop)
    return table(
        "fastest position loop",
        {"parameter": (list(settings.looped), "", "parameter"), "factor": (factors, "1", "factor")},
        crossover=(crossover, "Hz", "crossover at the limit of stability"),
    )


def _scaled(scenario: Scenario, name: str, factor: float) -> Scenario:
    own = {key: getattr(one, name) for key, one in scenario.actuators.items()}
    return changed(scenario, {f"actuators.{key}.{name}": factor * value for key, value in own.items()})


@study(
    "valve-and-oil",
    ValveOilSettings,
    "what valve and oil do to the modes, and to the fastest loop",
    small={"factors": (0.5, 1.0, 2.0), "air": (0.0, 0.01), "loops": (1.0, 2.0), "looped": ("valve_frequency",)},
)
def valve_and_oil(scenario: Scenario, settings: ValveOilSettings, progress: Progress) -> Outcome:
    """A machine that has no linear model in closed form is refused."""
    progress("modes")
    oil, air = modes_over_factors(scenario, settings), modes_over_air(scenario, settings)
    loops = fastest_loops(scenario, settings, progress)
    return Outcome(
        title="Valve and oil",
        question="What do valve and oil do to the machine's modes, and to the speed of a loop?",
        answers=_answers(oil, air, loops),
        tables={"modes": oil, "air": air, "loops": loops},
        drawings={
            "heave": Drawing(
                "Heave, which compresses the oil of all mounts: frequency and damping over one parameter at a time.",
                lambda: _modes_chart(oil, "heave"),
            ),
            "sway": Drawing(
                "The lower sway-rocking mode about x, which oil reaches only through rocking.",
                lambda: _modes_chart(oil, "lower about x"),
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


def _answers(oil: xr.Dataset, air: xr.Dataset, loops: xr.Dataset) -> tuple[str, ...]:
    heave = oil.sel(mode="heave")
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


def _modes_chart(oil: xr.Dataset, mode: str) -> Figure:
    one = oil.sel(mode=mode)
    panels = {
        "frequency [Hz]": curves(one["frequency"], "parameter"),
        "damping ratio [%]": curves(100.0 * one["damping_ratio"], "parameter"),
    }
    return lines_chart(mode.capitalize(), "factor on the parameter", panels, "x", {"as it is": 1.0})


def _air_chart(air: xr.Dataset) -> Figure:
    over = air["frequency"].assign_coords(air=100 * air["air"])
    panels = {"frequency [Hz]": curves(over, "mode", 2)}
    return lines_chart("Modes over entrained air", "air at 1 atm [% by volume]", panels)


def _loops_chart(loops: xr.Dataset) -> Figure:
    panels = {"crossover at the limit [Hz]": curves(loops["crossover"], "parameter")}
    return lines_chart("Fastest position loop", "factor on the parameter", panels, "x", {"as it is": 1.0})
