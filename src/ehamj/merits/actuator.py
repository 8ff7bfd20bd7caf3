"""Merits of the actuators by themselves: the figures of the paper, and what supply and membranes give them."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.isolator.actuator import hydraulic_stiffness, static_stiffness
from ehamj.linear.values import Values
from ehamj.merits.merit import SOURCES, Machine, Merit
from ehamj.merits.stacked import LinearSource, Row, Stacked
from ehamj.paper.actuator import LINEAR, WITHOUT_EFFECT
from ehamj.paper.many import FIGURES, Actuators, figures
from ehamj.scenario.model import Scenario

MORE: Final[Mapping[str, tuple[str, str]]] = {
    "static_stiffness": ("N/m", "stiffness along the isolator against a load that stays, its foot in series"),
    "full_flow": ("m³/s", "flow of the valve fully open at half the supply's pressure, K_Q x_max"),
    "full_speed": ("m/s", "stroke velocity then, over the piston's area"),
    "stall_force": ("N", "force of all of the supply's pressure on the piston, A_p (P_s − P_t)"),
}
"""Figures that the paper does not have."""


class ActuatorSource(LinearSource):
    """Figures of each actuator of the scenario.

    Those of the paper are of its linear actuator under an even share of the machine's mass, plates included: all that
    stands on the mounts over their number. Of isolators of one kind that differ from each other it is their mean.
    """

    def merits(self, machine: Machine) -> Mapping[str, Merit]:
        used = dict.fromkeys(mount.actuator for mount in machine.scenario.mount)
        return {
            f"actuator.{kind}.{name}": Merit(f"actuator.{kind}.{name}", unit, f"{text}; {kind}")
            for kind in used
            for name, (unit, text) in {**FIGURES, **MORE}.items()
        }

    def notes(self, machine: Machine) -> list[str]:
        found = super().notes(machine)
        for kind, actuator in machine.scenario.actuators.items():
            if beyond := actuator.beyond((*LINEAR, *WITHOUT_EFFECT)):
                found.append(f"the paper's linear actuator knows nothing of {', '.join(beyond)} of {kind}")
        return found

    def opens(self, machine: Machine) -> str | None:
        return None  # the figures are those of the linear actuator, whatever else the valve has

    def together(self, stacked: Stacked, names: Sequence[str]) -> list[Row]:
        return _rows(stacked.machine.scenario, stacked.designs.values, names, stacked.count)

    def alone(self, machine: Machine, scenario: Scenario, names: Sequence[str]) -> Row:
        return _rows(scenario, Values.of(scenario.plant), names, 1)[0]


def _rows(scenario: Scenario, values: Values, names: Sequence[str], count: int) -> list[Row]:
    found, kinds = _figures(values), {mount.name: mount.actuator for mount in scenario.mount}
    columns: dict[str, Array] = {}
    for name in names:
        _, kind, figure = name.split(".")
        own = [k for k, mount in enumerate(scenario.plant.mounts) if kinds[mount] == kind]
        columns[name] = found[figure][..., own].mean(axis=-1).reshape(-1)
    return [{name: float(column[k]) for name, column in columns.items()} for k in range(count)]


def _figures(values: Values) -> dict[str, Array]:
    """All figures of each isolator, (…, mount)."""
    at, common = values.mounts, values.common
    mass = (common["mass"] + at["plate_mass"].sum(axis=-1)) / len(values.frames)
    shape = np.broadcast_shapes(mass[..., None].shape, at["piston_area"].shape)
    given = {name: np.broadcast_to(at[name], shape) for name in (field.name for field in fields(Actuators)[:-1])}
    found = figures(Actuators(**given, mass=np.broadcast_to(mass[..., None], shape)))
    oil = hydraulic_stiffness(at["bulk_modulus"], at["piston_area"], at["chamber_volume"]) * (at["flow_pressure"] == 0)
    found["static_stiffness"] = static_stiffness(at["membrane_stiffness"] + oil, at["foot_stiffness"])
    found["full_flow"] = at["flow_gain"] * at["spool_stroke"]
    found["full_speed"] = found["full_flow"] / at["piston_area"]
    drop = common["pressure"] - common["tank_pressure"]
    found["stall_force"] = at["piston_area"] * np.asarray(drop)[..., None]
    return found


SOURCES.add("actuator", ActuatorSource())
