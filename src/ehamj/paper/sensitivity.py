"""What each parameter does to each figure of merit: multiplied one at a time, and as slopes d ln f/d ln p."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray as xr

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.paper.actuator import LINEAR, Array, positive, scaled
from ehamj.paper.merits import DesignStudy, FiguresOfMerit

PARAMETERS: Final = ("mass", *LINEAR)
"""Every parameter of the linear actuator."""

SYMBOLS: Final = {"mass": "M"} | {name: Actuator.quantities()[name][1] for name in LINEAR}

MERITS: Final[dict[str, tuple[str, str, Callable[[FiguresOfMerit], float | None]]]] = {
    "hydraulic_stiffness": ("N/m", "hydraulic stiffness K_h", lambda f: f.hydraulic_stiffness),
    "omega_h": ("rad/s", "hydro-mechanical frequency ω_h", lambda f: f.omega_h),
    "delta_h": ("-", "hydraulic damping ratio δ_h", lambda f: f.delta_h),
    "resonance": ("Hz", "load resonance, exact", lambda f: f.resonance_hz),
    "resonance_damping": ("-", "its damping ratio, exact", lambda f: f.resonance_damping),
    "break_frequency": ("rad/s", "break frequency K_C K_L/A_p²", lambda f: f.break_frequency),
    "velocity_gain": ("m/s/V", "velocity gain K_v K_Q/A_p", lambda f: f.velocity_gain),
    "merritt_limit": ("1/s", "Merritt's limit 2δ_hω_h", lambda f: f.merritt_limit),
    "gain_margin": ("V/m", "gain margin (ratio)", lambda f: 10.0 ** (f.gain_margin_db / 20.0)),
    "phase_crossover": ("Hz", "phase crossover", lambda f: f.phase_crossover_hz),
    "velocity_gain_limit": ("1/s", "velocity gain at the limit", lambda f: f.velocity_gain_limit),
    "gain_crossover": ("Hz", "gain crossover, closed loop", lambda f: f.gain_crossover_hz),
    "bandwidth": ("Hz", "bandwidth, closed loop", lambda f: f.bandwidth_hz),
}
"""Figures of merit with unit, name and where to find them; all of them positive, so that they have a logarithm."""

STEP: Final = 2e-3
"""Step of ln p for the slopes; two of them, extrapolated, leave 1e-10."""


@dataclass(frozen=True)
class SensitivityStudy(DesignStudy):
    """A design and what is asked of its loop.

    Raises:
        InputError: if a factor is not a positive number.
    """

    factors: tuple[float, ...] = (0.5, 1.0, 2.0)
    """By which each parameter is multiplied, one at a time."""

    def __post_init__(self) -> None:
        for factor in self.factors:
            positive("factors", factor)

    def values(self, parameter: str, factor: float) -> dict[str, float]:
        """Every one of `MERITS` with one parameter multiplied; NaN where a figure does not exist.

        Raises:
            InputError: if there is no such parameter, or the changed design has no such figures.
        """
        if parameter not in PARAMETERS:
            raise InputError(f"parameter = {parameter!r}: must be one of {', '.join(PARAMETERS)}")
        found = self.merits(*scaled(self.actuator, self.mass, parameter, factor))
        taken = {name: take(found) for name, (_, _, take) in MERITS.items()}
        return {name: math.nan if value is None else value for name, value in taken.items()}


def one_at_a_time(study: SensitivityStudy | None = None) -> xr.Dataset:
    """Figures of merit with each parameter multiplied by each factor, the others kept.

    Returns:
        One variable per figure (`MERITS`), each over (parameter, factor), with units.

    Raises:
        InputError: if the design has no such figures (see `ehamj.paper.merits.figures_of_merit`).
    """
    study = study or SensitivityStudy()
    table = [[study.values(parameter, factor) for factor in study.factors] for parameter in PARAMETERS]
    over = ("parameter", "factor")
    variables = {
        name: (over, [[cell[name] for cell in row] for row in table], {"units": unit, "long_name": text})
        for name, (unit, text, _) in MERITS.items()
    }
    return xr.Dataset(variables, _coordinates() | {"factor": list(study.factors)})


def elasticities(study: SensitivityStudy | None = None) -> xr.DataArray:
    """Normalised local derivatives d ln f/d ln p [-]: by how many per cent a figure moves with one per cent.

    Central differences of ln f, extrapolated (Richardson), good to 1e-8. The gain that keeps two margins has a kink
    where the deciding one changes, and the bandwidth jumps where a dip of the closed loop just reaches −3 dB; closer to
    either than `STEP` there is no slope to find.

    Returns:
        Over (figure, parameter).

    Raises:
        InputError: as `one_at_a_time`.
    """
    study = study or SensitivityStudy()
    study.values("mass", 1.0)  # refuse the design as it is, not as it is varied

    def slopes(parameter: str, step: float) -> Array:
        ahead, behind = (list(study.values(parameter, math.exp(way)).values()) for way in (step, -step))
        return (np.log(ahead) - np.log(behind)) / (2.0 * step)

    with np.errstate(divide="ignore", invalid="ignore"):
        columns = [(4.0 * slopes(name, 0.5 * STEP) - slopes(name, STEP)) / 3.0 for name in PARAMETERS]
    names = ("figure", [name for _, name, _ in MERITS.values()])
    coordinates = {"figure": list(MERITS), "name": names} | _coordinates()
    attributes = {"units": "1", "long_name": "d ln figure / d ln parameter"}
    return xr.DataArray(np.array(columns).T, coordinates, ("figure", "parameter"), "elasticity", attributes)


def _coordinates() -> dict[str, Any]:
    return {"parameter": list(PARAMETERS), "symbol": ("parameter", [SYMBOLS[name] for name in PARAMETERS])}
