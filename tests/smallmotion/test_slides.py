"""Slides and feet that give way on both engines, and slides that move in some lanes while they stand in others."""

from typing import Any

import numpy as np
import pytest

from ehamj.run.many import observe_many
from ehamj.run.simulate import observed
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario


@pytest.fixture(autouse=True)
def _one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """All cases come in one batch, however many processors there are."""
    monkeypatch.setattr("ehamj.run.many.processors", lambda: 1)


TURNED = 5.0
"""What is left out, of a channel's peak, over the angle by which the machine turns: docs/physics.md."""


def moving(**own: Any) -> dict[str, Any]:
    """A slide that goes 4 cm at up to 0.3 m/s."""
    moves = {"kind": "moves", "moves": [{"time": 0.01, "to": 0.04, "speed": 0.3, "acceleration": 5.0, "jerk": 200.0}]}
    slide = {"name": "t", "mass": 500.0, "position": [0.1, 0.1, 0.9], "rail": [1.0, 0.2, 0.0], "travel": [-0.1, 0.1]}
    return {"slide": [{**slide, "profile": moves, **own}]}


SHAKEN = {"ground": {"kind": "sine", "amplitude": 1e-6, "frequency": 30.0, "dof": "z", "wave": {"speed": 200.0}}}
SOFT = {"plates": "sliding", "actuators": {"isolator": {"foot_stiffness": 1e9, "foot_damping": 1e4}}}


def scenario(**table: Any) -> Scenario:
    base = {"plates": "tied", "duration": 0.2, "timestep": 5e-5, "record_rate": 1000.0}
    return parse_scenario({**base, **table})


@pytest.mark.parametrize("table", [moving(), SOFT | SHAKEN, SOFT | SHAKEN | moving()], ids=["slide", "feet", "both"])
def test_both_engines_agree_to_second_order(table: dict[str, Any]) -> None:
    ours, truth = (observed(scenario(**table, engine=engine)).dataset for engine in ("small-motion", "mujoco"))
    turned = float(np.abs(truth.machine_displacement.values[:, 3:] - truth.machine_displacement.values[0, 3:]).max())
    assert 1e-8 < turned < 1e-5
    for name in ("machine_displacement", "machine_velocity", "cg_acceleration", "stroke", "chamber_pressure", "slide"):
        if name in truth:
            motion = truth[name].values - truth[name].values[0]
            error = np.abs(ours[name].values - truth[name].values).max()
            assert error < (TURNED * turned + 1e-8) * np.abs(motion).max(), name


def test_slides_move_in_some_lanes_and_stand_in_others() -> None:
    """Of a stretch of 512 steps too: the last has one step."""
    cases = [
        scenario(engine="small-motion", duration=0.02565, record_rate=10000.0, **table)
        for table in (moving(), moving(profile={"kind": "rest"}), {}, moving(mass=300.0))
    ]
    for case, found in zip(cases, observe_many(cases, lambda run: run.dataset), strict=True):
        alone = observed(case).dataset
        for name in alone.data_vars:
            np.testing.assert_array_equal(alone[name].values, found[name].values, err_msg=str(name))
