"""The machine of a scenario as a linear system that other tools take."""

from collections.abc import Mapping, Sequence
from typing import Any

from numpy.typing import ArrayLike

from ehamj.control.channels import channel_names
from ehamj.linear.machine import LinearModel, Point, linear_model
from ehamj.linear.plants import LinearPlant
from ehamj.linear.scales import sizes, state_units
from ehamj.plant.axes import AXES
from ehamj.scenario.load import Given, as_scenario


def linearise(
    scenario: Given,
    outputs: Sequence[str] | None = None,
    points: Mapping[str, Point] | None = None,
    commands: ArrayLike | None = None,
    load: ArrayLike = (0.0,) * 6,
) -> Any:
    """The machine of a scenario as a ``control.StateSpace`` with named states, inputs and outputs.

    Its states are scaled (`ehamj.linear.plants.LinearPlant`, which keeps scales, units and operating point), inputs and
    outputs are not; responses of single channels hold to all digits. Rigid plates are tied to the machine, so that no
    pole of a constraint is among the fast ones; at a neutral pole (a valve within its threshold stays where it is) a
    channel that does not show it has its finite value. With flexible feet there are so many states that
    ``control.margin`` of the system may overflow: give it ``control.frequency_response``.

    Inputs are the valves' commands [V], displacement [m] and velocity [m/s] of the ground at each mount and axis, and
    forces at the centre of gravity (`inputs_of`). Outputs are channels as in the result (`ehamj.control.channels`), all
    of them by default.

    Args:
        scenario: what is linearised about its static equilibrium; a shipped name or a file serves too.
        outputs: channel names.
        points: further points of the machine by name [m from the mount plane's centre], which give the outputs
            ``NAME_displacement x`` and so on.
        commands: held commands [V].
        load: held force and moment at the centre of gravity [N, N m].

    Raises:
        InputError: if a channel is unknown, or the operating point does not exist.
    """
    scenario = as_scenario(scenario)
    return named_plant(linear_model(scenario.plant, commands, load), scenario.name, outputs, points)


def named_plant(
    model: LinearModel, name: str, outputs: Sequence[str] | None = None, points: Mapping[str, Point] | None = None
) -> Any:
    """A linearised machine as `linearise` hands it out; arguments and errors as there."""
    if outputs is None:
        outputs = [one for one in channel_names(model.plant.mounts) if not one.startswith("ground_")]
        outputs += [
            f"{point}_{what} {axis}"
            for point in points or {}
            for what in ("displacement", "velocity", "acceleration")
            for axis in AXES
        ]
    C, D = model.rows(outputs, points)
    return LinearPlant.scaled(
        (model.A, model.B, C, D), sizes(model.states), model.equilibrium, state_units(model.states),
        states=list(model.states), inputs=list(model.inputs), outputs=list(outputs), name=name.replace(".", "-"),
    )  # fmt: skip
