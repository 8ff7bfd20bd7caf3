"""Errors of integration are told where a step is stated, and taken out where it is not: the machine that was measured
was stepped by another engine, and more finely."""

from typing import Any

import numpy as np
import pytest
from draws import trial
from draws.machines import drawn
from draws.trial import ASIDE, KINDS, believed, file_of, measured

from ehamj.arrays import Array
from ehamj.identification.file import load_identify
from ehamj.identification.fit import Fitted
from ehamj.identification.identify import prepared
from ehamj.identification.noise import Noise
from ehamj.identification.problem import Linearised, Problem
from ehamj.identification.stepping import coarse, moved_by_steps, short_enough

KIND = KINDS["few"]
MACHINE = drawn(1, 0, KIND.keys, False)
NOISE = 1e-3
"""That channels would have to have, over themselves, for these values to be as uncertain as errors of steps are."""


@pytest.fixture(scope="module")
def asked(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Tests without noise."""
    folder = tmp_path_factory.mktemp("measured")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trial, "NOISE", 1e-6)
        patch.setattr(trial, "BITS", 30)
        measured(believed(MACHINE.table), folder, (1, 0), KIND.leak)
    return file_of("few", folder)


@pytest.mark.parametrize(("step", "told"), [(2.5e-4, True), (5e-5, False)])
def test_a_stated_step_that_moves_a_value_is_told(step: float, told: bool, asked: dict[str, Any]) -> None:
    problem, true = _problem({**asked, "set": {"timestep": step}})
    fit = _fit(problem, true)
    off = np.concatenate([of.whitened(one.error) for of, one in zip(fit.noise, fit.at.compared, strict=True)])
    slopes = np.concatenate([of.whitened(own) for of, own in zip(fit.noise, fit.at.slopes, strict=True)])
    spread = np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))
    expected = (np.linalg.lstsq(slopes, off, rcond=None)[0] / spread)[: len(KIND.keys)]
    moved = moved_by_steps(problem, fit)
    assert moved == pytest.approx(expected, abs=0.1 * float(np.abs(expected).max()) + 0.15)
    assert bool(list(coarse(problem, fit))) == told
    assert short_enough(problem, fit, print) is fit


def test_a_step_that_is_not_stated_moves_no_value(asked: dict[str, Any]) -> None:
    problem, true = _problem({**asked, "set": {"timestep": "auto"}})
    there = _fit(problem, true)
    slopes = np.concatenate([of.whitened(own) for of, own in zip(there.noise, there.at.slopes, strict=True)])
    spread = np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))
    off = np.concatenate([of.whitened(one.error) for of, one in zip(there.noise, there.at.compared, strict=True)])
    best = true + np.linalg.lstsq(slopes, off, rcond=None)[0]  # where a fit with these steps ends
    assert np.abs((best - true) / spread)[: len(KIND.keys)].max() > 0.3
    found = short_enough(problem, _fit(problem, best), print)
    assert np.abs((found.point - true) / spread)[: len(KIND.keys)].max() < 0.1
    assert not list(coarse(problem, found))


def _problem(asked: dict[str, Any]) -> tuple[Problem, Array]:
    """The problem, and what is true of it."""
    parameters, tests = prepared(load_identify(asked, ()), {}, None)
    problem = Problem(tests, parameters)
    return problem, np.array([one.scaled(MACHINE.values.get(one.name, ASIDE)) for one in problem.unknowns])


def _fit(problem: Problem, point: Array) -> Fitted:
    at = problem.linearised(point)
    assert isinstance(at, Linearised)
    noise = [Noise(np.full(one.at.size, NOISE * float(np.std(one.measured)))) for one in at.compared]
    return Fitted(at, tuple(noise), 0.0, 0, "")
