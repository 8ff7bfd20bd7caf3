"""Runs of tests that are too long for memory side by side are stepped in parts."""

import pytest

from ehamj import growing
from ehamj.identification.residual import Failed
from ehamj.identification.runs import beside, histories, with_step
from ehamj.run.budget import size_of
from ehamj.scenario.load import parse_scenario


def test_long_runs_are_stepped_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    one = with_step(parse_scenario({"duration": 0.02, "engine": "small-motion", "compare": []}))
    many = [one.varied({"machine.mass": 4000.0 + 100.0 * k}) for k in range(5)]
    name = "stroke front-left"
    whole = histories(many, [name], 1)
    monkeypatch.setattr(growing, "IN_MEMORY", 2.5 * size_of(one))
    assert beside(many) == 2
    parts = histories(many, [name], 1)
    for before, after in zip(whole, parts, strict=True):
        assert not isinstance(before, Failed)
        assert not isinstance(after, Failed)
        assert (before[name] == after[name]).all()
