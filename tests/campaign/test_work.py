"""A block's designs are evaluated one like the other, and each fails by itself."""

import math
import pickle
from dataclasses import replace

import pytest
from oracles.fake_studies import NAMES, REFUSED, closed, machine

from ehamj.campaign.rows import Row
from ehamj.campaign.work import LONGEST, Block, Work, evaluate, one_line
from ehamj.errors import InputError
from ehamj.merits.merit import Design
from ehamj.merits.own import Own, owned
from ehamj.scenario.model import Scenario


def block(*masses: float) -> Block:
    designs = tuple(Design(10 + at, {"machine.mass": mass, "machine.cg.2": 0.5}) for at, mass in enumerate(masses))
    return Block("search", designs, (None,) * len(designs))


def reason(row: Row) -> str:
    assert row.failed is not None
    return row.failed.reason


def test_each_design_has_its_merits_or_its_reason_in_one_line() -> None:
    rows = evaluate(Work.of(machine(), NAMES), block(3.0, *REFUSED, 19.0))
    assert [row.number for row in rows] == list(range(10, 15))
    assert rows[0].merits == {f"fake.{name}": one for name, one in closed(3.0, 0.5).items()}
    assert rows[0].failed is None
    for row, said in zip(rows[1:4], REFUSED.values(), strict=True):
        assert said in reason(row)
        assert not row.merits
        assert "\n" not in reason(row)
    assert rows[4].failed is None
    assert math.isnan(rows[4].merits["fake.root"])


def test_work_is_the_same_after_it_was_sent() -> None:
    work = Work.of(machine(), NAMES)
    sent = pickle.loads(pickle.dumps(work))
    assert sent == work
    assert evaluate(sent, block(3.0))[0].merits == evaluate(work, block(3.0))[0].merits


def mass_of(scenario: Scenario) -> float:
    return scenario.machine.mass


def broken(scenario: Scenario) -> float:
    raise KeyError("cost")


def test_own_functions_see_the_designs_scenario() -> None:
    functions = owned({"mass": Own(mass_of, "kg"), "own.broken": broken})
    rows = evaluate(Work.of(machine(), ["own.mass"], functions), block(3900.0, -1.0))
    assert rows[0].merits == {"own.mass": 3900.0}
    assert reason(rows[1]).startswith("own: machine.mass")
    (row,) = evaluate(Work.of(machine(), ["own.broken"], functions), block(3900.0))
    assert reason(row) == "own: own.broken: KeyError: 'cost'"


def test_a_merit_without_a_function_says_how_to_give_it() -> None:
    with pytest.raises(InputError, match=r"run_study\(…, functions=\{'cost': function\}\)"):
        Work.of(machine(), ["own.cost"])


def test_a_function_that_differs_has_another_digest() -> None:
    assert Own(mass_of).digest() == Own(mass_of).digest() != Own(broken).digest()
    assert Own(max).digest() != Own(min).digest()


def test_a_worker_of_other_versions_is_refused() -> None:
    work = Work.of(machine(), NAMES)
    other = replace(work, versions={**work.versions, "numpy": "1.0"})
    with pytest.raises(InputError, match=r"a worker has numpy .* \(the study has 1.0\)"):
        evaluate(other, block(3.0))


def test_a_worker_that_lacks_a_source_is_refused() -> None:
    work = replace(Work.of(machine(), NAMES), modules=("nowhere.to_be_found",))
    with pytest.raises(InputError, match=r"cannot import 'nowhere\.to_be_found'"):
        evaluate(work, block(3.0))


def test_long_reasons_are_cut() -> None:
    assert len(one_line("a\n b" * 1000)) == LONGEST
