"""What a report says of faults: what there is, and a sentence of one that changes nothing."""

from typing import Any

import pytest

from ehamj.judge.faults import NOTHING, WHOLE
from ehamj.report.sections.attenuation import at_places
from ehamj.report.sections.classes import classes
from ehamj.report.sections.faults import LINEAR, faults
from ehamj.report.sections.runs import verdict_in_words
from ehamj.report.shown import Shown
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

TABLE: dict[str, Any] = {
    "name": "hall",
    "duration": 1.6,
    "record_rate": 1000.0,
    "plates": "tied",
    "ground": {"kind": "broadband", "level": "VC-A"},
    "control": {"kind": "feedforward"},
    "fault": [{"kind": "valve-stuck", "mount": "front-left", "time": 0.6, "settling": 2.0}],
}


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    active = parse_scenario(TABLE)
    return {"hall": simulate(active), "hall, passive": simulate(active.variant("passive"))}


def test_only_parts_that_there_are_have_a_column(results: dict[str, Result]) -> None:
    section = faults(Shown.of({"hall": results["hall"]}))
    assert section is not None
    met, numbers = section.tables
    assert [words.partition(",")[0] for words in met.head] == ["", "before", "while it settles"]
    assert numbers.head == [*met.head, LINEAR]
    assert "not settled" in met.note
    assert any(row[-1] for row in numbers.rows)


def test_a_fault_that_changes_nothing_is_a_sentence(results: dict[str, Result]) -> None:
    section = faults(Shown.of({"hall, passive": results["hall, passive"]}))
    assert section is not None
    assert (section.figures, section.tables) == ([], [])
    assert [NOTHING in note for note in section.notes] == [True]
    both = faults(Shown.of(results))
    assert both is not None
    assert len(both.tables) == 2


def test_what_is_of_the_whole_run_says_so_where_something_failed(results: dict[str, Result]) -> None:
    for section in (classes(Shown.of(results)).tables[0], at_places(Shown.of(results))):
        assert WHOLE in section.note
    said = verdict_in_words(results["hall"], "vertical")
    assert said.startswith("before the fault, 0 to 0.6 s: ")
    assert said.endswith("after the fault at front-left at 0.6 s: not settled")
    own = results["hall, passive"]
    assert verdict_in_words(own, "vertical") == own.summary.criterion.briefly()["vertical"]
    assert WHOLE not in at_places(Shown.of({"passive": own})).note
