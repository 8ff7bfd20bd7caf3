"""How much worse the data fit where one value is held elsewhere: closed forms, and what a command tells of it."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness import Cli

from ehamj.arrays import Array
from ehamj.identification.fit import Fitted, fitted
from ehamj.identification.problem import Problem
from ehamj.identification.profiles import interval, profile
from ehamj.identification.residual import Compared
from ehamj.identification.statistics import statistics
from ehamj.identification.unknowns import Unknown, Values

TIMES = np.linspace(0.0, 2.0, 41)
SIGMA = 0.05


class Decay:
    """A known test: A e^(−k t), read with an error of a known size, a weight of which is straight in its values."""

    name, held_out, unknowns = "decay", False, ()

    def __init__(self, curved: bool) -> None:
        self.curved = curved
        self.measured = self.at(1.0, 0.8) + SIGMA * np.random.default_rng(4).standard_normal(TIMES.size)

    def at(self, size: float, rate: float) -> Array:
        return size * np.exp(-rate * TIMES) if self.curved else size + rate * TIMES

    def compared(self, batch: Sequence[Values]) -> list[Any]:
        known = np.full(TIMES.size, SIGMA)
        return [
            (Compared("y", "m", "number", TIMES, self.measured, self.at(one["size"], one["rate"]), known),)
            for one in batch
        ]

    def rough(self, batch: Sequence[Values], share: float = 1.0) -> list[Any]:
        return self.compared(batch)

    def found(self, values: Values) -> Mapping[str, Any]:
        return {}


def profiled(test: Decay) -> tuple[Array, float, float]:
    """Profile of the rate, with the value and its deviation."""
    unknowns = [Unknown("size", "m", 1.2, 0.7, 1.3), Unknown("rate", "1/s", 0.7, -2.0, 3.0)]
    problem = Problem([test], unknowns)
    fit = fitted(problem, problem.start, 30)
    assert isinstance(fit, Fitted)
    about = statistics(fit, problem.unknowns, 2)
    value = problem.values(fit.point)["rate"]
    return profile(problem, fit, about.covariance, 1), value, float(np.sqrt(about.covariance[1, 1])) * unknowns[1].scale


def test_a_profile_of_a_straight_model_is_the_parabola_of_its_deviation() -> None:
    rows, value, deviation = profiled(Decay(curved=False))
    np.testing.assert_allclose((rows[:, 0] - value) / deviation, np.arange(-3.0, 4.0), atol=1e-3)
    np.testing.assert_allclose(rows[:, 1], np.arange(-3.0, 4.0) ** 2, rtol=1e-2, atol=1e-3)
    np.testing.assert_allclose(interval(rows), value + np.sqrt(3.84) * deviation * np.array([-1.0, 1.0]), rtol=1e-3)
    assert interval(rows[2:]) == (None, pytest.approx(value + np.sqrt(3.84) * deviation, rel=1e-3))


def test_a_profile_of_a_bent_model_is_that_of_the_best_other_value_in_closed_form() -> None:
    """A e^(−k t) with k held is straight in A, whose best is known."""
    test = Decay(curved=True)
    rows, _, _ = profiled(test)

    def least(rate: float) -> float:
        shape = np.exp(-rate * TIMES)
        left = test.measured - shape * (shape @ test.measured) / (shape @ shape)
        return float(left @ left) / SIGMA**2

    exact = np.array([least(rate) for rate in rows[:, 0]])
    np.testing.assert_allclose(rows[:, 1], exact - exact[3], atol=0.05)
    assert abs(rows[0, 1] - rows[-1, 1]) > 0.2  # it is no parabola


KEY = "actuators.isolator.membrane_stiffness"
RIG = f"""
title = "Rig"
scenario = "benchmark"
parameters = {{ "{KEY}" = {{}} }}
fit = {{ starts = 1, profile = ["{KEY}"] }}

[[test]]
name = "dial gauge"
kind = "static"
load = [{{ force = [0.0, 0.0, 0.0] }}, {{ force = [0.0, 0.0, -4000.0] }}, {{ force = [0.0, 0.0, -8000.0] }}]
reading = {{ "stroke front-left" = [0.0, -1.51e-6, -2.99e-6] }}
deviation = {{ "stroke front-left" = 1e-8 }}

[[test]]
name = "once more"
kind = "static"
load = [{{ force = [0.0, 0.0, 0.0] }}, {{ force = [0.0, 0.0, -6000.0] }}]
reading = {{ "stroke front-left" = [1e-6, -1.25e-6] }}
hold_out = true
"""


def test_a_command_tells_profiles_and_tests_that_were_held_out(cli: Cli) -> None:
    Path("rig.toml").write_text(RIG)
    said = cli("identify", "rig.toml", "--out", "found")
    assert said.code == 0, said.err
    assert "by profile likelihood, 95 %" in said.out
    assert re.search(r"once more +stroke front-left +\d+.* held out", said.out)
    told = json.loads(Path("found", "identification.json").read_text(encoding="utf-8"))
    own, about = told["values"][KEY], told["profiles"][KEY]
    low, high = about["interval_95"]
    assert 0.5 * (high - low) == pytest.approx(1.96 * own["deviation"], rel=0.05)
    assert [round(rise) for rise in about["rise"]] == [9, 4, 1, 0, 1, 4, 9]
    assert told["validation"][0]["channels"][0]["fit_percent"] > 95.0
    page = Path("found", "identification.html").read_text(encoding="utf-8")
    assert "95 % by profile likelihood" in page
    assert "Where it stays below 3.84" in page
