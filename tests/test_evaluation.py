"""What a result says beyond its summary is computed once, whoever asks, and by no page."""

from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from ehamj import evaluation
from ehamj.control import Controller
from ehamj.evaluation import evaluate
from ehamj.pages import render
from ehamj.report import Shown, report_page
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

BASE: dict[str, Any] = {"name": "a machine", "duration": 2.0, "plates": "tied", "compare": ()}
FLOOR = {"kind": "broadband", "level": "VC-C", "axes": ("z",)}
WORK = ("linear_model", "modes", "rigid_floor", "by_welch", "rocking_modes")


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    damped = Controller(
        np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((4, 0)), -100.0 * np.ones((4, 1)), ("machine_velocity z",)
    )
    passive = simulate(parse_scenario({**BASE, "ground": FLOOR}))
    return {"damped": simulate(parse_scenario({**BASE, "ground": FLOOR}), controller=damped), "passive": passive}


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often each analysis was called."""
    counted: Counter[str] = Counter()
    for name in WORK:
        compute = getattr(evaluation, name)

        def once_more(*args: Any, name: str = name, compute: Any = compute, **settings: Any) -> Any:
            counted[name] += 1
            return compute(*args, **settings)

        monkeypatch.setattr(evaluation, name, once_more)
    return counted


def test_pages_of_several_results_analyse_each_once(results: dict[str, Result], calls: Counter[str]) -> None:
    """One machine under two controls: its linear model, held modes and map once; closed loops and spectra once each."""
    shown = Shown.of(results)
    with ThreadPoolExecutor() as pool:
        list(pool.map(lambda one: render(report_page(one)), [shown, shown.only("damped"), shown.only("passive")]))
    assert calls == {"linear_model": 1, "modes": 2, "rigid_floor": 2, "by_welch": 2, "rocking_modes": 1}


def test_nothing_is_computed_before_it_is_asked_for(results: dict[str, Result], calls: Counter[str]) -> None:
    found = evaluate(results)
    assert calls == {}
    assert found["damped"].machine is found["passive"].machine
    assert found["passive"].modes is None  # nothing is fed back
    assert calls == {"linear_model": 1}


def test_a_passive_run_answers_as_its_machine(results: dict[str, Result]) -> None:
    """And measured from the run by Welch it is what the linear machine says, where the floor moves: vertically."""
    found = evaluate(results)["passive"]
    assert found.transfer is found.machine.transfer
    assert set(found.measured) == {"z"}
    measured, linear = found.measured["z"].estimate, found.transfer
    k = int(np.argmin(abs(measured.frequency - 20.0)))
    expected = linear.response[np.argmin(abs(linear.frequency - measured.frequency[k])), 2, 2]
    assert abs(measured.response[k, 0, 0]) == pytest.approx(abs(expected), rel=0.15)


def test_a_machine_under_a_load_that_is_held_is_not_linear() -> None:
    """A load that its membranes cannot carry leaves no rest to linearise about: everything linear is left out."""
    result = simulate(parse_scenario({**BASE, "duration": 0.1}))
    found = evaluate({"run": result})["run"]
    vars(found.machine)["model"] = None
    assert (list(found.machine.modes), found.transfer, found.modes) == ([], None, None)
    sections = {section.id: section for section in report_page(Shown({"run": result}, {"run": found})).sections}
    assert "modes" not in sections
    assert sections["transmissibility"].figures == []
