"""`ehamj verify`: every case passes, a wrong parameter fails the case that it belongs to, and the table says so."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ehamj.verify as verification
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.supply import Supply
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario
from ehamj.settings import PROVENANCE
from ehamj.verify import CASES, Case, CaseOutcome, Finding, Subject, run_case, to_dict, verify, write_table
from ehamj.verify.reference import equations, simulate_reference


@pytest.mark.parametrize("case", CASES.values(), ids=list(CASES))
def test_case_passes(case: Case) -> None:
    outcome = run_case(case)
    assert outcome.passed, f"{outcome.error:.3g} > {case.tolerance:.3g} {case.unit}: {outcome.detail}"


def wrong(name: str, change: Callable[[Any], Any], table: str = "actuator") -> Subject:
    """ehamj with one parameter changed behind the case's back."""

    def altered(scenario: Scenario) -> Scenario:
        if table == "actuator":
            isolator = scenario.actuators["isolator"]
            other = isolator.with_values({name: change(getattr(isolator, name))})
            return scenario.model_copy(update={"actuators": {"isolator": other}})
        part = getattr(scenario, table)
        return scenario.model_copy(update={table: part.with_values({name: change(getattr(part, name))})})

    def run(scenario: Scenario) -> Result:
        return simulate(altered(scenario))

    def linearise(scenario: Scenario) -> LinearModel:
        return linear_model(altered(scenario).plant)

    return Subject(run, linearise)


def by(factor: float) -> Callable[[float], float]:
    return lambda value: value * factor


@pytest.mark.parametrize(
    ("case", "subject"),
    [
        ("chamber compression", wrong("bulk_modulus", by(1.001))),
        ("chamber compression, air and walls", wrong("air_fraction", by(1.01))),
        ("orifice into closed chamber", wrong("flow_gain", by(1.001))),
        ("leak-down", wrong("flow_pressure", by(1.001))),
        ("step of a valve-controlled piston", wrong("membrane_damping", by(1.1))),
        ("valve at ±25 %", wrong("spool_drive_limit", by(1.02))),
        ("valve gain at ±90 %", wrong("spool_drive_limit", by(1.02))),
        ("drive limit of the valve", wrong("spool_drive_limit", by(1.02))),
        ("modes of the default machine", wrong("inertia", lambda j: (j[0] * 1.01, j[1], j[2]), "machine")),
        ("sinking under gravity", wrong("membrane_stiffness", by(1.00001))),
        ("standing under held commands", wrong("null_offset", by(1.01))),
        ("tipping", wrong("cg", lambda r: (r[0], r[1], r[2] * 1.001), "machine")),
        ("benchmark case", wrong("flow_pressure", by(1.01))),
    ],
    ids=lambda entry: entry if isinstance(entry, str) else "",
)
def test_a_wrong_parameter_fails_its_case(case: str, subject: Subject) -> None:
    outcome = run_case(CASES[case], subject)
    assert not outcome.passed
    assert np.isfinite(outcome.error), outcome.detail


def test_a_leak_in_the_books_fails_conservation() -> None:
    """A result whose oil is short by 1e-5 of what moved."""

    def run(scenario: Scenario) -> Result:
        result = simulate(scenario)
        oil = result.dataset["oil_held"]
        oil[-1] += 1e-5 * float(np.abs(np.diff(result.dataset["oil_in"].values, axis=0)).sum(axis=0).max())
        return result

    assert not run_case(CASES["oil is conserved"], Subject(run)).passed


def test_a_failing_simulation_is_a_failing_case() -> None:
    def run(scenario: Scenario) -> Result:
        raise RuntimeError("pump off")

    outcome = run_case(CASES["leak-down"], Subject(run))
    assert not outcome.passed
    assert "pump off" in outcome.detail


def _example(error: float) -> Case:
    return Case("a < b", "x with y", "closed form", "m", 1.0, "because", lambda subject: Finding(error, "detail"))


@pytest.mark.parametrize(("error", "passed"), [(0.5, True), (1.0, True), (1.5, False), (float("nan"), False)])
def test_only_an_error_within_tolerance_passes(error: float, passed: bool) -> None:
    seen: list[CaseOutcome] = []
    outcomes = verify(seen.append, [_example(error)])
    assert [outcome.passed for outcome in outcomes] == [passed]
    assert seen == outcomes


def test_every_file_with_cases_is_in_the_list() -> None:
    room = Path(verification.__file__).parent
    holding = {path.stem for path in room.glob("*.py") if "\n@case(" in path.read_text(encoding="utf-8")}
    assert holding == {case.measure.__module__.rpartition(".")[2] for case in CASES.values()}


def test_every_case_explains_itself() -> None:
    for case in CASES.values():
        assert all((case.compares, case.source, case.unit, case.why))
        assert case.tolerance > 0


def test_the_table_is_one_page_that_names_what_fails(tmp_path: Path) -> None:
    outcomes = verify(cases=[_example(0.5), _example(2.0)])
    page = write_table(outcomes, tmp_path).read_text(encoding="utf-8")
    assert "1 of 2 cases fail" in page
    assert "a &lt; b" in page
    assert "http" not in page
    assert write_table(outcomes, tmp_path / "table.html") == tmp_path / "table.html"


def test_plain_data_is_json() -> None:
    data = json.loads(json.dumps(to_dict(verify(cases=[_example(0.5), _example(float("nan"))])), allow_nan=False))
    assert data["passed"] is False
    assert [entry["error"] for entry in data["cases"]] == [0.5, None]


def test_the_reference_refuses_what_it_does_not_have() -> None:
    scenario = parse_scenario({"actuators": {"isolator": {"foot_stiffness": 1e9}}})
    with pytest.raises(ValueError, match=r"isolator of front-left: .* does not have foot_stiffness = 1000000000\.0"):
        simulate_reference(scenario)


def test_the_reference_knows_every_option_by_name() -> None:
    """A new option is refused by the reference, and named, until its equations are there as well."""
    known = {*equations.OF_ISOLATOR, "flow_curve", *equations.WITHOUT_EFFECT}
    assert set(Actuator.model_fields) - known == {"foot_stiffness", "rated_flow", *PROVENANCE}
    assert set(Supply.model_fields) - set(equations.OF_SUPPLY) == set(PROVENANCE)
