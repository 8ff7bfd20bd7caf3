"""Where the step is chosen: as stated, or the longest that follows the fastest mode and divides every period.

Delays do not count: commands may switch within a step.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, NamedTuple, Self

import mujoco
import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.control import AnyController, Controller, PythonController
from ehamj.control.clock import common_divisor
from ehamj.errors import InputError
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import Inputs, equilibrium, jacobian, rates
from ehamj.mujoco.model import build_model, reduced
from ehamj.plant.plant import Plant
from ehamj.run.faults import plants
from ehamj.scenario.model import Scenario

ANY_STEP: Final = 1e-4
"""Step of models that take none [s]: those of tied plates are the same at any."""

SHORTEST_STEP = 2e-6
"""Step below which the automatic choice gives up [s]: periods that have no common divisor were hardly meant."""

STEP_PER_TIME_CONSTANT = 1.2
"""Largest |λ|·step of the automatic step. RK4 is stable to 2.8; at 1.2 the fastest mode itself is followed to a few per
cent and motions below 100 Hz to 1e-4."""


class Keys(NamedTuple):
    """What the rates of a law are called where it is stated."""

    rate: str
    spool_rate: str
    spool: str


OF_SCENARIO: Final = Keys("control.rate", "control.spool_feedback.rate", "control.spool_feedback")
OF_FILE: Final = Keys("1/period_s of the law's file", "1/period_s of its spools", "the law's spools")
GIVEN: Final = Keys("1/period of the controller", "1/period of its spools", "the controller's spools")


class Standing(NamedTuple):
    """The model of a plant in its equilibrium at rest, whatever its step is."""

    plant: Plant
    model: mujoco.MjModel
    data: mujoco.MjData
    state: Array

    @classmethod
    def of(cls, plant: Plant) -> Self:
        """A plant that is put there; call it with the hydraulics installed."""
        model = build_model(plant, ANY_STEP)
        data = mujoco.MjData(model)
        return cls(plant, model, data, equilibrium(model, data, Inputs.rest(model)))

    @property
    def modes(self) -> NDArray[np.complex128]:
        """Eigenvalues there [rad/s]."""
        rest = Inputs.rest(self.model)
        matrix = jacobian(self.model, self.data, self.state, rest)
        rates(self.model, self.data, self.state, rest)  # it stands there again
        return np.linalg.eigvals(matrix).astype(complex)


def standing(scenario: Scenario) -> Standing | None:
    """The machine that runs, where it is that of whose modes the step is chosen too: it is built once, then."""
    plant = scenario.plant
    same = scenario.timestep == "auto" and stiffest(plant) == plant and plant.plates == "tied"
    return Standing.of(plant) if same else None


def choose_timestep(
    scenario: Scenario,
    controller: AnyController | None = None,
    keys: Keys = OF_SCENARIO,
    stands: Standing | None = None,
) -> float:
    """The integration step [s]: as stated, or the longest that resolves the fastest mode at equilibrium.

    It divides the recording period and the controller's sampling periods, and follows the shortest force on the
    machine. Call it with the hydraulics installed; ``keys`` are those that its messages name, and ``stands`` a machine
    that needs no model again.

    Raises:
        InputError: if a stated step does not divide them, or no reasonable step does.
    """
    periods = _periods(scenario, controller, keys)
    if scenario.timestep != "auto":
        return _stated(scenario.timestep, periods, keys)
    # Faults may make it faster: the step is one for the whole run.
    fastest = max(float(np.abs(_modes(plant, stands)).max()) for plant in plants(scenario))
    fastest = max(fastest, STEP_PER_TIME_CONSTANT / scenario.load().longest_step)
    period = float(common_divisor(periods.values()))
    if period < SHORTEST_STEP:
        times = ", ".join(f"{name} = {value:.9g} s" for name, value in periods.items())
        raise InputError(
            f"timestep = 'auto': no step of {SHORTEST_STEP:g} s or more divides {times}; choose "
            f"{_rates(periods, keys)} that are multiples of each other"
        )
    return period / max(1, math.ceil(period * fastest / STEP_PER_TIME_CONSTANT - 1e-9))


def _periods(scenario: Scenario, controller: AnyController | None, keys: Keys) -> dict[str, float]:
    """Times that the step must divide [s], by what they are called in messages; the recording period first."""
    periods = {"the recording period 1/record_rate": 1.0 / scenario.record_rate}
    parts: Sequence[Controller | PythonController] = controller.parts if controller is not None else ()
    for number, part in enumerate(parts, start=1):
        whose = "the controller's" if len(parts) == 1 else f"the controller's part {number}'s"
        periods[f"{whose} period"] = part.period
    for spool in () if controller is None else controller.converter.spools[:1]:
        periods[f"the period of {keys.spool}"] = spool.period
    return periods


def _rates(periods: dict[str, float], keys: Keys) -> str:
    """Keys of the rates that periods are of."""
    of_spools = f"the period of {keys.spool}" in periods
    found = ["record_rate", *([keys.rate] if len(periods) > 1 + of_spools else [])]
    found += [keys.spool_rate] if of_spools else []
    return " and ".join([*([", ".join(found[:-1])] if found[1:] else []), found[-1]])


def _stated(timestep: float, periods: dict[str, float], keys: Keys) -> float:
    """A stated step, rounded to an exact share of the recording period."""
    for name, period in periods.items():
        ratio = period / timestep
        if abs(ratio - round(ratio)) > 1e-6 * ratio or round(ratio) < 1:
            common = float(common_divisor(periods.values()))
            found = f"nearest: {common / max(1, round(common / timestep)):.9g}"
            if common < SHORTEST_STEP:
                rates = _rates(periods, keys)
                found = f"none of {SHORTEST_STEP:g} s or more divides all; choose {rates} that are multiples"
            raise InputError(f"timestep = {timestep:g} s must divide {name} = {period:g} s; {found}")
    first = next(iter(periods.values()))
    return first / round(first / timestep)


def follows(plant: Plant, timestep: float) -> bool:
    """Whether RK4 at this step lets every mode decay that decays: |1 + z + z²/2 + z³/6 + z⁴/24| ≤ 1 at z = λ·step."""
    modes = _modes(plant)
    z = modes[modes.real < 0] * timestep
    return bool(np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4)))).max() <= 1.0)


def stiffest(plant: Plant) -> Plant:
    """The plant whose modes are as fast as they can be: oil without its air, slides where they start, tied plates."""
    stiff = tuple(one.with_values({"air_fraction": 0.0}) if one.air_fraction else one for one in plant.actuators)
    return reduced(replace(plant.locked(), actuators=stiff))


def _modes(plant: Plant, stands: Standing | None = None) -> NDArray[np.complex128]:
    """Eigenvalues at the equilibrium at rest [rad/s]; of oil without its air, which is stiffest."""
    stiff = stiffest(plant)
    if stands is not None and stands.plant == stiff:
        return stands.modes
    with hydraulics():
        return Standing.of(stiff).modes
