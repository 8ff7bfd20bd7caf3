"""What each parameter does to each mode: d ln f/d ln p and dζ/d ln p, from the eigenvectors."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.control import LinearController
from ehamj.designs.designs import FOOTPRINT, quantity_of
from ehamj.errors import InputError
from ehamj.linear.eigen import eigenvalue_changes
from ehamj.linear.elements import ACTUATOR_VALUES, MACHINE_VALUES
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import eigen_of, modes, oscillations, state_matrix
from ehamj.linear.sampled import pattern_period
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

Array = NDArray[np.float64]

STEP: Final = 1e-3
"""Relative step of a parameter [-]: the change of the matrices is then good to 1e-6."""


def parameters_of(scenario: Scenario) -> tuple[str, ...]:
    """Keys (`ehamj.designs.designs.quantity_of`) of all parameters that the linear machine depends on and that are
    neither zero nor infinite, so that they have a logarithm."""
    keys = [*(f"machine.{name}" for name in MACHINE_VALUES), *FOOTPRINT, "gravity", "supply.pressure"]
    keys += [f"actuators.{name}.{value}" for name in scenario.actuators for value in ACTUATOR_VALUES]
    return tuple(key for key in keys if np.isfinite(value := value_of(scenario, key)) and value != 0.0)


def value_of(scenario: Scenario, key: str) -> float:
    """Value of a parameter in SI (spools in mA).

    Raises:
        InputError: if there is no such parameter.
    """
    quantity_of(scenario, key)
    if key in FOOTPRINT:
        return _span(scenario, key)
    place: Any = scenario
    for part in key.split("."):
        if isinstance(place, tuple):
            place = place[int(part)]
        else:
            place = place[part] if isinstance(place, dict) else getattr(place, part)
    return float(place)


def with_value(scenario: Scenario, key: str, value: float) -> Scenario:
    """The scenario with another value of one parameter.

    Raises:
        InputError: if there is no such parameter, or the value is impossible.
    """
    quantity_of(scenario, key)
    table = scenario.model_dump()
    if key in FOOTPRINT:
        axis, factor = "xy".index(FOOTPRINT[key]), value / _span(scenario, key)
        for mount in table["mount"]:
            mount["position"] = tuple(p * (factor if k == axis else 1.0) for k, p in enumerate(mount["position"]))
        return parse_scenario(table)
    *parents, last = key.split(".")
    place: Any = table
    for at, part in enumerate(parents):
        inner = place[int(part)] if isinstance(place, tuple) else place[part]
        if isinstance(inner, tuple) and at == len(parents) - 1:  # a vector's entry: replace the vector
            place[part] = tuple(value if k == int(last) else entry for k, entry in enumerate(inner))
            return parse_scenario(table)
        place = inner
    place[last] = value
    return parse_scenario(table)


def _span(scenario: Scenario, key: str) -> float:
    """Mean distance of the mounts, front to rear or left to right [m]."""
    axis, ahead = ("xy".index(FOOTPRINT[key]), "front" if key == "footprint.x" else "left")
    places = {True: [], False: []}  # type: dict[bool, list[float]]
    for mount in scenario.mount:
        places[ahead in mount.name].append(mount.position[axis])
    return float(np.mean(places[True]) - np.mean(places[False]))


def sensitivities(
    scenario: Scenario,
    law: LinearController | None = None,
    bypassed: bool = False,
    parameters: Sequence[str] | None = None,
) -> xr.Dataset:
    """Change of every mode with every parameter, to first order: dλ = wᴴ dA v (`ehamj.linear.eigen`).

    dA is a central difference of the linear model over ±0.1 %, the operating point with it. A controller stays as it
    is, also where a scenario would have built another one for the changed machine.

    Args:
        scenario: the machine.
        law: closes the loop (`ehamj.linear.modes.modes`), with the scenario's sensors.
        bypassed: chambers bypassed, as there.
        parameters: keys; all of `parameters_of` without.

    Returns:
        Over (parameter, mode): ``frequency``, d ln f/d ln p [-], per cent of frequency per per cent of the parameter;
        ``damping``, dζ/d ln p [-]; ``eigenvalue``, dλ/d ln p [1/s]. Coordinates ``value`` and ``unit`` of each
        parameter. NaN where an eigenvalue is defective.

    Raises:
        InputError: if a parameter is unknown, or zero.
    """
    keys = parameters_of(scenario) if parameters is None else tuple(parameters)
    model, loop = linear_model(scenario.plant), Loop.of(scenario, law)
    eigen, _ = eigen_of(model, loop, bypassed)
    found, chosen = modes(model, loop, bypassed), oscillations(eigen)
    values = [value_of(scenario, key) for key in keys]
    changes = np.zeros((len(keys), len(chosen)), complex)
    for k, (key, value) in enumerate(zip(keys, values, strict=True)):
        if value == 0.0 or not np.isfinite(value):
            raise InputError(f"sensitivity to {key} = {value:g}: must be neither zero nor infinite")
        ahead, behind = (
            state_matrix(linear_model(with_value(scenario, key, value * (1.0 + sign * STEP)).plant), loop, bypassed).A
            for sign in (1.0, -1.0)
        )
        changes[k] = eigenvalue_changes(eigen, chosen, (ahead - behind) / (2.0 * STEP))
    poles = np.array([mode.eigenvalue for mode in found])
    if law is not None:  # from z = exp(λT)
        period = pattern_period(law)
        changes = changes / (period * np.exp(poles * period))
    size = np.abs(poles)
    frequency = (poles.conj() * changes).real / size**2
    damping = -changes.real / size + poles.real / size * frequency
    over = ("parameter", "mode")
    return xr.Dataset(
        {
            "frequency": (over, frequency, {"units": "1", "long_name": "d ln f / d ln p"}),
            "damping": (over, damping, {"units": "1", "long_name": "dζ / d ln p"}),
            "eigenvalue": (over, changes, {"units": "1/s", "long_name": "dλ / d ln p"}),
        },
        {
            "parameter": list(keys),
            "mode": [mode.name for mode in found],
            "value": ("parameter", values, {"long_name": "value of the parameter"}),
            "unit": ("parameter", [quantity_of(scenario, key)[0] for key in keys]),
        },
    )
