"""Moments of inertia that are looked for: bounded together, and held where nobody gave them, which is told."""

import pytest

from ehamj.errors import InputError
from ehamj.identification.file import ParameterSettings
from ehamj.identification.inertia import inertia_notes
from ehamj.identification.machine import with_values
from ehamj.identification.parameters import parameters_of
from ehamj.scenario.load import parse_scenario

MOMENTS = [f"machine.inertia.{k}" for k in range(3)]


def test_moments_are_bounded_together() -> None:
    """Twice the largest alone is of no body, but is where the others are larger too: it is no bound's fault."""
    machine = parse_scenario({})
    free = ParameterSettings(bounds=None, prior=None)
    found = {one.name: one for one in parameters_of(machine, dict.fromkeys(["machine.mass", *MOMENTS], free))}
    assert [(one.low, one.high) for one in found.values()][1:] == [(0.5 * J, 2.0 * J) for J in machine.machine.inertia]
    with pytest.raises(InputError, match="of no rigid body"):
        with_values(machine, {MOMENTS[2]: 8000.0})
    larger = with_values(machine, {"machine.mass": 6000.0, **dict(zip(MOMENTS, (4000.0, 6000.0, 8000.0), strict=True))})
    assert larger.machine.inertia == (4000.0, 6000.0, 8000.0)


def test_moments_that_nobody_gave_are_held_and_told() -> None:
    machine = parse_scenario({"machine": {"mass": 4400.0}})
    heavier = with_values(machine, {"machine.mass": 6000.0})
    assert heavier.machine.inertia == machine.machine.inertia
    (said,) = inertia_notes(machine, heavier, ["machine.mass"])
    assert said.startswith(f"{', '.join(MOMENTS)}: not given, and held at the assumed 2200, 3300, 4400 kg m²")
    one = with_values(machine, {"machine.mass": 6000.0, MOMENTS[0]: 2300.0})
    assert one.machine.inertia == (2300.0, *machine.machine.inertia[1:])
    (said,) = inertia_notes(machine, one, ["machine.mass", MOMENTS[0]])
    assert said.startswith(f"{', '.join(MOMENTS[1:])}: not given, and held at the assumed 3300, 4400 kg m²")
    assert not list(inertia_notes(machine, machine, ["actuators.isolator.flow_gain"]))
    edge = with_values(machine, dict(zip(MOMENTS, (2000.0, 3000.0, 5000.0), strict=True)))
    (said,) = inertia_notes(machine, edge, MOMENTS)
    assert "more than which no body has" in said
    given = parse_scenario({"machine": {"inertia": [2000.0, 3000.0, 4000.0]}})
    assert not list(inertia_notes(given, with_values(given, {"machine.mass": 6000.0}), ["machine.mass"]))
