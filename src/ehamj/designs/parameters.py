"""Parameters that designs differ in: their keys, units, limits and values, and a scenario with another value of one."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.supply import Supply
from ehamj.linear.values import ACTUATOR_VALUES, MACHINE_VALUES
from ehamj.plant.axes import AXES
from ehamj.plant.machine import Machine
from ehamj.plant.plant import Plant
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings

FOOTPRINT: Final = {"footprint.x": "x", "footprint.y": "y"}
"""Keys of the mounts' distance [m], front to rear and left to right (their means); positions scale about the centre."""

_PLACES: Final = {f"position.{k}": axis for k, axis in enumerate(AXES)}
_SUPPLY: Final = ("pressure", "tank_pressure")
_UNLIMITED: Final = ("wall_modulus", "foot_stiffness")
"""Values that may be infinite."""


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
    if first == "mount" and name in map(str, range(len(scenario.mount))) and value in _PLACES:
        return "m", f"{_PLACES[value]} of the mount {scenario.mount[int(name)].name}"
    raise InputError(
        f"vary: {key!r} must be gravity, {', '.join(FOOTPRINT)}, machine.({', '.join(MACHINE_VALUES)}), "
        f"supply.({', '.join(_SUPPLY)}), mount.(0 to {len(scenario.mount) - 1}).position.(0, 1, 2) or "
        f"actuators.({', '.join(scenario.actuators)}).({', '.join(ACTUATOR_VALUES)})"
    )


def footprint_sides(plant: Plant, key: str) -> NDArray[np.bool_]:
    """Which mounts lie ahead (front, left) of their mean along the axis of a key of `FOOTPRINT`, (mount,)."""
    along = np.array(plant.positions)[:, "xy".index(FOOTPRINT[key])]
    return np.asarray(along > along.mean())


def footprint(plant: Plant, key: str) -> float:
    """Distance of the mounts, front to rear or left to right (their means) [m].

    Raises:
        InputError: if all of them stand in one line across it.
    """
    along, ahead = np.array(plant.positions)[:, "xy".index(FOOTPRINT[key])], footprint_sides(plant, key)
    if not ahead.any():
        raise InputError(f"{key}: all mounts have {FOOTPRINT[key]} = {along[0]:g} m, there is no distance to vary")
    return float(along[ahead].mean() - along[~ahead].mean())


def parameters_of(scenario: Scenario) -> tuple[str, ...]:
    """Keys (`quantity_of`) of all parameters that the linear machine depends on and that are
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
        return footprint(scenario.plant, key)
    first, _, rest = key.partition(".")
    if first == "mount":
        index, _, value = rest.partition(".")
        return scenario.mount[int(index)].place[int(value[-1])]
    place: Any = scenario
    for part in key.split("."):
        if isinstance(place, tuple):
            place = place[int(part)]
            place = place[int(part)] if isinstance(place, tuple) else place  # a moment of a tensor
        else:
            place = place[part] if isinstance(place, dict) else getattr(place, part)
    return float(place)


def with_value(scenario: Scenario, key: str, value: float) -> Scenario:
    """The scenario with another value of one parameter.

    Raises:
        InputError: if there is no such parameter, or the value is impossible.
    """
    quantity_of(scenario, key)
    first, _, rest = key.partition(".")
    if first == "mount":
        index, _, coordinate = rest.partition(".")
        place = list(scenario.mount[int(index)].place)
        place[int(coordinate[-1])] = value
        return changed(scenario, {f"mount.{index}.position": place})
    if key not in FOOTPRINT:
        kept = {"machine.inertia": scenario.machine.inertia} if key == "machine.mass" else {}  # which would follow
        *of, entry = key.split(".")
        if of == ["machine", "inertia"] and isinstance(scenario.machine.inertia[0], tuple):
            key = f"{key}.{entry}"  # a moment of a tensor, whose products are kept
        return changed(scenario, {key: value, **kept})
    axis, factor = "xy".index(FOOTPRINT[key]), value / footprint(scenario.plant, key)
    places = {f"mount.{k}.position.{axis}": factor * mount.position[axis] for k, mount in enumerate(scenario.mount)}
    return changed(scenario, places)


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


def check(scenario: Scenario, key: str, values: Array) -> None:
    """Refuse a key that is none, and values that are impossible."""
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
