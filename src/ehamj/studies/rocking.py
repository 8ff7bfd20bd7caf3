"""Rocking over the height of the centre of gravity and the distance of the mounts: thousands of designs at once."""

from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.arrays import Array
from ehamj.designs.footprint import LOWER, rocking_modes, slowest_rocking
from ehamj.estimate.identification import realise
from ehamj.isolator.presets import ACTUATOR_PRESETS
from ehamj.labels import labelled, table
from ehamj.mujoco import hydraulics
from ehamj.plots import Figure, Line, map_chart
from ehamj.rig.ringdown import JOLTS, decay, jolt, step_for
from ehamj.run.simulate import observed
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress, silent
from ehamj.studies.study import Range, among, study
from ehamj.studies.variants import positions, preset, resized, still, with_every_actuator

CREEPS = "a mode creeps: no frequency"
SAMPLES, ORDER = 320, 22
"""Samples of a ring-down, and eigenvalues looked for in it."""


class RockingSettings(Settings):
    """The map, and how many of its designs are run."""

    heights: Range = Field((0.2, 2.6), description="lowest and highest CG above the mount plane [m]")
    widths: Range = Field((0.3, 1.8), description="smallest and largest factor on the mounts' places")
    points: int = Field(51, ge=2, description="designs each way")
    confirmed: int = Field(20, ge=1, description="random designs that are run")
    soft: Annotated[str, among(ACTUATOR_PRESETS)] = Field(
        "pneumatic-mount", description="preset of the second map, on which tall machines tip"
    )


def rocking_map(scenario: Scenario, settings: RockingSettings) -> xr.Dataset:
    """Modes of every design over ``height`` and ``width``: frequency, damping, growth rate and tipping margin."""
    height = np.linspace(*settings.heights, settings.points)
    width = np.linspace(*settings.widths, settings.points)
    found = rocking_modes(scenario, xr.DataArray(height, dims="height"), xr.DataArray(width, dims="width"))
    return found.assign_coords(
        height=labelled(("height",), height, "m", "CG height"),
        width=labelled(("width",), width, "1", "factor on the mounts' places"),
        distance=labelled(("width",), width * np.ptp(positions(scenario)[:, 1]), "m", "distance of the mounts in y"),
    )


def soft_map(scenario: Scenario, settings: RockingSettings) -> xr.Dataset:
    """The same map of the machine on soft mounts."""
    bare = still(scenario)
    return rocking_map(still(bare, **with_every_actuator(bare, preset(settings.soft))), settings)


def confirmed_designs(scenario: Scenario, settings: RockingSettings, progress: Progress = silent) -> xr.Dataset:
    """Random designs of the map: lower sway-rocking frequencies computed, and identified from nonlinear ring-downs.

    Over ``design`` and ``mode`` (`LOWER`): ``computed`` and ``identified`` [Hz], ``deviation`` [-].
    """
    random, many = np.random.default_rng(scenario.seed), settings.confirmed
    height, width = random.uniform(*settings.heights, many), random.uniform(*settings.widths, many)
    sample = rocking_modes(scenario, xr.DataArray(height, dims="design"), xr.DataArray(width, dims="design"))
    computed = sample["frequency"].sel(mode=list(LOWER)).transpose("design", "mode").values
    slowest = np.nan_to_num(computed, nan=np.inf).min(axis=1)
    identified = np.empty_like(computed)
    with hydraulics():
        for k in range(many):
            progress(f"ring-down {k + 1} of {many}")
            identified[k] = _identified(scenario, height[k], width[k], slowest[k], computed[k])
    return table(
        "random designs, confirmed by nonlinear ring-downs",
        {"design": (np.arange(1, many + 1), "1", "design"), "mode": (list(LOWER), "", "mode")},
        height=(("design",), height, "m", "CG height"),
        width=(("design",), width, "1", "factor on the mounts' places"),
        computed=(computed, "Hz", "natural frequency, linear"),
        identified=(identified, "Hz", "natural frequency, from a nonlinear ring-down"),
        deviation=(identified / computed - 1.0, "1", "deviation"),
    )


def _identified(scenario: Scenario, height: float, width: float, slowest: float, wanted: Array) -> Array:
    """Frequencies [Hz] of a design's ring-down that are nearest to those wanted."""
    cg = (*scenario.machine.cg[:2], height)
    one = still(scenario, plates="tied", **resized(scenario, cg, width * positions(scenario)))
    duration = max(0.12, 5.0 / slowest)
    rate = float(np.ceil(SAMPLES / duration))
    ground = {"kind": "sum", "parts": [jolt(dof) for dof in JOLTS]}
    run = observed(still(one, ground=ground, duration=duration, record_rate=rate, timestep=step_for(rate)))
    after = decay(run, *JOLTS)
    ((poles, _),) = realise(after / np.abs(after).max(axis=0), rate, (ORDER,))
    found = np.abs(poles[poles.imag > 0.0]) / (2 * np.pi)
    nearest = [found[np.argmin(np.abs(found - frequency))] for frequency in wanted]
    return np.where(np.isnan(wanted), np.nan, nearest)


@study(
    "rocking",
    RockingSettings,
    "sway and rocking over CG height and footprint: 2,601 designs, and where soft mounts let them tip",
    small={"points": 3, "confirmed": 1},
)
def rocking(scenario: Scenario, settings: RockingSettings, progress: Progress) -> Outcome:
    """A machine that has no linear model in closed form is refused."""
    progress(f"{settings.points**2} designs")
    own, soft = rocking_map(scenario, settings), soft_map(scenario, settings)
    runs = confirmed_designs(scenario, settings, progress)
    worst = float(np.nanmax(np.abs(runs["deviation"].values)))
    slow, kind = slowest_rocking(own), settings.soft
    here = slowest_rocking(
        rocking_modes(scenario, xr.DataArray([scenario.machine.cg[2]], dims="d"), xr.DataArray([1.0], dims="d"))
    )
    low, high = float(slow.isel(height=-1, width=0)), float(slow.isel(height=0, width=-1))
    tips = int((soft["tipping_margin"] < 0).sum())
    return Outcome(
        title="Rocking over CG height and footprint",
        question="How slowly does the machine sway and rock, and which designs stand?",
        answers=(
            f"Of {slow.size} designs the slowest sway-rocking mode lies between {_hertz(low)} (CG highest, "
            f"mounts closest) and {_hertz(high)} (lowest, widest); this machine has {_hertz(float(here[0]))}.",
            f"On {kind}s, {tips} of {slow.size} designs tip over: those above the red line, where "
            f"{'m g h exceeds Σ k y²' if scenario.plant.flat else 'gravity takes all stiffness of a motion'}.",
            f"{settings.confirmed} random designs, run and identified from their ring-down, agree within "
            f"{100 * worst:.2g} %.",
        ),
        tables={"own-actuators": own, kind: soft, "confirmed": runs},
        drawings={
            "own": Drawing(
                "Natural frequency of the slowest sway-rocking mode on the machine's own actuators, valves held. "
                "Dots: designs confirmed by nonlinear runs.",
                lambda: _slowest_chart(scenario, own, "On its own actuators", runs),
            ),
            "damping": Drawing(
                "Damping ratio of the least damped sway-rocking mode of the same designs.",
                lambda: _damping_chart(scenario, own),
            ),
            "soft": Drawing(
                f"The same on {kind}s; red: the machine tips over.",
                lambda: _slowest_chart(scenario, soft, f"On {kind}s"),
            ),
        },
        notes=(
            "Mass and inertia about the CG are kept; the mounts keep their proportions, of which the distance in y is "
            "shown.",
            "Grey: one of the two modes creeps back without oscillating, and has no frequency. Valves held, small "
            "motions. own-actuators.nc holds all six modes, growth rate and tipping margin of each.",
        ),
        numbers={"designs": int(slow.size), "largest_deviation": worst, "tipping_designs": tips},
    )


def _hertz(frequency: float) -> str:
    return "no frequency (it creeps or tips)" if np.isnan(frequency) else f"{frequency:.1f} Hz"


def _slowest_chart(scenario: Scenario, modes: xr.Dataset, title: str, runs: xr.Dataset | None = None) -> Figure:
    marks = []
    if runs is not None:
        across = np.ptp(positions(scenario)[:, 1]) * runs["width"].values
        marks = [Line("confirmed by runs", across, runs["height"].values, 7, marker=".")]
    boundary = ("tips over", -modes["tipping_margin"].transpose("height", "width").values)
    slowest = slowest_rocking(modes)
    return _chart(scenario, title, ("slowest sway-rocking [Hz]", slowest), points=marks, boundary=boundary)


def _damping_chart(scenario: Scenario, modes: xr.Dataset) -> Figure:
    least = 100 * modes["damping_ratio"].sel(mode=list(LOWER)).min("mode")
    levels = (2.0, 3.0, 3.5, 4.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0)
    return _chart(scenario, "Damping of sway-rocking", ("damping ratio [%]", least), levels=levels)


def _chart(
    scenario: Scenario, title: str, values: tuple[str, xr.DataArray], points: Sequence[Line] = (), **options: Any
) -> Figure:
    """A quantity over distance and height, with the machine as it is."""
    name, found = values
    across = np.ptp(positions(scenario)[:, 1])
    return map_chart(
        title,
        ("distance of the mounts in y [m]", found["distance"].values),
        ("CG height [m]", found["height"].values),
        (name, found.transpose("height", "width").values),
        points=[Line("this machine", [across], [scenario.machine.cg[2]], color=1, marker="s"), *points],
        blank=CREEPS,
        **options,
    )
