"""Merits of closed loops at once against reports and responses of one loop at a time."""

import numpy as np
import pytest
from slycot import ab13md

from ehamj.compiled.kept import compiled
from ehamj.designs.compiled.structured import largest_mus
from ehamj.merits.applied import scenario_of
from ehamj.merits.catalogue import SOURCES
from ehamj.merits.loop import LoopSource
from ehamj.merits.merit import Design, Failed, Machine
from ehamj.scenario.load import load_scenario

HELD = Machine(load_scenario("vc-c-floor", ["control.kind='combined'", "compare=[]", "duration=8"]))
CORE = [
    "loop.gain_margin",
    "loop.phase_margin",
    "loop.disk_margin",
    "loop.disk_margin_all_valves",
    "loop.stable",
    "loop.attenuation.z.10",
    "loop.attenuation.x.100",
    "loop.peak.y",
    "loop.voltage.rms",
    "loop.flow.rms",
    "loop.flow.drawn",
    "loop.power",
]


def source() -> LoopSource:
    found = SOURCES["loop"]
    assert isinstance(found, LoopSource)
    return found


def drawn(number: int) -> list[Design]:
    """Some of them unstable, and some nearly."""
    random = np.random.default_rng(5)
    ends = {
        "machine.mass": (3300.0, 4700.0), "footprint.x": (1.5, 2.0), "actuators.isolator.flow_gain": (1.5e-6, 6e-6),
        "mount.rear-left.actuator.bulk_modulus": (4e8, 9e8),
    }  # fmt: skip
    return [Design(k, {key: float(random.uniform(*one)) for key, one in ends.items()}) for k in range(number)]


@pytest.fixture(scope="module")
def found() -> list[dict[str, float]]:
    rows = source().evaluate(HELD, drawn(24), list(source().merits(HELD)))
    assert not any(isinstance(row, Failed) for row in rows)
    return [dict(row) for row in rows]  # type: ignore[call-overload]


def test_margins_are_those_of_the_report(found: list[dict[str, float]]) -> None:
    """Grids differ by 0.2 % about poles: margins by less than 0.02 dB, 0.02° and 0.001."""
    assert {row["loop.stable"] for row in found} == {0.0, 1.0}
    for k in (0, 9, int(np.argmin([row["loop.disk_margin"] for row in found]))):
        one = source().alone(HELD, scenario_of(HELD, drawn(24)[k].values), list(found[k]))
        assert not isinstance(one, Failed)
        assert found[k]["loop.stable"] == one["loop.stable"]
        allowed = {"gain_margin": 0.02, "phase_margin": 0.02, "disk_margin": 1e-3, "disk_margin_all_valves": 1e-3}
        for name, value in found[k].items():
            kind = name.split(".")[1]
            if kind in allowed:
                assert value == pytest.approx(one[name], abs=allowed[kind]), name
            elif kind in ("attenuation", "peak"):
                assert value == pytest.approx(one[name], abs=1e-4), name
            else:
                assert value == pytest.approx(one[name], rel=1e-6), name


def test_stability_is_that_of_eigenvalues(found: list[dict[str, float]]) -> None:
    """Turns of the determinant against the sampled loop's eigenvalues, for every third design."""
    own = source().held(HELD.scenario)
    for design, row in list(zip(drawn(24), found, strict=True))[::3]:
        assert row["loop.stable"] == float(source()._is_stable(own, scenario_of(HELD, design.values)))


def test_a_loop_is_the_same_to_the_bit_in_any_company(found: list[dict[str, float]]) -> None:
    many = drawn(24)
    company = [many[17], many[4], Design(99, {**many[0].values, "machine.mass": -2.0})]
    rows = source().evaluate(HELD, company, CORE)
    for row, k in zip(rows, (17, 4), strict=False):
        assert row == {name: found[k][name] for name in CORE}
    assert isinstance(rows[2], Failed)


def test_a_law_that_is_derived_anew_is_computed_one_at_a_time() -> None:
    derived = Machine(HELD.scenario, "derived")
    assert source().notes(derived) == [
        "computed one design at a time from the differentiated model: the law is derived anew for each design"
    ]
    values = {"actuators.isolator.flow_gain": 2.4e-6}
    names = ["loop.gain_margin", "loop.stable"]
    held, anew = (source().evaluate(one, [Design(0, values)], names)[0] for one in (HELD, derived))
    assert not isinstance(held, Failed)
    assert not isinstance(anew, Failed)
    assert anew["loop.gain_margin"] > held["loop.gain_margin"] + 1.0


def test_a_passive_machine_has_no_merits_of_a_loop() -> None:
    assert not source().merits(Machine(load_scenario("vc-c-floor", ["control={kind='passive'}", "compare=[]"])))


@pytest.mark.parametrize("n", [1, 3, 4, 6])
def test_the_structured_singular_value_is_slicots(n: int) -> None:
    random, found = np.random.default_rng(n), np.empty(6)
    matrices = random.normal(size=(6, 3, n, n)) + 1j * random.normal(size=(6, 3, n, n))
    compiled(largest_mus)(matrices, np.full(6, 3), found)
    blocks, kinds = np.ones(n, int), np.full(n, 2)
    expected = [max(ab13md(one, blocks, kinds)[0] for one in own) for own in matrices]
    np.testing.assert_allclose(found, expected, rtol=1e-4)
