"""Errors of integration are told where they matter: beside a machine that was stepped four times as finely."""

from typing import Any

import numpy as np
import pytest
from draws.machines import drawn
from draws.trial import ASIDE, KINDS, believed, file_of, measured

from ehamj.identification.file import load_identify
from ehamj.identification.fit import Fitted
from ehamj.identification.identify import prepared
from ehamj.identification.noise import Noise
from ehamj.identification.outcome import Identified
from ehamj.identification.problem import Linearised, Problem
from ehamj.identification.residual import Failed
from ehamj.identification.stepping import coarse, moved_by_steps

KIND = KINDS["few"]
MACHINE = drawn(1, 0, KIND.keys, False)
NOISE = 1e-3
"""That channels would have to have, over themselves, for these values to be as uncertain as errors of steps are."""


@pytest.fixture(scope="module")
def asked(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("measured")
    measured(believed(MACHINE.table), folder, (1, 0), KIND.leak)
    return file_of("few", folder)


@pytest.mark.parametrize(("step", "told"), [(2.5e-4, True), (5e-5, False)])
def test_steps_that_move_a_value_are_told(step: float, told: bool, asked: dict[str, Any]) -> None:
    own = {"timestep": step}
    problem, fine = (_problem({**asked, "set": {**own, "timestep": one}}) for one in (step, step / 4.0))
    point = np.array([one.scaled(MACHINE.values.get(one.name, ASIDE)) for one in problem.unknowns])
    at, (beside,) = problem.linearised(point), fine.compared([point])
    assert isinstance(at, Linearised)
    assert not isinstance(beside, Failed)
    sizes = [NOISE * float(np.std(one.measured)) for one in at.compared]
    noise = tuple(Noise(np.full(one.at.size, size)) for one, size in zip(at.compared, sizes, strict=True))
    fit = Fitted(at, noise, 0.0, 0, "")
    off = [(own.predicted - one.predicted) / size for own, one, size in zip(beside, at.compared, sizes, strict=True)]
    slopes = np.concatenate([own / size for own, size in zip(at.slopes, sizes, strict=True)])
    expected = np.linalg.lstsq(slopes, np.concatenate(off), rcond=None)[0]
    moved = moved_by_steps(problem, fit)
    spread = np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))
    assert moved / spread == pytest.approx(expected / spread, abs=0.1 * float(np.abs(expected / spread).max()))
    found = {
        one.name: Identified(
            one.value(z), one.slope(one.value(z)) * float(size), "", 1.0, (0.0, 2.0), "", "identified", ""
        )
        for one, z, size in zip(problem.parameters, point, spread, strict=False)
    }
    assert bool(list(coarse(problem, fit, found))) == told


def _problem(asked: dict[str, Any]) -> Problem:
    parameters, tests = prepared(load_identify(asked, ()), {}, None)
    return Problem(tests, parameters)
