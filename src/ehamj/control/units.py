"""Units of states and signals: SI, spools in mA, commands in V."""

from collections.abc import Iterable
from typing import Final

from ehamj.control.channels import quantity_of
from ehamj.plant.axes import DOFS

UNITS: Final = {
    "displacement": "m", "velocity": "m/s", "acceleration": "m/s²", "spool": "mA", "spool_rate": "mA/s",
    "pressure": "Pa", "line_flow": "m³/s",
}  # fmt: skip
"""By quantity."""
FORCED: Final = {"valve_command": "V", "cg_force": "N"}
"""Of what is no channel; moments are in N m."""
TURNS: Final = DOFS[3:]


def signal_units(names: Iterable[str]) -> tuple[str, ...]:
    """Units of inputs and outputs of plants and laws: commands, forces, and channels (`ehamj.control.channels`)."""
    return tuple(map(_signal_unit, names))


def _signal_unit(name: str) -> str:
    variable, _, label = name.partition(" ")
    if variable in FORCED:
        return FORCED[variable] + (" m" if label in TURNS else "")
    quantity = quantity_of(variable)
    return turning("mA" if quantity == "position" else UNITS[quantity], label)


def turning(unit: str, label: str) -> str:
    """The unit of a motion, rad in place of m where the label is of a turn."""
    return unit.replace("m", "rad", 1) if label in TURNS and unit.startswith("m") and unit != "mA" else unit


def plain_unit(unit: str) -> str:
    """A unit in letters that every tool has: m/s^2."""
    return unit.replace("²", "^2").replace("³", "^3")
