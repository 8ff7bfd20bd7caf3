"""Values that are not looked for, and may yet be wrong: tests that follow them too."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from ehamj.errors import InputError
from ehamj.identification.file import IdentifyFile, ParameterSettings
from ehamj.identification.parameters import parameters_of
from ehamj.identification.residual import Residuals
from ehamj.identification.tests.test import Context
from ehamj.identification.unknowns import Unknown
from ehamj.scenario.keys import entries
from ehamj.scenario.model import Scenario

OF_ISOLATORS: Final = (
    "flow_gain", "flow_pressure", "bulk_modulus", "valve_frequency", "valve_damping", "membrane_stiffness",
    "lateral_stiffness",
)  # fmt: skip
OF_MACHINE: Final = ("mass", "cg.0", "cg.1", "cg.2", "inertia.0", "inertia.1", "inertia.2")
NEAR: Final = 0.15
"""Where the centre of gravity may be beside where it is held [m]."""


def held_values(file: IdentifyFile, machine: Scenario, looked_for: Sequence[str]) -> list[Unknown]:
    """Values of a machine and its isolators that are not looked for, with bounds in which they may be; none that a test
    has otherwise."""
    own_of_tests = {".".join(map(str, key)) for test in file.test for key, _ in entries(test.set)}
    names = [f"actuators.{name}.{key}" for name in machine.actuators for key in OF_ISOLATORS]
    found: list[Unknown] = []
    for name in (*names, *(f"machine.{key}" for key in OF_MACHINE)):
        own = machine.machine.cg[int(name[-1])] if name.startswith("machine.cg.") else None
        bounds = None if own is None else (own - NEAR, own + NEAR)
        if name not in looked_for and not any(name.startswith(key) for key in own_of_tests):
            try:
                found += parameters_of(machine, {name: ParameterSettings(bounds=bounds, prior=None)})
            except InputError:  # an isolator that has none of it
                continue
    return found


def following(
    file: IdentifyFile, machine: Scenario, keys: Sequence[str], measured: Mapping[str, Any], threads: int | None
) -> tuple[Residuals, ...]:
    """The tests of a file on a machine, told these keys at each point.

    Args:
        file: that asked.
        machine: whose values others are.
        keys: of the scenario.
        measured: by the test's name, what was read already.
        threads: that step runs.
    """
    context = Context(machine, tuple(keys), file.engine, threads, tuple(test.name for test in file.test), measured)
    return tuple(test.residuals(context) for test in file.test)
