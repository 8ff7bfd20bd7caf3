"""Margins without end, presets of named designs, lists, and searches that end early: what is chosen and shown."""

import numpy as np
import pandas as pd
import pytest

import ehamj
from ehamj.campaign.best import best_of
from ehamj.campaign.plans.optimise import as_numbers
from ehamj.campaign.plans.plan import Goals, Told, excess
from ehamj.merits.own import Own
from ehamj.scenario.load import load_scenario

SMALL = {"title": "t", "question": "q", "scenario": "benchmark"}


def test_a_margin_without_end_keeps_its_limit_and_is_the_best() -> None:
    margins = np.array([np.inf, 50.0, 30.0, np.nan])
    np.testing.assert_array_equal(excess(margins, 40.0, None), [-np.inf, -10.0, 10.0, np.nan])
    goals = Goals([("margin", -1.0)], [("margin", 40.0, None)])
    objectives, violations = as_numbers(Told(-margins[:, None], excess(margins, 40.0, None)[:, None]), goals)
    assert np.argsort(objectives[:3, 0]).tolist() == [0, 1, 2]
    np.testing.assert_array_equal(violations[:, 1] > 0.0, [False, False, False, True])  # only what failed
    assert violations[:3, 0].tolist() == [0.0, 0.0, 0.25]
    assert best_of(-margins[:, None], np.array([True, True, True, True]), 2) == [0, 1]


def test_a_function_is_told_by_what_it_closes_over() -> None:
    def make(factor: float):  # type: ignore[no-untyped-def]
        return lambda scenario: factor * scenario.machine.mass

    assert Own(make(1.0)).digest() == Own(make(1.0)).digest() != Own(make(2.0)).digest()


def test_a_search_that_ends_early_confirms_its_own_designs_and_a_preset_shows_its_values(tmp_path) -> None:  # type: ignore[no-untyped-def]
    """A list of three by one of three has nine designs, of 160 that the search may ask for."""
    study = SMALL | {
        "vary": {
            "actuators.isolator.piston_area": {"values": [0.02, 0.03, 0.04]},
            "machine.mass": {"values": [3000.0, 4000.0, 5000.0]},
        },
        "plan": {"kind": "optimise", "population": 8, "generations": 20},
        "named": {"recommended": {"actuators.isolator.preset": "recommended"}},
        "objectives": {"passive.frequency.heave": "highest"},
        "limits": {"passive.tipping_margin": {"at_least": -1e9}},
        "tolerances": {"number": 5, "vary": {"gravity": {"off": 0.1}}, "merits": ["passive.frequency.heave"]},
        "confirm": {},
    }
    study["set"] = {"gravity": 9.81}
    found = ehamj.run_study(study, tmp_path / "early")
    designs = found.designs.reset_index()
    searched = set(designs.loc[designs["stage"] == "search", "number"])
    assert len(searched) == 9
    for stage in ("tolerance", "confirm"):
        assert set(designs.loc[designs["stage"] == stage, "parent"]) <= searched | {1}
    yields = [answer for answer in found.outcome.answers if answer.startswith("Yield")]
    assert yields
    assert all("100.0 %" in one for one in yields)
    area = found.outcome.tables["best"].to_dataframe().reset_index()
    shown = area[area.astype(str).apply(lambda row: row.str.contains("recommended").any(), axis=1)].to_string()
    assert f"{2 * load_scenario('benchmark').actuators['isolator'].piston_area:g}" in shown


def test_lists_words_and_numbers_of_one_parameter_make_scenarios(tmp_path) -> None:  # type: ignore[no-untyped-def]
    study = SMALL | {
        "vary": {"machine.cg": {"values": [[0.0, 0.0, 0.6], [0.1, 0.0, 0.6]]}, "timestep": {"values": ["auto", 2e-4]}},
        "plan": {"kind": "grid"},
        "objectives": {"own.cg": "highest"},
        "best": 4,
    }
    found = ehamj.run_study(study, tmp_path / "lists", functions={"cg": lambda scenario: scenario.machine.cg[0]})
    written = [load_scenario(tmp_path / "lists" / f"best-{place}.toml") for place in range(1, 5)]
    assert sorted(str(one.timestep) for one in written) == ["0.0002", "0.0002", "auto", "auto"]
    assert written[0].machine.cg == (0.1, 0.0, 0.6)
    assert isinstance(found.designs, pd.DataFrame)


def test_feet_outside_the_machine_are_no_design(tmp_path) -> None:  # type: ignore[no-untyped-def]
    study = SMALL | {
        "vary": {"footprint.x": {"values": [1.8, 2.6]}},
        "plan": {"kind": "grid"},
        "objectives": {"passive.frequency.upper-about-y": "highest"},
    }
    found = ehamj.run_study(study, tmp_path / "wide")
    search = found.designs[found.designs["stage"] == "search"]
    assert search["status"].tolist() == ["done", "failed"]
    assert "lies outside the machine" in search["reason"].iloc[1]


def test_a_slow_law_has_what_lies_below_its_rate() -> None:
    from ehamj.merits.catalogue import SOURCES
    from ehamj.merits.merit import Design, Machine

    scenario = load_scenario(
        "benchmark",
        ["control={kind='feedforward', rate=700.0}", "ground={kind='broadband', level='VC-C'}", "duration=2"],
    )
    names = ["loop.voltage.rms", "loop.attenuation.z.10", "loop.attenuation.z.315"]
    (found,) = SOURCES["loop"].evaluate(Machine(scenario), [Design(0, {})], names)
    assert isinstance(found, dict)
    assert found["loop.voltage.rms"] > 0.0
    assert found["loop.attenuation.z.10"] > 3.0
    assert np.isnan(found["loop.attenuation.z.315"])


def test_a_first_key_of_what_is_set_may_be_dotted(tmp_path) -> None:  # type: ignore[no-untyped-def]
    from ehamj.campaign.file import load_study

    plan = {"vary": {"gravity": {"low": 9.0, "high": 10.0}}, "plan": {"kind": "grid", "levels": 2}}
    found = load_study(SMALL | plan | {"set": {"machine.mass": 5000.0}})
    assert found.machine.scenario.machine.mass == pytest.approx(5000.0)
