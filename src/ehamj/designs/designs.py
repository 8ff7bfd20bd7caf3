"""Many designs of the machine at once: which values they have, as labelled arrays.

    heights = xr.DataArray(np.linspace(0.3, 2.0, 50), dims="height")
    spans = xr.DataArray(np.linspace(0.8, 2.4, 50), dims="span")
    many = Designs.of(scenario, {"machine.cg.2": heights, "footprint.x": spans, "footprint.y": spans})

What they do is in `ehamj.designs.many` and `ehamj.designs.floor`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ehamj.arrays import Array
from ehamj.designs.parameters import FOOTPRINT, OWN, check, footprint_sides, mount_of, quantity_of
from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.linear.values import ACTUATOR_VALUES, Values, body_of, of_body
from ehamj.plant.axes import AXES
from ehamj.plant.bodies import joined
from ehamj.scenario.model import Scenario

_WITHOUT_EFFECT: Final = (
    "moving_volume", "flow_curve", "spool_drive_limit", "end_stops", "voltage_limit", "passive", "preset", "oil",
    "valve",
)  # fmt: skip
"""Settings of an actuator that nobody can vary here: taken as they are, limits, a matter of laws, or where others come
from."""


@dataclass(frozen=True)
class Designs:
    """A grid of designs: labelled dimensions, and each physical value over them (`ehamj.linear.elements.Values`)."""

    dims: dict[str, int]
    coords: dict[str, Any]
    values: Values
    mounts: tuple[str, ...]
    """Names of the mounts, in the order of the last axis of their values."""

    @classmethod
    def of(cls, scenario: Scenario, vary: Mapping[str, ArrayLike | xr.DataArray]) -> "Designs":
        """Designs that differ from a scenario's machine in some keys; ``{}`` gives that machine alone.

        Args:
            scenario: the machine that everything else is taken from.
            vary: values by key, as in ``ehamj run --set``: ``machine.mass``, ``machine.cg.2``, ``gravity``,
                ``actuators.NAME.lateral_stiffness``, ``mount.0.position.2``, ``supply.pressure``; ``footprint.x`` and
                ``footprint.y`` (`FOOTPRINT`); and ``mount.front-left.actuator.flow_gain``, one isolator's own value,
                whatever its kind has. A plain 1-D array gets a dimension of its own, named by the key; give a
                ``xarray.DataArray`` with dimensions to let keys vary together (the same name) or to name them. Values
                count as they are: a CG may lie outside the drawn outline.

        Raises:
            InputError: if a key or a value is impossible, or the scenario's valves have no linear model in closed form.
        """
        _check_plain(scenario)
        given = {key: _labelled(key, value) for key, value in vary.items()}
        for key, value in given.items():
            check(scenario, key, np.asarray(value.values, float))
        joint = dict(zip(given, xr.broadcast(*given.values()), strict=True)) if given else {}
        dims: dict[str, int] = {}
        for value in given.values():
            dims |= {str(name): size for name, size in value.sizes.items() if str(name) not in dims}
        shape = tuple(dims.values())
        base = Values.of(scenario.plant)
        known = {
            **base.common,
            **of_body(scenario.machine.body),
        }  # keys are those of the frame, without what stands on it
        common = {name: np.broadcast_to(value, shape).copy() for name, value in known.items()}
        mounts = {name: np.broadcast_to(value, (*shape, *value.shape)).copy() for name, value in base.mounts.items()}
        # A footprint scales positions that are set, and an isolator's own value replaces that of its kind.
        for key in sorted(joint, key=lambda key: (key in FOOTPRINT) + key.startswith("mount.")):
            _put(scenario, common, mounts, key, joint[key].transpose(*dims).values.astype(float))
        if scenario.others:
            common |= of_body(joined([body_of(common), *scenario.others]))
        return cls(dims, _coordinates(scenario, given), Values(common, mounts, base.frames), scenario.plant.mounts)

    @property
    def shape(self) -> tuple[int, ...]:
        """Sizes of the dimensions."""
        return tuple(self.dims.values())


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
    plant = scenario.plant
    if key == "gravity":
        common["gravity"][...] = value
    elif first in ("machine", "supply"):
        common[rest][...] = value
    elif key in FOOTPRINT:
        along, ahead = mounts[FOOTPRINT[key]], footprint_sides(plant, key)
        along *= (value / (along[..., ahead].mean(axis=-1) - along[..., ~ahead].mean(axis=-1)))[..., None]
    elif first == "actuators":
        name, _, quantity = rest.partition(".")
        chosen = [plant.mounts.index(mount.name) for mount in scenario.mount if mount.actuator == name]
        mounts[quantity][..., chosen] = value[..., None]
    else:
        number, own = mount_of(scenario, key)
        assert number is not None
        name = own.removeprefix(OWN) if own.startswith(OWN) else AXES[int(own[-1])]
        mounts[name][..., plant.mounts.index(scenario.mount[number].name)] = value
