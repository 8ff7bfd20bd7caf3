"""Lateral stiffness of the mounts: where sway ends and rocking begins, and what a floor that sways does."""

import numpy as np
import xarray as xr
from pydantic import Field, field_validator

from ehamj.arrays import Array
from ehamj.designs.designs import Designs
from ehamj.designs.floor import floor_response
from ehamj.designs.many import modes_of
from ehamj.labels import labelled
from ehamj.pages.words import decibel
from ehamj.plots import Figure, Line, lines_chart, map_chart
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress, curves
from ehamj.studies.study import Range, study
from ehamj.studies.variants import every_value


class LateralSettings(Settings):
    """Factors on the lateral stiffness of every mount; its lateral damping is kept."""

    factors: Range = Field((0.02, 50.0), description="lowest and highest factor on the lateral stiffness")
    points: int = Field(121, ge=3, description="factors between them")

    @field_validator("factors")
    @classmethod
    def _as_it_is(cls, factors: tuple[float, float]) -> tuple[float, float]:
        if not factors[0] <= 1.0 <= factors[1]:
            raise ValueError("must enclose 1, the machine as it is")
        return factors


def stiffness_over_factors(scenario: Scenario, factors: Array) -> Designs:
    """The machine with its mounts' lateral stiffness multiplied, over the dimension ``factor``."""
    return Designs.of(scenario, every_value(scenario, "lateral_stiffness", xr.DataArray(factors, dims="factor")))


@study(
    "lateral",
    LateralSettings,
    "what the lateral stiffness of the mounts does to sway, rocking and yaw",
    small={"points": 5},
)
def lateral_stiffness(scenario: Scenario, settings: LateralSettings, progress: Progress) -> Outcome:
    """A machine that has no linear model in closed form is refused."""
    progress("modes and floor response")
    factors = np.geomspace(*settings.factors, settings.points)
    many = stiffness_over_factors(scenario, factors)
    mean = float(np.mean([actuator.lateral_stiffness for actuator in scenario.plant.actuators]))
    coordinates = {
        "factor": labelled(("factor",), factors, "1", "factor on the lateral stiffness"),
        "stiffness": labelled(("factor",), mean * factors, "N/m", "mean lateral stiffness of a mount"),
    }
    modes = modes_of(many)[["frequency", "damping_ratio"]].reset_coords(drop=True).assign_coords(coordinates)
    modes.attrs["title"] = "modes over the lateral stiffness"
    transfer = floor_response(many, np.geomspace(2.0, 500.0, 121), "x").sel(output="cg x")
    sway = xr.apply_ufunc(np.abs, transfer).reset_coords(drop=True).assign_coords(coordinates).rename("gain")
    sway.attrs = {"units": "1", "long_name": "CG over floor, along x"}
    sway["frequency"].attrs = {"units": "Hz", "long_name": "frequency"}
    lower = np.log(modes["frequency"].sel(mode="lower about x"))
    slope = float(np.gradient(lower, np.log(factors))[settings.points // 2])
    return Outcome(
        title="Lateral stiffness of the mounts",
        question="What does the lateral stiffness of the mounts do to sway, rocking and yaw?",
        answers=_answers(modes, slope, _quietest(sway), "surge" in scenario.plant.layout.motions),
        tables={"modes": modes, "sway": sway.to_dataset().assign_attrs(title="a floor that sways along x")},
        drawings={
            "modes": Drawing(
                "Natural frequencies and damping ratios of the machine's six modes over the mean lateral stiffness.",
                lambda: _modes_chart(modes, mean),
            ),
            "sway": Drawing(
                "How much of a floor that sways along x reaches the centre of gravity.",
                lambda: _sway_chart(sway, mean),
            ),
        },
        notes=("Lateral damping is kept, so softer mounts are better damped. Valves held, small motions.",),
        numbers={"exponent_lower_about_x": slope},
    )


def _answers(modes: xr.Dataset, slope: float, quietest: tuple[float, float, float], driven: bool) -> tuple[str, ...]:
    here = modes.sel(factor=1.0, method="nearest")["frequency"]
    soft, stiff = (modes.isel(factor=end)["frequency"] for end in (0, -1))
    told = [
        f"{mode} {float(here.sel(mode=mode)):.0f} Hz (from {float(soft.sel(mode=mode)):.0f} to "
        f"{float(stiff.sel(mode=mode)):.0f} Hz)"
        for mode in ("lower about x", "lower about y", "yaw")
    ]
    factor, least, own = quietest
    why = "With valves held" if driven else "Since the valves do not reach the horizontal"
    why += ", soft is what isolates it" if factor < 1.0 else ", no stiffness shown isolates it"
    return (
        "Sway and yaw follow the lateral stiffness k as √k: ten times slower needs 100 times less. "
        f"{'; '.join(told)} for {modes['factor'].values[0]:g} to {modes['factor'].values[-1]:g} times today's.",
        f"Here the lower mode about x rises as k to the power {slope:.2f}; below 0.5 it also "
        "rocks on the vertical stiffness.",
        f"{why}: at 20 Hz, {factor:.2g} times today's "
        f"stiffness lets {decibel(20 * np.log10(least))} dB of a swaying floor through, today's "
        f"{decibel(20 * np.log10(own))} dB.",
    )


def _quietest(response: xr.DataArray) -> tuple[float, float, float]:
    """Factor with the least gain at 20 Hz, that gain, and the gain of the machine as it is."""
    gain = response.sel(frequency=20.0, method="nearest")
    return (
        float(gain["factor"][int(np.argmin(gain.values))]),
        float(gain.min()),
        float(gain.sel(factor=1.0, method="nearest")),
    )


def _modes_chart(modes: xr.Dataset, mean: float) -> Figure:
    over = modes.swap_dims(factor="stiffness")
    panels = {
        "frequency [Hz]": curves(over["frequency"], "mode", 2),
        "damping ratio [%]": curves(100 * over["damping_ratio"], "mode", 2),
    }
    return lines_chart(
        "Modes over lateral stiffness", "lateral stiffness of a mount [N/m]", panels, "xy", {"as it is": mean}
    )


def _sway_chart(response: xr.DataArray, mean: float) -> Figure:
    through = 20 * np.log10(response.transpose("factor", "frequency").values)
    return map_chart(
        "A floor that sways along x",
        ("frequency [Hz]", response["frequency"].values),
        ("lateral stiffness of a mount [N/m]", response["stiffness"].values),
        ("CG over floor [dB]", np.clip(through, -59.9, 29.9)),
        points=[Line("as it is", response["frequency"].values[[0, -1]], [mean, mean], color=1, dash=1)],
        levels=(-60.0, -40.0, -30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0),
        logarithmic="xy",
    )
