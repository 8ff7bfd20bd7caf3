"""Variants of a scenario: what studies change about a machine, each checked as a scenario file is."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.control.settings import DigitalSettings
from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import Isolator
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario


def still(scenario: Scenario, **tables: Any) -> Scenario:
    """The bare machine: floor at rest, valves held, no variants."""
    bare = {"ground": {"kind": "rest"}, "control": {"kind": "passive"}, "compare": (), "fault": ()}
    return changed(scenario, bare | tables)


BANDS: Final = ("2", "5", "10", "20", "50", "100")
"""Third-octave bands [Hz] whose attenuation studies compare."""
RECORD_RATE: Final = 4000.0
"""Rows per second [Hz]: motion above half of them would be read as if it were slow."""


def derived_law(scenario: Scenario) -> DigitalSettings:
    """The scenario's control, which must be a law that is derived from a machine.

    Raises:
        InputError: if it is none.
    """
    if not isinstance(scenario.control, DigitalSettings):
        raise InputError(
            f"control.kind = {scenario.control.kind!r}: the study needs a law that is derived from a machine; "
            "set control.kind to an architecture, such as 'combined'"
        )
    return scenario.control


def check_band(hertz: float, bands: Sequence[str] = BANDS) -> None:
    """Raise InputError unless a band [Hz] is one of those that a study looks at."""
    if f"{hertz:g}" not in bands:
        raise InputError(f"band = {hertz:g} Hz: must be one of {', '.join(bands)}")


def check_gravity(scenario: Scenario, without: str) -> None:
    """Raise InputError if there is no gravity, ``without`` which a study asks nothing."""
    if scenario.gravity == 0.0:
        raise InputError(f"gravity = 0 m/s²: must be positive for this study, since nothing {without} without it")


def positions(scenario: Scenario) -> NDArray[np.float64]:
    """x and y of the mounts in their order, (mount, 2) [m]."""
    return np.array(scenario.plant.positions)[:, :2]


def resized(scenario: Scenario, cg: Sequence[float] | None = None, places: np.ndarray | None = None) -> dict[str, Any]:
    """The tables ``machine`` and ``mount`` for another centre of gravity [m] or other x and y of mounts (mount, 2) [m].

    The outline, which is drawn only, grows where it must; mass and inertia about the CG stay, and z of the mounts.
    """
    machine = scenario.machine
    own_cg = tuple(machine.cg if cg is None else map(float, cg))
    at = positions(scenario) if places is None else np.asarray(places, float)[:, :2]
    half = np.maximum(np.abs(at).max(axis=0) + 0.1, np.abs(own_cg[:2]))
    size = (*(max(have, 2.0 * need) for have, need in zip(machine.size[:2], half, strict=True)),
            max(machine.size[2], 1.6 * own_cg[2]))  # fmt: skip
    place = dict(zip(scenario.plant.mounts, at.tolist(), strict=True))
    mounts = tuple(
        mount.model_dump() | {"position": (*place[mount.name], *mount.position[2:])} for mount in scenario.mount
    )
    return {"machine": machine.with_values({"cg": own_cg, "size": size}).model_dump(), "mount": mounts}


def with_actuators(scenario: Scenario, actuators: Mapping[str, Actuator]) -> dict[str, Any]:
    """The tables ``actuators`` and ``mount`` with actuators of their own at some mounts, by the mounts' names."""
    own = {name: one.model_dump(include=set(Actuator.model_fields)) for name, one in actuators.items()}
    mounts = (mount.model_dump() for mount in scenario.mount)
    return {
        "actuators": {name: one.model_dump() for name, one in scenario.actuators.items()} | own,
        "mount": tuple(mount | ({"actuator": mount["name"]} if mount["name"] in own else {}) for mount in mounts),
    }


def with_every_actuator(scenario: Scenario, actuator: Actuator) -> dict[str, Any]:
    """The tables ``actuators`` and ``mount`` with the same actuator at every mount."""
    return with_actuators(scenario, dict.fromkeys(scenario.plant.mounts, actuator))


def every_value(scenario: Scenario, name: str, values: xr.DataArray, relative: bool = True) -> dict[str, xr.DataArray]:
    """One quantity of all actuators in use varied together, by key (`ehamj.designs.designs.Designs`); ``relative``:
    the values are factors."""
    used = sorted({mount.actuator for mount in scenario.mount})
    own = {one: getattr(scenario.actuators[one], name) if relative else 1.0 for one in used}
    return {f"actuators.{one}.{name}": values * own[one] for one in used}


def preset(name: str) -> Actuator:
    """The actuator of a preset, as a scenario's table makes it."""
    return Isolator.model_validate({"preset": name})
