"""Rocking over the height of the centre of gravity and the distance of the mounts: thousands of designs at once."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.designs.footprint import LOWER, rocking_modes, slowest_rocking
from ehamj.errors import InputError
from ehamj.estimate.identification import realise
from ehamj.mujoco import hydraulics
from ehamj.plant.axes import DOFS
from ehamj.plots.charts import Line, map_chart
from ehamj.rig.ringdown import JOLTS, PULSE
from ehamj.run.simulate import simulate
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Drawing, Outcome, Progress, labelled, silent
from ehamj.studies.variants import positions, preset, resized, still, with_every_actuator

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

SAMPLES, ORDER = 320, 22
"""Samples of a ring-down, and eigenvalues looked for in it."""


@dataclass(frozen=True)
class RockingStudy:
    """The map, and how many of its designs are run.

    Raises:
        InputError: if a range is not rising and positive.
    """

    scenario: Scenario
    heights: tuple[float, float] = (0.2, 2.6)
    """Lowest and highest CG above the mount plane [m]."""
    widths: tuple[float, float] = (0.3, 1.8)
    """Smallest and largest factor on the mounts' places."""
    points: int = 51
    """Designs each way."""
    confirmed: int = 20
    """Random designs that are run."""
    soft: str = "pneumatic-mount"
    """Preset of the second map, on which tall machines tip."""

    def __post_init__(self) -> None:
        for name in ("heights", "widths"):
            low, high = getattr(self, name)
            if not 0.0 < low < high < np.inf:
                raise InputError(f"{name} = {(low, high)!r}: must be two rising, positive, finite numbers")


def rocking_map(study: RockingStudy, scenario: Scenario) -> xr.Dataset:
    """Modes of every design over ``height`` and ``width``: frequency, damping, growth rate and tipping margin."""
    height = xr.DataArray(np.linspace(*study.heights, study.points), dims="height")
    width = xr.DataArray(np.linspace(*study.widths, study.points), dims="width")
    return rocking_modes(scenario, height, width).assign_coords(
        height=labelled(("height",), height.values, "m", "CG height"),
        width=labelled(("width",), width.values, "1", "factor on the mounts' places"),
        distance=labelled(
            ("width",), width.values * np.ptp(positions(scenario)[:, 1]), "m", "distance of the mounts in y"
        ),
    )


def confirmed_designs(study: RockingStudy, progress: Progress = silent) -> xr.Dataset:
    """Random designs of the map: lower sway-rocking frequencies computed, and identified from nonlinear ring-downs.

    Over ``design`` and ``mode`` (`LOWER`): ``computed`` and ``identified`` [Hz], ``deviation`` [-].
    """
    random = np.random.default_rng(study.scenario.seed)
    height, width = random.uniform(*study.heights, study.confirmed), random.uniform(*study.widths, study.confirmed)
    sample = rocking_modes(study.scenario, xr.DataArray(height, dims="design"), xr.DataArray(width, dims="design"))
    computed = sample["frequency"].sel(mode=list(LOWER)).transpose("design", "mode").values
    cases = list(zip(height, width, np.nan_to_num(computed, nan=np.inf).min(axis=1), strict=True))
    identified = np.empty_like(computed)
    with hydraulics():
        for k, (h, w, slowest) in enumerate(cases):
            progress(f"ring-down {k + 1} of {len(cases)}")
            identified[k] = _identified(study.scenario, h, w, slowest, computed[k])
    over = ("design", "mode")
    return xr.Dataset(
        {
            "height": labelled(("design",), height, "m", "CG height"),
            "width": labelled(("design",), width, "1", "factor on the mounts' places"),
            "computed": labelled(over, computed, "Hz", "natural frequency, linear"),
            "identified": labelled(over, identified, "Hz", "natural frequency, from a nonlinear ring-down"),
            "deviation": labelled(over, identified / computed - 1.0, "1", "deviation"),
        },
        {
            "design": labelled(("design",), np.arange(1, len(cases) + 1), "1", "design"),
            "mode": labelled(("mode",), list(LOWER), "", "mode"),
        },
        {"title": "random designs, confirmed by nonlinear ring-downs"},
    )


def _identified(scenario: Scenario, height: float, width: float, slowest: float, wanted: Array) -> Array:
    """Frequencies [Hz] of a design's ring-down that are nearest to those wanted."""
    cg = (*scenario.machine.cg[:2], height)
    one = still(scenario, plates="tied", **resized(scenario, cg, width * positions(scenario)))
    duration = max(0.12, 5.0 / slowest)
    rate = float(np.ceil(SAMPLES / duration))
    jolts = [
        {"kind": "shock", "dof": dof, "velocity": v, "pulse_time": PULSE, "begin": 1e-3, "return_time": 1e6}
        for dof, v in JOLTS.items()
    ]
    table = {"ground": {"kind": "sum", "parts": jolts}, "duration": duration, "record_rate": rate}
    motion = simulate(still(one, timestep=1.0 / rate / np.ceil(1e4 / rate), **table)).dataset["machine_displacement"]
    moved = np.array([JOLTS[dof] * 2 * PULSE / np.pi for dof in DOFS])  # where the floor has come to rest
    decay = (motion - motion[0]).sel(time=slice(1e-3 + PULSE + 0.5 / rate, None)).values - moved
    ((poles, _),) = realise(decay / np.abs(decay).max(axis=0), rate, (ORDER,))
    found = np.abs(poles[poles.imag > 0.0]) / (2 * np.pi)
    nearest = [found[np.argmin(np.abs(found - frequency))] for frequency in wanted]
    return np.where(np.isnan(wanted), np.nan, nearest)


def rocking(study: RockingStudy, progress: Progress = silent) -> Outcome:
    """Run the study.

    Raises:
        InputError: if the machine has no linear model in closed form.
    """
    progress(f"{study.points**2} designs")
    own = rocking_map(study, study.scenario)
    bare = still(study.scenario)
    soft = rocking_map(study, still(bare, **with_every_actuator(bare, preset(study.soft))))
    runs = confirmed_designs(study, progress)
    worst = float(np.nanmax(np.abs(runs["deviation"].values)))
    slow, soft_slow = slowest_rocking(own), slowest_rocking(soft)
    itself = rocking_modes(
        study.scenario, xr.DataArray([study.scenario.machine.cg[2]], dims="d"), xr.DataArray([1.0], dims="d")
    )
    here = slowest_rocking(itself)[0]
    low, high = slow.isel(height=-1, width=0), slow.isel(height=0, width=-1)
    tips = int((soft["tipping_margin"] < 0).sum())
    return Outcome(
        title="Rocking over CG height and footprint",
        question="How slowly does the machine sway and rock, and which designs stand?",
        answers=(
            f"Of {slow.size} designs the slowest sway-rocking mode lies between {float(low):.1f} Hz (CG highest, "
            f"mounts closest) and {float(high):.1f} Hz (lowest, widest); this machine has {float(here):.1f} Hz.",
            f"On {study.soft}s, {tips} of {soft_slow.size} designs tip over: those above the red line, where m g h "
            "exceeds Σ k y².",
            f"{study.confirmed} random designs, run and identified from their ring-down, agree within "
            f"{100 * worst:.2g} %.",
        ),
        tables={"own-actuators": own, study.soft: soft, "confirmed": runs},
        drawings={
            "own": Drawing(
                "Natural frequency of the slowest sway-rocking mode on the machine's own actuators, valves held. "
                "Dots: designs confirmed by nonlinear runs.",
                lambda: _chart(study, own, "On its own actuators", runs),
            ),
            "damping": Drawing(
                "Damping ratio of the least damped sway-rocking mode of the same designs.",
                lambda: _damping_chart(study, own),
            ),
            "soft": Drawing(
                f"The same on {study.soft}s; red: the machine tips over.",
                lambda: _chart(study, soft, f"On {study.soft}s"),
            ),
        },
        notes=(
            "Mass and inertia about the CG are kept; the mounts keep their proportions, of which the distance in y is "
            "shown.",
            "White: one of the two modes does not oscillate. Valves held, small motions. own-actuators.nc holds "
            "all six modes, growth rate and tipping margin of each.",
        ),
        numbers={"designs": int(slow.size), "largest_deviation": worst, "tipping_designs": tips},
    )


def _chart(study: RockingStudy, modes: xr.Dataset, title: str, runs: xr.Dataset | None = None) -> "Figure":
    across = np.ptp(positions(study.scenario)[:, 1])
    marks = [Line("this machine", [across], [study.scenario.machine.cg[2]], color=1, marker="s")]
    if runs is not None:
        marks.append(Line("confirmed by runs", across * runs["width"].values, runs["height"].values, 7, marker="."))
    return map_chart(
        title,
        ("distance of the mounts in y [m]", modes["distance"].values),
        ("CG height [m]", modes["height"].values),
        ("slowest sway-rocking [Hz]", slowest_rocking(modes).transpose("height", "width").values),
        boundary=("tips over", -modes["tipping_margin"].transpose("height", "width").values),
        points=marks,
    )


def _damping_chart(study: RockingStudy, modes: xr.Dataset) -> "Figure":
    least = modes["damping_ratio"].sel(mode=list(LOWER)).min("mode").transpose("height", "width")
    across = np.ptp(positions(study.scenario)[:, 1])
    return map_chart(
        "Damping of sway-rocking",
        ("distance of the mounts in y [m]", modes["distance"].values),
        ("CG height [m]", modes["height"].values),
        ("damping ratio [%]", 100 * least.values),
        levels=(2.0, 3.0, 3.5, 4.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0),
        points=[Line("this machine", [across], [study.scenario.machine.cg[2]], color=1, marker="s")],
    )
