"""Many designs of the machine at once: which values they have, as labelled arrays.

    heights = xr.DataArray(np.linspace(0.3, 2.0, 50), dims="height")
    spans = xr.DataArray(np.linspace(0.8, 2.4, 50), dims="span")
    many = Designs.of(scenario, {"machine.cg.2": heights, "footprint.x": spans, "footprint.y": spans})

What they do is in `ehamj.designs.many`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.supply import Supply
from ehamj.linear.elements import ACTUATOR_VALUES, MACHINE_VALUES, Values
from ehamj.plant.machine import Machine
from ehamj.plant.mounts import MOUNTS, N_MOUNTS
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings

Array = NDArray[np.float64]

FOOTPRINT: Final = {"footprint.x": "x", "footprint.y": "y"}
"""Keys of the mounts' distance [m], front to rear and left to right (their means); positions scale about the centre."""

_WITHOUT_EFFECT: Final = ("moving_volume", "flow_curve", "spool_drive_limit", "end_stops", "voltage_limit")
"""Settings of an actuator that nobody can vary here: two are taken as they are, the others are limits."""

_SUPPLY: Final = ("pressure", "tank_pressure")
_UNLIMITED: Final = ("wall_modulus", "foot_stiffness")
"""Values that may be infinite."""


@dataclass(frozen=True)
class Designs:
    """A grid of designs: labelled dimensions, and each physical value over them (`ehamj.linear.elements.Values`)."""

    dims: dict[str, int]
    coords: dict[str, Any]
    values: Values

    @classmethod
    def of(cls, scenario: Scenario, vary: Mapping[str, ArrayLike | xr.DataArray]) -> "Designs":
        """Designs that differ from a scenario's machine in some keys; ``{}`` gives that machine alone.

        Args:
            scenario: the machine that everything else is taken from.
            vary: values by key, as in ``ehamj run --set``: ``machine.mass``, ``machine.cg.2``, ``gravity``,
                ``actuators.NAME.lateral_stiffness``, ``mount.0.position.0``, ``supply.pressure``; and ``footprint.x``,
                ``footprint.y`` (`FOOTPRINT`). A plain 1-D array gets a dimension of its own, named by the key; give a
                ``xarray.DataArray`` with dimensions to let keys vary together (the same name) or to name them. Values
                count as they are: a CG may lie outside the drawn outline.

        Raises:
            InputError: if a key or a value is impossible, or the scenario's valves have no linear model in closed form.
        """
        _check_plain(scenario)
        given = {key: _labelled(key, value) for key, value in vary.items()}
        for key, value in given.items():
            _check(scenario, key, np.asarray(value.values, float))
        joint = dict(zip(given, xr.broadcast(*given.values()), strict=True)) if given else {}
        dims: dict[str, int] = {}
        for value in given.values():
            dims |= {str(name): size for name, size in value.sizes.items() if str(name) not in dims}
        shape = tuple(dims.values())
        base = Values.of(scenario.plant)
        common = {name: np.broadcast_to(value, shape).copy() for name, value in base.common.items()}
        mounts = {name: np.broadcast_to(value, (*shape, N_MOUNTS)).copy() for name, value in base.mounts.items()}
        for key in sorted(joint, key=lambda key: key in FOOTPRINT):  # a footprint scales positions that are set
            _put(scenario, common, mounts, key, joint[key].transpose(*dims).values.astype(float))
        return cls(dims, _coordinates(scenario, given), Values(common, mounts))

    @property
    def shape(self) -> tuple[int, ...]:
        """Sizes of the dimensions."""
        return tuple(self.dims.values())


def quantity_of(scenario: Scenario, key: str) -> tuple[str, str]:
    """Unit and description of a key that `Designs.of` can vary.

    Raises:
        InputError: if there is none.
    """
    first, _, rest = key.partition(".")
    if key == "gravity":
        return "m/s²", "gravitational acceleration"
    if key in FOOTPRINT:
        return "m", f"distance of the mounts in {FOOTPRINT[key]}"
    if first == "machine" and rest in MACHINE_VALUES:
        vector, _, entry = rest.partition(".")
        return Machine.quantities()[vector][0], vector + (f" {'xyz'[int(entry)]}" if entry else "")
    if first == "supply" and rest in _SUPPLY:
        return Supply.quantities()[rest][0], rest.replace("_", " ")
    name, _, value = rest.partition(".")
    if first == "actuators" and name in scenario.actuators and value in ACTUATOR_VALUES:
        return Actuator.quantities()[value][0], f"{value.replace('_', ' ')} of {name}"
    if first == "mount" and name in map(str, range(N_MOUNTS)) and value in ("position.0", "position.1"):
        return "m", f"{'x' if value[-1] == '0' else 'y'} of the mount {scenario.mount[int(name)].name}"
    raise InputError(
        f"vary: {key!r} must be gravity, {', '.join(FOOTPRINT)}, machine.({', '.join(MACHINE_VALUES)}), "
        f"supply.({', '.join(_SUPPLY)}), mount.(0 to {N_MOUNTS - 1}).position.(0, 1) or "
        f"actuators.({', '.join(scenario.actuators)}).({', '.join(ACTUATOR_VALUES)})"
    )


def _labelled(key: str, value: ArrayLike | xr.DataArray) -> xr.DataArray:
    if isinstance(value, xr.DataArray):
        return value
    array = np.asarray(value, float)
    if array.ndim > 1:
        raise InputError(f"vary: {key} has shape {array.shape}; with several axes give an xarray.DataArray with names")
    return xr.DataArray(array, dims=(key,) * array.ndim)


def _coordinates(scenario: Scenario, given: Mapping[str, xr.DataArray]) -> dict[str, Any]:
    """Each key's values with their unit; a dimension without coordinates of its own takes those of its first key."""
    coords: dict[str, Any] = {}
    for key, value in given.items():
        unit, text = quantity_of(scenario, key)
        attributes = {"units": unit, "long_name": text}
        coords |= {str(name): coordinate for name, coordinate in value.coords.items()}
        if value.ndim == 1 and (name := str(value.dims[0])) not in coords:
            coords[name] = (name, value.values, attributes)
        coords[key] = (value.dims, value.values, attributes)
    return coords


def _limits(key: str) -> dict[str, float]:
    """What a value must keep, by pydantic's names (gt, ge, lt, le)."""
    first, _, rest = key.partition(".")
    if key in FOOTPRINT or rest.startswith("inertia"):
        return {"gt": 0.0}
    if first == "mount" or rest.startswith("cg"):
        return {}
    owners: dict[str, type[Settings]] = {"gravity": Scenario, "machine": Machine}
    owners |= {"supply": Supply, "actuators": Actuator}
    rules = owners[first].model_fields[key.rpartition(".")[2]].metadata
    return {name: getattr(rule, name) for rule in rules for name in ("gt", "ge", "lt", "le") if hasattr(rule, name)}


def _check(scenario: Scenario, key: str, values: Array) -> None:
    quantity_of(scenario, key)
    words = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}
    limits = _limits(key)
    allowed = " and ".join(f"{words[name]} {limit:g}" for name, limit in limits.items()) or "finite"
    wrong = np.isnan(values) if key.rpartition(".")[2] in _UNLIMITED else ~np.isfinite(values)
    compare = {"gt": np.greater, "ge": np.greater_equal, "lt": np.less, "le": np.less_equal}
    for name, limit in limits.items():
        wrong |= ~compare[name](values, limit)
    if wrong.any():
        raise InputError(f"vary: {key} = {values[wrong].flat[0]:g}: must be {allowed}")


def _check_plain(scenario: Scenario) -> None:
    """Refuse every option that the closed forms do not know: what adds states or moves a valve's operating point."""
    if scenario.supply.dynamic:
        raise InputError("supply.dynamic = true: must be false here; linear_model gives one such design")
    for name, actuator in scenario.actuators.items():
        for option, value in actuator.beyond((*ACTUATOR_VALUES, *_WITHOUT_EFFECT)).items():
            raise InputError(
                f"actuators.{name}.{option} = {value!r}: must be {Actuator.model_fields[option].default!r} here, "
                "where valves are linear about their centre"
            )


def _put(scenario: Scenario, common: dict[str, Array], mounts: dict[str, Array], key: str, value: Array) -> None:
    first, _, rest = key.partition(".")
    if key == "gravity":
        common["gravity"][...] = value
    elif first in ("machine", "supply"):
        common[rest][...] = value
    elif key in FOOTPRINT:
        own = mounts[FOOTPRINT[key]]
        ahead, behind = ([0, 1], [2, 3]) if key == "footprint.x" else ([0, 2], [1, 3])
        own *= (value / (own[..., ahead].mean(axis=-1) - own[..., behind].mean(axis=-1)))[..., None]
    elif first == "actuators":
        name, _, quantity = rest.partition(".")
        chosen = [MOUNTS.index(mount.name) for mount in scenario.mount if mount.actuator == name]
        mounts[quantity][..., chosen] = value[..., None]
        if quantity == "flow_gain":
            mounts["rated_flow"][..., chosen] = 0.0
    else:
        index, _, coordinate = rest.partition(".")
        mounts["xy"[int(coordinate[-1])]][..., MOUNTS.index(scenario.mount[int(index)].name)] = value
