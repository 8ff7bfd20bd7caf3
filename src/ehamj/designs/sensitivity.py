"""What each parameter does to each mode: d ln f/d ln p and dζ/d ln p, from the eigenvectors."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import xarray as xr

from ehamj.arrays import ComplexArray
from ehamj.control import LinearController
from ehamj.designs.parameters import parameters_of, quantity_of, value_of, with_value
from ehamj.errors import InputError
from ehamj.labels import labelled
from ehamj.linear.eigen import eigenvalue_changes
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.modes import eigen_of, modes, oscillations, state_matrix
from ehamj.linear.sampled import pattern_period
from ehamj.scenario.model import Scenario

STEP: Final = 1e-3
"""Relative step of a parameter [-]: the change of the matrices is then good to 1e-6."""


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
    model, loop = linear_under(scenario.plant, law), Loop.of(scenario, law)
    eigen, _ = eigen_of(model, loop, bypassed)
    found, chosen = modes(model, loop, bypassed), oscillations(eigen)
    values = [value_of(scenario, key) for key in keys]
    changes = np.zeros((len(keys), len(chosen)), complex)
    for k, (key, value) in enumerate(zip(keys, values, strict=True)):
        if value == 0.0 or not np.isfinite(value):
            raise InputError(f"sensitivity to {key} = {value:g}: must be neither zero nor infinite")
        varied = (with_value(scenario, key, value * (1.0 + sign * STEP)).plant for sign in (1.0, -1.0))
        ahead, behind = (state_matrix(linear_under(plant, law), loop, bypassed).A for plant in varied)
        changes[k] = eigenvalue_changes(eigen, chosen, (ahead - behind) / (2.0 * STEP))
    poles = np.array([mode.eigenvalue for mode in found])
    if law is not None:  # from z = exp(λT)
        period = pattern_period(law)
        changes = changes / (period * np.exp(poles * period))
    labels = {
        "parameter": list(keys),
        "mode": [mode.name for mode in found],
        "value": ("parameter", values, {"long_name": "value of the parameter"}),
        "unit": ("parameter", [quantity_of(scenario, key)[0] for key in keys]),
    }
    return _slopes(poles, changes).assign_coords(labels)


def _slopes(poles: ComplexArray, changes: ComplexArray) -> xr.Dataset:
    """Of frequency and damping ratio, from those of λ (parameter, mode)."""
    size = np.abs(poles)
    frequency = (poles.conj() * changes).real / size**2
    damping = -changes.real / size + poles.real / size * frequency
    columns = {
        "frequency": (frequency, "1", "d ln f / d ln p"),
        "damping": (damping, "1", "dζ / d ln p"),
        "eigenvalue": (changes, "1/s", "dλ / d ln p"),
    }
    return xr.Dataset({name: labelled(("parameter", "mode"), *column) for name, column in columns.items()})
