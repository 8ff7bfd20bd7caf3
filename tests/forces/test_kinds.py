"""Every kind of force that is registered runs."""

from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from ehamj.forces.kinds import FORCES
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

KINDS = {get_args(force.model_fields["kind"].annotation)[0]: force for force in FORCES}

TABLES: dict[str, dict[str, Any]] = {
    "hammer": {"peak": 1000.0, "begin": 0.01},
    "axis-jerk": {"moving_mass": 100.0, "begin": 0.0},
    "unbalance": {"moment": 0.01, "speed": 50.0, "run_up": 0.0},
    "sine": {"amplitude": 100.0, "frequency": 20.0},
    "multisine": {"amplitude": 100.0, "frequencies": [20.0, 30.0]},
    "random": {"rms": 100.0},
    "recorded": {"file": "push.csv"},
}
"""What a kind needs beside its defaults to push within the short run."""


def test_every_kind_is_a_force_of_the_scenario() -> None:
    """One kind each, and the scenario's schema takes just these."""
    assert len(KINDS) == len(FORCES)
    schema = Scenario.model_json_schema()["properties"]["force"]["items"]
    assert set(schema["discriminator"]["mapping"]) == set(KINDS)
    assert set(TABLES) <= set(KINDS)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_runs(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The machine moves as it would not without it, and the step follows the force."""
    monkeypatch.chdir(tmp_path)
    Path("push.csv").write_text("time [s],F [N]\n" + "".join(f"{k / 1000},{100 * (k % 10)}\n" for k in range(40)))
    needed = {name for name, field in KINDS[kind].model_fields.items() if field.is_required()} - {"kind"}
    assert needed <= set(TABLES.get(kind, {})), f"a force that cannot run on its defaults needs a line in {__file__}"
    table = {"kind": kind, "direction": [1.0, 0.0, 0.0], **TABLES.get(kind, {})}
    scenario = parse_scenario({"duration": 0.03, "plates": "tied", "force": [table]})
    assert 0.0 < scenario.load().longest_step < np.inf
    data = simulate(scenario).dataset
    still = simulate(scenario.model_copy(update={"force": ()})).dataset
    pushed = data.cg_velocity.values - still.cg_velocity.values
    assert np.isfinite(pushed).all()
    assert np.abs(pushed).max() > 0.0, "it does not push within 0.03 s: give it a line in TABLES"
