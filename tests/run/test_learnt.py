"""What a summary says of a law that learns."""

from typing import Any

import numpy as np
import xarray as xr

from ehamj.control.law import Controller
from ehamj.control.learners import STATED, Learnt
from ehamj.judge.brief import brief
from ehamj.run.learnt import learnt, unlearnt
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

TABLE: dict[str, Any] = {"control": {"kind": "feedforward", "linearisation": False, "learning": {"least": 0.004}}}


def test_mounts_of_which_nothing_was_learnt_are_named_with_what_it_would_have_taken() -> None:
    law = parse_scenario(TABLE).controller()
    assert isinstance(law, Controller)
    rows = np.tile(STATED, (2, 4, 1))
    rows[1, 1, 0] = 1.01
    dims = ("time", "mount")
    dataset = xr.Dataset({f"learnt_{name}": (dims, rows[:, :, k]) for k, name in enumerate(Learnt._fields)})
    (said,) = unlearnt(learnt(dataset, law.converter), law.converter)
    others = ", ".join(mount for k, mount in enumerate(law.mounts) if k != 1)
    assert said.startswith(f"nothing was learnt of {others}: ")
    assert "below 0.004 mA" in said
    assert unlearnt({}, law.converter) == []


def test_a_run_on_a_floor_that_rests_says_that_nothing_was_learnt() -> None:
    summary = simulate(parse_scenario({**TABLE, "duration": 0.05, "ground": {"kind": "rest"}})).summary
    told = brief(summary)
    assert all(told[mount] == "learnt: nothing" for mount in summary.learnt)
    assert any(one.startswith("nothing was learnt of ") for one in summary.warnings)
