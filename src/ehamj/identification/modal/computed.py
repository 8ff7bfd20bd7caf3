"""The machine's own modes with its valves held, of one scenario or of many points at once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from ehamj.arrays import Array, ComplexArray
from ehamj.designs.designs import Designs
from ehamj.designs.many import modes_of
from ehamj.designs.parameters import changes_of, value_of
from ehamj.errors import InputError
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario


@dataclass(frozen=True)
class Computed:
    """Oscillations of a machine: ``names`` (m,), ``poles`` λ (m,) [1/s] with Im λ > 0, ``shapes`` of the mount plane's
    centre (m, 6) [m, rad], and where its feet stand, ``positions`` (mount, 3) [m]."""

    names: tuple[str, ...]
    poles: ComplexArray
    shapes: ComplexArray
    positions: Array

    @property
    def frequency(self) -> Array:
        """|λ|/2π (m,) [Hz]."""
        return np.abs(self.poles) / (2.0 * np.pi)

    @property
    def damping_ratio(self) -> Array:
        """−Re λ/|λ| (m,) [-]."""
        return np.asarray(-self.poles.real / np.abs(self.poles))


def computed_modes(scenario: Scenario) -> Computed:
    """Modes in which the machine itself swings, by frequency and with the names that a person uses, of the simulated
    model.

    Raises:
        InputError: if the machine has no equilibrium, or no such mode.
    """
    found = [mode for mode in modes(linear_model(scenario.plant)) if mode.machine_moves]
    if not found:
        raise InputError("the machine has no oscillation with its valves held: there is nothing to compare")
    names, poles = tuple(mode.name for mode in found), np.array([mode.eigenvalue for mode in found])
    return Computed(names, poles, np.array([mode.shape for mode in found]), np.array(scenario.plant.positions))


def in_closed_form(scenario: Scenario, keys: Sequence[str]) -> bool:
    """Whether a machine's modes are known in closed form (`ehamj.designs.many`), whatever values these keys have."""
    try:
        Designs.of(scenario, {key: value_of(scenario, key) for key in keys})
    except InputError:
        return False
    return True


def computed_many(
    scenario: Scenario, batch: Sequence[Mapping[str, float]], closed: bool
) -> list[Computed | InputError]:
    """The same at many points, each values of the same keys; where a point is impossible, why.

    Args:
        scenario: the machine.
        batch: values by the scenario's keys.
        closed: whether its modes have a closed form (`in_closed_form`), which takes all points at once; else each is
            linearised by itself.
    """
    return _closed(scenario, batch) if closed else [_one(scenario, values) for values in batch]


def _one(scenario: Scenario, values: Mapping[str, float]) -> Computed | InputError:
    try:
        return computed_modes(changed(scenario, changes_of(scenario, values)))
    except InputError as error:
        return error


def _closed(scenario: Scenario, batch: Sequence[Mapping[str, float]]) -> list[Computed | InputError]:
    """In closed form; rigid modes alone, which are all that upright feet without mass have."""
    varied = {key: xr.DataArray([values[key] for values in batch], dims="point") for key in batch[0]}
    try:
        designs = Designs.of(scenario, varied or {"gravity": xr.DataArray([scenario.gravity], dims="point")})
    except InputError as error:
        if len(batch) == 1:
            return [error]
        return [one for values in batch for one in _closed(scenario, [values])]
    table = modes_of(designs)
    positions = np.stack(np.broadcast_arrays(*(designs.values.mounts[axis] for axis in "xyz")), axis=-1)
    hertz, ratio, shape = (
        table[name].transpose("point", ...).values for name in ("frequency", "damping_ratio", "shape")
    )
    found: list[Computed | InputError] = []
    for k, stands in enumerate(np.atleast_1d(table["stands"].values)):
        swings = np.isfinite(hertz[k])
        if not stands or not swings.any():
            found.append(InputError(_impossible(batch[k], bool(stands))))
            continue
        order = np.flatnonzero(swings)[np.argsort(hertz[k][swings], kind="stable")]
        f, z = 2.0 * np.pi * hertz[k][order], ratio[k][order]
        poles = f * (-z + 1j * np.sqrt(1.0 - z**2))
        names = tuple(str(name) for name in table["mode"].values[order])
        found.append(Computed(names, poles, shape[k][order], positions[k]))
    return found


def _impossible(values: Mapping[str, float], stands: bool) -> str:
    told = ", ".join(f"{key} = {value:g}" for key, value in values.items())
    return f"with {told} the machine {'has no oscillation' if stands else 'does not stand'}"
