"""Every kind of ground that is registered runs."""

from typing import Any, get_args

import numpy as np
import pytest

from ehamj.ground.kinds import GROUNDS, SumGround
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

KINDS = {get_args(ground.model_fields["kind"].annotation)[0]: ground for ground in (*GROUNDS, SumGround)}

TABLES: dict[str, dict[str, Any]] = {
    "multisine": {"frequencies": [20.0], "velocities": [1e-5]},
    "shock": {"begin": 0.0},
    "burst": {"begin": 0.0, "swell_time": 0.02},
    "shaped": {"target": {"kind": "psd", "frequencies": [10.0, 80.0], "density": [1e-12, 1e-12]}},
    "floor": {"floor": "workshop"},
    "record": {"file": "example:BW.RJOB"},
    "sum": {"parts": [{"kind": "sine"}, {"kind": "sweep"}]},
}
"""What a kind needs beside its defaults to move within the short run."""


def test_every_kind_is_a_ground_of_the_scenario() -> None:
    """One kind each, and the scenario's schema takes just these."""
    assert len(KINDS) == len(GROUNDS) + 1
    assert set(Scenario.model_json_schema()["properties"]["ground"]["discriminator"]["mapping"]) == set(KINDS)
    assert set(TABLES) <= set(KINDS)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_runs(kind: str) -> None:
    """The floor below the machine moves as the motion says, and derivatives belong to it."""
    needed = {name for name, field in KINDS[kind].model_fields.items() if field.is_required()} - {"kind"}
    assert needed <= set(TABLES.get(kind, {})), f"a ground that cannot run on its defaults needs a line in {__file__}"
    table = {"kind": kind, **TABLES.get(kind, {})}
    scenario = parse_scenario({"duration": 0.03, "plates": "tied", "ground": table})
    data = simulate(scenario).dataset
    moved = data.ground_displacement.values
    assert (np.abs(moved).max() > 0.0) == (kind != "rest")
    np.testing.assert_array_equal(moved, scenario.motion().sample(data.time.values).displacement)
    slope = np.gradient(moved, data.time.values, axis=0)[1:-1]
    speed = data.ground_velocity.values[1:-1]
    np.testing.assert_allclose(slope, speed, atol=0.15 * max(np.abs(speed).max(), 1e-30))
