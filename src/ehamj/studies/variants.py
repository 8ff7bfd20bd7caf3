"""Variants of a scenario: what studies change about a machine, each checked as a scenario file is."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ehamj.isolator.actuator import Actuator
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Isolator, Scenario


def changed(scenario: Scenario, **tables: Any) -> Scenario:
    """The scenario with other tables or values at its top level."""
    return parse_scenario(scenario.model_dump() | tables)


def still(scenario: Scenario, **tables: Any) -> Scenario:
    """The bare machine: floor at rest, valves held, no variants."""
    bare = {"ground": {"kind": "rest"}, "control": {"kind": "passive"}, "compare": ()}
    return changed(scenario, **(bare | tables))


def positions(scenario: Scenario) -> np.ndarray:
    """x and y of the mounts in their order, (mount, 2) [m]."""
    return np.array(scenario.plant.positions)


def resized(scenario: Scenario, cg: Sequence[float] | None = None, places: np.ndarray | None = None) -> dict[str, Any]:
    """The tables ``machine`` and ``mount`` for another centre of gravity [m] or other mounts (mount, 2) [m].

    The outline, which is drawn only, grows where it must; mass and inertia about the CG stay.
    """
    machine = scenario.machine
    own_cg = tuple(machine.cg if cg is None else map(float, cg))
    at = positions(scenario) if places is None else np.asarray(places, float)
    half = np.maximum(np.abs(at).max(axis=0) + 0.1, np.abs(own_cg[:2]))
    size = (*(max(have, 2.0 * need) for have, need in zip(machine.size[:2], half, strict=True)),
            max(machine.size[2], 1.6 * own_cg[2]))  # fmt: skip
    mounts = [mount.model_dump() for mount in scenario.mount]
    for mount in mounts:
        mount["position"] = tuple(at[MOUNTS.index(mount["name"])].tolist())
    return {"machine": machine.with_values({"cg": own_cg, "size": size}).model_dump(), "mount": tuple(mounts)}


def with_actuators(scenario: Scenario, actuators: Mapping[str, Actuator]) -> dict[str, Any]:
    """The tables ``actuators`` and ``mount`` with actuators of their own at some mounts, by the mounts' names."""
    tables: dict[str, Any] = {name: one.model_dump() for name, one in scenario.actuators.items()}
    mounts = [mount.model_dump() for mount in scenario.mount]
    for mount in mounts:
        if mount["name"] in actuators:
            tables[mount["name"]] = _table(actuators[mount["name"]])
            mount["actuator"] = mount["name"]
    return {"actuators": tables, "mount": tuple(mounts)}


def with_every_actuator(scenario: Scenario, actuator: Actuator) -> dict[str, Any]:
    """The tables ``actuators`` and ``mount`` with the same actuator at every mount."""
    return with_actuators(scenario, dict.fromkeys(MOUNTS, actuator))


def _table(actuator: Actuator) -> dict[str, Any]:
    own = set(Actuator.model_fields)
    return {name: value for name, value in actuator.model_dump().items() if name in own}


def preset(name: str) -> Actuator:
    """The actuator of a preset, as a scenario's table makes it."""
    return Isolator.model_validate({"preset": name})
