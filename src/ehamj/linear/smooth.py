"""Whether a machine has a derivative where it is linearised, and which option of a valve takes it away."""

from collections.abc import Iterator
from typing import Any, Final

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.isolator.actuator import OPTIONS, Actuator
from ehamj.isolator.component import Option
from ehamj.isolator.equations import State
from ehamj.memory import isolators, states_of
from ehamj.mujoco.equilibrium import Inputs, jacobian, scales
from ehamj.plant.plant import Plant

FINER: Final = 8.0
"""Ratio of the two steps whose slopes are compared: behind a jump they differ by that factor."""
AGREED: Final = 0.05
"""Difference of two slopes, over the larger one, up to which they are one."""
ROUNDING: Final = 1e-6
"""Share of all that moves a rate, below which a difference of slopes is rounding."""
UNITS: Final = dict(zip(State._fields, ("mA", "mA/s", "Pa", "Pa"), strict=True))


class NotSmooth(InputError):
    """A valve has no derivative where it rests."""


def used_options(actuator: Actuator) -> tuple[type[Option], ...]:
    """The options of a valve that are not at their defaults, with which they change nothing."""
    usual = type(actuator)()
    return tuple(option for option in OPTIONS if option.values_of(actuator) != option.values_of(usual))


def check_smooth(
    model: mujoco.MjModel, data: mujoco.MjData, state: Array, held: Inputs, plant: Plant, matrix: Array
) -> None:
    """Hold the slopes of valves with options against those of a finer step.

    An option that jumps (or bends, aside of its rest but within the step) has no slope of its own there: what a
    difference gives is the jump over its step. One that bends where it rests has the mean of both sides.

    Args:
        model, data: with the hydraulics installed.
        state, held: the operating point.
        plant: of the model.
        matrix: ∂rates/∂state there by `jacobian`.

    Raises:
        NotSmooth: where slopes disagree; it names the option.
    """
    names = states_of(model)
    for mount, actuator in zip(plant.mounts, plant.actuators, strict=True):
        used = used_options(actuator)
        if not used:
            continue
        for name in (f"{field} {mount}" for field in State._fields):
            column = model.nq + model.nv + names.index(name)
            if _agrees(model, data, state, held, matrix, column):
                continue
            row = plant.mounts.index(mount)
            guilty = [option for option in used if _agrees_without(model, data, state, held, option, (row, column))]
            raise NotSmooth(_said(mount, name.split()[0], scales(model)[column], actuator, guilty or used))


def _agrees(model: mujoco.MjModel, data: mujoco.MjData, state: Array, held: Inputs, matrix: Array, column: int) -> bool:
    """Whether the slopes over one state are those of a finer step."""
    finer = jacobian(model, data, state, held, [column], FINER)[:, 0]
    slopes, step = matrix[:, column], scales(model)
    larger = np.maximum(abs(slopes), abs(finer))
    noise = ROUNDING * abs(matrix) @ step / step[column]
    return bool(np.all(abs(slopes - finer) <= np.maximum(AGREED * larger, noise)))


def _agrees_without(
    model: mujoco.MjModel, data: mujoco.MjData, state: Array, held: Inputs, option: type[Option], at: tuple[int, int]
) -> bool:
    """The same with an option at its default."""
    row, column = at
    own = isolators(model)[row]
    kept = own.copy()
    for field, value in option.values_of(Actuator())._asdict().items():
        own[field] = value
    matrix = jacobian(model, data, state, held)
    agreed = _agrees(model, data, state, held, matrix, column)
    isolators(model)[row] = kept
    return agreed


def _settings(option: type[Option], actuator: Actuator) -> Iterator[tuple[str, Any, Any]]:
    """Settings of an option that are not at their defaults: name, value, default."""
    for name in option.own_settings():
        value, usual = getattr(actuator, name), getattr(Actuator(), name)
        if value != usual:
            yield name, value, usual


def _said(mount: str, state: str, step: float, actuator: Actuator, guilty: Any) -> str:
    found = [one for option in guilty for one in _settings(option, actuator)]
    stated = ", ".join(f"{name} = {value}" for name, value, _ in found)
    without = ", ".join(f"{name} = {usual}" for name, _, usual in found)
    names = " or ".join(option.__name__ for option in guilty)
    return (
        f"no linear model: {stated} ({names}) of mount {mount} jumps or bends within {step:g} {UNITS[state]} of where "
        f"the valve rests (its {state.replace('_', ' ')}), so that it has no slope there. Linear results need it "
        f"smooth, or left out ({without}); runs take it as it is"
    )
