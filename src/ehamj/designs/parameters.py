"""Parameters that designs differ in: their keys, units, limits and values, and a scenario with another value of one."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.errors import InputError, did_you_mean
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.supply import Supply
from ehamj.linear.values import ACTUATOR_VALUES, MACHINE_VALUES
from ehamj.plant.axes import AXES
from ehamj.plant.machine import Machine
from ehamj.plant.plant import Plant
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.settings import PROVENANCE, Settings

FOOTPRINT: Final = {"footprint.x": "x", "footprint.y": "y"}
"""Keys of the mounts' distance [m], front to rear and left to right (their means); positions scale about the centre."""

OWN: Final = "actuator."
"""What a key of a mount's own isolator goes on with: ``mount.front-left.actuator.flow_gain``."""

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
    number, value = mount_of(scenario, key)
    if number is not None and value in _PLACES:
        return "m", f"{_PLACES[value]} of the mount {scenario.mount[number].name}"
    own = value.removeprefix(OWN)
    if number is not None and own != value and own in ACTUATOR_VALUES:
        return Actuator.quantities()[own][
            0
        ], f"{own.replace('_', ' ')} of the isolator at {scenario.mount[number].name}"
    raise InputError(
        f"vary: {key!r} must be gravity, {', '.join(FOOTPRINT)}, machine.({', '.join(MACHINE_VALUES)}), "
        f"supply.({', '.join(_SUPPLY)}), mount.M.position.(0, 1, 2), actuators.({', '.join(scenario.actuators)}).Q or "
        f"mount.M.actuator.Q, with M a mount's number or name ({', '.join(mount.name for mount in scenario.mount)}) "
        f"and Q one of {', '.join(ACTUATOR_VALUES)}"
    )


def mount_of(scenario: Scenario, key: str) -> tuple[int | None, str]:
    """Number of the mount whose value a key ``mount.M.VALUE`` is, M its number or name, and the value; None and the
    key where it is no such key."""
    first, _, rest = _by_number(scenario, key).partition(".")
    number, _, value = rest.partition(".")
    known = first == "mount" and number in map(str, range(len(scenario.mount)))
    return (int(number), value) if known else (None, key)


def footprint_sides(plant: Plant, key: str) -> NDArray[np.bool_]:
    """Which mounts lie ahead (front, left) of their mean along the axis of a key of `FOOTPRINT`, (mount,)."""
    along = np.array(plant.positions)[:, "xy".index(FOOTPRINT[key])]
    return np.asarray(along > along.mean())


def footprint(plant: Plant, key: str) -> float:
    """Distance of the mounts, front to rear or left to right (their means) [m].

    Raises:
        InputError: if all of them stand in one line across it.
    """
    return _distance(key, np.array(plant.positions)[:, "xy".index(FOOTPRINT[key])])


def _distance(key: str, along: Array) -> float:
    """The same of coordinates along the key's axis (mount,) [m]."""
    ahead = along > along.mean()
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
    number, own = mount_of(scenario, key)
    if number is not None:
        mount = scenario.mount[number]
        if own in _PLACES:
            return mount.place[int(own[-1])]
        return float(getattr(scenario.actuators[mount.actuator], own.removeprefix(OWN)))
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
    return changed(scenario, changes_of(scenario, {key: value}))


def changes_of(scenario: Scenario, values: Mapping[str, Any]) -> dict[str, Any]:
    """What `ehamj.scenario.load.changed` is told, so that a scenario has these values all at once.

    Args:
        scenario: what they differ from.
        values: by key of `quantity_of`, or any other key of a scenario, which passes as it is. Values count as they
            are: another mass keeps the moments of inertia, and a footprint scales positions that are set beside it.

    Raises:
        InputError: if a footprint, a mount or a value of its isolator is none.
    """
    values = {_by_number(scenario, key): value for key, value in values.items()}
    found: dict[str, Any] = {}
    for key, value in values.items():
        *of, entry = key.split(".")
        if of == ["footprint"] and key not in FOOTPRINT:
            raise InputError(f"{key}: {did_you_mean(key, FOOTPRINT)}must be one of {', '.join(FOOTPRINT)}")
        if of == ["machine", "inertia"] and isinstance(scenario.machine.inertia[0], tuple):
            key = f"{key}.{entry}"  # a moment of a tensor, whose products are kept
        if key not in FOOTPRINT and not _position_of(key) and not _own_actuator_of(key):
            found[key] = value
    if "machine.mass" in found and not any(key.startswith("machine.inertia") for key in found):
        found = {"machine.inertia": scenario.machine.inertia, **found}  # which would follow
    return found | _places(scenario, values) | _own_actuators(scenario, values)


def _by_number(scenario: Scenario, key: str) -> str:
    """A key of a mount by its number, where it has the mount's name."""
    first, _, rest = key.partition(".")
    name, _, last = rest.partition(".")
    names = [mount.name for mount in scenario.mount]
    return f"mount.{names.index(name)}.{last}" if first == "mount" and name in names and last else key


def _position_of(key: str) -> tuple[int, int] | None:
    """Mount and axis of a key that is one coordinate of a mount."""
    parts = key.split(".")
    if len(parts) != 4 or parts[0] != "mount" or parts[2] != "position" or not (parts[1] + parts[3]).isdigit():
        return None
    return int(parts[1]), int(parts[3])


def _own_actuator_of(key: str) -> tuple[int, str] | None:
    """Mount and quantity of a key that is a value of one mount's own actuator."""
    parts = key.split(".")
    own = len(parts) == 4 and parts[0] == "mount" and parts[2] == "actuator" and parts[1].isdigit()
    return (int(parts[1]), parts[3]) if own else None


def _places(scenario: Scenario, values: Mapping[str, Any]) -> dict[str, Any]:
    """Positions of the mounts that have others."""
    places = np.array([mount.place for mount in scenario.mount])
    moved = {key for key in values if key in FOOTPRINT or _position_of(key)}
    for key in sorted(moved, key=lambda key: key in FOOTPRINT):
        if at := _position_of(key):
            if at[0] >= len(places) or at[1] >= len(AXES):
                raise InputError(f"{key}: there are mounts 0 to {len(places) - 1}, and coordinates 0 to 2 of each")
            places[at] = values[key]
        else:
            along = places[:, "xy".index(FOOTPRINT[key])]
            along *= values[key] / _distance(key, along)
    before = np.array([mount.place for mount in scenario.mount])
    others = np.flatnonzero((places != before).any(axis=1))
    return {f"mount.{k}.position": places[k].tolist() for k in others.tolist()}


def _own_actuators(scenario: Scenario, values: Mapping[str, Any]) -> dict[str, Any]:
    """Tables of actuators of their own for mounts that have one, from the others' as they are to become."""
    found: dict[str, Any] = {}
    of: dict[int, dict[str, Any]] = {}
    for key, value in values.items():
        if at := _own_actuator_of(key):
            of.setdefault(at[0], {})[at[1]] = value
    shared = {key: value for key, value in values.items() if key.startswith("actuators.")}
    becoming = changed(scenario, shared).actuators if of and shared else scenario.actuators
    for number, own in of.items():
        if number >= len(scenario.mount):
            raise InputError(f"mount.{number}: there are mounts 0 to {len(scenario.mount) - 1}")
        mount = scenario.mount[number]
        actuator = becoming[mount.actuator]
        for name in own:
            if name not in ACTUATOR_VALUES and name not in Actuator.model_fields:
                near = did_you_mean(name, ACTUATOR_VALUES)
                raise InputError(
                    f"mount.{mount.name}.actuator.{name}: {near}must be one of {', '.join(ACTUATOR_VALUES)}"
                )
        table = actuator.model_dump(include=set(Actuator.model_fields)) | own
        for key in PROVENANCE:
            table[key] = {name: one for name, one in getattr(actuator, key).items() if name not in own}
        found[f"actuators.{mount.name}"] = table
        found[f"mount.{number}.actuator"] = mount.name
    return found


def _limits(key: str) -> dict[str, float]:
    """What a value must keep, by pydantic's names (gt, ge, lt, le)."""
    first, _, rest = key.partition(".")
    if key in FOOTPRINT or rest.startswith("inertia"):
        return {"gt": 0.0}
    if ".position." in key or rest.startswith("cg"):
        return {}
    owners: dict[str, type[Settings]] = {"gravity": Scenario, "machine": Machine}
    owners |= {"supply": Supply, "actuators": Actuator, "mount": Actuator}
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
