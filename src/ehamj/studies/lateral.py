"""Lateral stiffness of the mounts: where sway ends and rocking begins, and what a floor that sways does."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.designs.designs import Designs
from ehamj.designs.many import RIGID_MODES, floor_response, modes_of
from ehamj.errors import InputError
from ehamj.plots.charts import Line, lines_chart, map_chart
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Drawing, Outcome, Progress, labelled, silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LateralStudy:
    """Factors on the lateral stiffness of every mount; its lateral damping is kept.

    Raises:
        InputError: if the range is not rising and positive.
    """

    scenario: Scenario
    factors: tuple[float, float] = (0.02, 50.0)
    points: int = 121

    def __post_init__(self) -> None:
        low, high = self.factors
        if not 0.0 < low < high < np.inf:
            raise InputError(f"factors = {self.factors!r}: must be two rising, positive, finite numbers")


def designs(study: LateralStudy) -> tuple[Array, Designs]:
    """Factors, and the designs over the dimension ``factor``."""
    factors = np.geomspace(*study.factors, study.points)
    used = {mount.actuator for mount in study.scenario.mount}
    vary = {
        f"actuators.{name}.lateral_stiffness": xr.DataArray(
            factors * study.scenario.actuators[name].lateral_stiffness, dims="factor"
        )
        for name in sorted(used)
    }
    return factors, Designs.of(study.scenario, vary)


def lateral_stiffness(study: LateralStudy, progress: Progress = silent) -> Outcome:
    """Run the study.

    Raises:
        InputError: if the machine has no linear model in closed form.
    """
    progress("modes and floor response")
    factors, many = designs(study)
    mean = float(np.mean([actuator.lateral_stiffness for actuator in study.scenario.plant.actuators]))
    hertz = np.geomspace(2.0, 500.0, 121)
    coordinates = {
        "factor": labelled(("factor",), factors, "1", "factor on the lateral stiffness"),
        "stiffness": labelled(("factor",), mean * factors, "N/m", "mean lateral stiffness of a mount"),
    }
    modes = modes_of(many)[["frequency", "damping_ratio"]].reset_coords(drop=True).assign_coords(coordinates)
    modes.attrs["title"] = "modes over the lateral stiffness"
    sway = xr.apply_ufunc(np.abs, floor_response(many, hertz, "x").sel(output="cg x")).reset_coords(drop=True)
    response = (
        sway.assign_coords(coordinates).rename("gain").assign_attrs(units="1", long_name="CG over floor, along x")
    )
    response["frequency"].attrs = {"units": "Hz", "long_name": "frequency"}
    here = modes.sel(factor=1.0, method="nearest")
    soft, stiff = modes.isel(factor=0), modes.isel(factor=-1)
    told = [
        f"{mode} {float(here['frequency'].sel(mode=mode)):.0f} Hz (from "
        f"{float(soft['frequency'].sel(mode=mode)):.0f} to "
        f"{float(stiff['frequency'].sel(mode=mode)):.0f} Hz)"
        for mode in ("lower about x", "lower about y", "yaw")
    ]
    slope = float(np.gradient(np.log(modes["frequency"].sel(mode="lower about x")), np.log(factors))[study.points // 2])
    best = _quietest(response)
    return Outcome(
        title="Lateral stiffness of the mounts",
        question="What does the lateral stiffness of the mounts do to sway, rocking and yaw?",
        answers=(
            "Sway and yaw follow the lateral stiffness k as √k: ten times slower needs 100 times less. "
            f"{'; '.join(told)} for {study.factors[0]:g} to {study.factors[1]:g} times today's.",
            f"Here the lower mode about x rises as k to the power {slope:.2f}; below 0.5 it also "
            "rocks on the vertical stiffness.",
            f"Since the valves do not reach the horizontal, soft is what isolates it: at 20 Hz, {best[0]:.2g} "
            "times today's "
            f"stiffness lets {20 * np.log10(best[1]):.0f} dB of a swaying floor through, today's "
            f"{20 * np.log10(best[2]):.0f} "
            "dB.",
        ),
        tables={"modes": modes, "sway": response.to_dataset().assign_attrs(title="a floor that sways along x")},
        drawings={
            "modes": Drawing(
                "Natural frequencies and damping ratios of the machine's six modes over the mean lateral stiffness.",
                lambda: _modes_chart(modes, mean),
            ),
            "sway": Drawing(
                "How much of a floor that sways along x reaches the centre of gravity.",
                lambda: _sway_chart(response, mean),
            ),
        },
        notes=("Lateral damping is kept, so softer mounts are better damped. Valves held, small motions.",),
        numbers={"exponent_lower_about_x": slope},
    )


def _quietest(response: xr.DataArray) -> tuple[float, float, float]:
    """Factor with the least gain at 20 Hz, that gain, and the gain of the machine as it is."""
    gain = response.sel(frequency=20.0, method="nearest")
    return (
        float(gain["factor"][int(np.argmin(gain.values))]),
        float(gain.min()),
        float(gain.sel(factor=1.0, method="nearest")),
    )


def _modes_chart(modes: xr.Dataset, mean: float) -> "Figure":
    k = modes["stiffness"].values
    panels = {}
    for quantity, name, factor in (("frequency [Hz]", "frequency", 1.0), ("damping ratio [%]", "damping_ratio", 100.0)):
        panels[quantity] = [
            Line(mode, k, factor * modes[name].sel(mode=mode).values, color=c, dash=c % 2)
            for c, mode in enumerate(RIGID_MODES)
        ]
    return lines_chart(
        "Modes over lateral stiffness", "lateral stiffness of a mount [N/m]", panels, "xy", {"as it is": mean}
    )


def _sway_chart(response: xr.DataArray, mean: float) -> "Figure":
    decibel = 20 * np.log10(response.transpose("factor", "frequency").values)
    return map_chart(
        "A floor that sways along x",
        ("frequency [Hz]", response["frequency"].values),
        ("lateral stiffness of a mount [N/m]", response["stiffness"].values),
        ("CG over floor [dB]", np.clip(decibel, -59.9, 29.9)),
        points=[Line("as it is", response["frequency"].values[[0, -1]], [mean, mean], color=1, dash=1)],
        levels=(-60.0, -40.0, -30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0),
        logarithmic="xy",
    )
