"""What a study says of designs whose answers are known: best, front, yields, limits that nothing keeps, failures."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from ehamj.campaign.file import StudyFile, load_study
from ehamj.campaign.influence import rank_correlations
from ehamj.campaign.outcome import outcome_of
from ehamj.campaign.studied import Studied, studied_of
from ehamj.plots import svg

MASS, AREA = "machine.mass", "actuators.isolator.piston_area"
STIFF, GAIN = "actuator.isolator.static_stiffness", "actuator.isolator.velocity_gain"
UNITS = {MASS: "kg", AREA: "m²", STIFF: "N/m", GAIN: "m/s/V", "seconds": "s"}


def file_of(**more: Any) -> StudyFile:
    table = {
        "title": "A study",
        "question": "Which?",
        "vary": {MASS: {"low": 3000.0, "high": 5000.0}, AREA: {"low": 0.01, "high": 0.03}},
        "plan": {"kind": "monte-carlo", "number": 10},
        "merits": [STIFF, GAIN],
    }
    return load_study(table | more)


def designs(rows: list[Mapping[str, Any]]) -> pd.DataFrame:
    """A frame as the store gives it."""
    common = {"stage": "search", "parent": None, "status": "done", "reason": None, "seconds": 0.0, MASS: 4000.0,
              AREA: 0.02, STIFF: np.nan, GAIN: np.nan}  # fmt: skip
    found = pd.DataFrame([{**common, **row} for row in rows]).astype({"parent": "Int64"})
    found.index.name = "number"
    found.attrs["units"] = UNITS
    return found


def studied(rows: list[Mapping[str, Any]], complete: bool = True, **more: Any) -> Studied:
    own = {"stage": "named", STIFF: 2.0, GAIN: 2.0, MASS: None}
    return studied_of(file_of(**more), designs([own, *rows]), {MASS: 4000.0, AREA: 0.02}, len(rows) + 1, complete)


def searched(stiff: list[float], gain: list[float], **more: Any) -> list[dict[str, Any]]:
    return [{STIFF: s, GAIN: g, **more} for s, g in zip(stiff, gain, strict=True)]


BOTH = {STIFF: "highest", GAIN: "lowest"}


def test_the_best_design_is_named_with_its_values() -> None:
    found = outcome_of(studied(searched([1.0, 5.0, 3.0], [1.0, 1.0, 1.0]), objectives={STIFF: "highest"}))
    assert found.answers[0] == "Design 2 is the best, its static stiffness 5.00 N/m the highest of 3 designs."
    assert "piston area 0.0200 m²" in found.answers[1]
    assert [one["number"] for one in found.numbers["best"]] == [2, 3, 1]


def test_the_front_is_told_and_what_beats_a_design_in_everything() -> None:
    rows = searched([1.0, 3.0, 4.0, 3.5], [0.5, 1.0, 3.0, 3.5])
    found = outcome_of(studied(rows, objectives=BOTH))
    assert found.numbers["front"] == [3, 2, 1]
    beating = next(answer for answer in found.answers if "the scenario's own design" in answer)
    assert beating.startswith("1 of the 3 on the front beats")
    assert "design 2: static stiffness 3.00 N/m instead of 2.00" in beating
    assert {"pareto-front"} <= set(found.drawings)


def test_a_limit_that_nothing_keeps_names_the_nearest_and_by_how_much() -> None:
    found = outcome_of(studied(searched([1.0, 5.0], [1.0, 2.0]), limits={STIFF: {"at_least": 7.0}}))
    assert found.answers[0] == "No design of 2 keeps all limits."
    assert found.answers[1] == (
        "Nothing keeps static stiffness at least 7 N/m; design 2 comes nearest with 5.00 N/m, which misses it by "
        "2.00 N/m."
    )
    assert found.numbers["good"] == 0


def test_limits_that_are_never_kept_together_are_told_apart_from_those() -> None:
    limits = {STIFF: {"at_least": 4.0}, GAIN: {"at_most": 1.5}}
    found = outcome_of(studied(searched([1.0, 5.0, 3.9], [1.0, 2.0, 1.5]), limits=limits))
    assert "Each limit is kept by some designs, but by none together" in found.answers[1]
    assert "design 3 comes nearest and misses static stiffness at least 4 N/m by 0.100 N/m" in found.answers[1]


def test_a_yield_has_its_exact_interval() -> None:
    """Of 10 machines 8: from 44.4 to 97.5 % (Clopper and Pearson, 1934, table)."""
    rows = searched([5.0] * 8 + [1.0] * 2, [1.0] * 10)
    found = outcome_of(studied(rows, limits={STIFF: {"at_least": 4.0}}))
    told = found.numbers["yield"]["as it is"]
    assert (told["share"], told["machines"]) == (0.8, 10)
    assert (told["low"], told["high"]) == pytest.approx((0.444, 0.975), abs=5e-4)
    assert "Yield: 80.0 % (44.4 to 97.5 %) of 10 machines" in found.answers[0]


def test_machines_that_failed_keep_no_limit_and_are_counted_by_reason() -> None:
    failed = [{"status": "failed", "reason": f"unstable at {k}.5 Hz"} for k in range(3)]
    failed.append({"status": "failed", "reason": "tips over"})
    found = outcome_of(studied([*searched([5.0] * 4, [1.0] * 4), *failed], limits={STIFF: {"at_least": 4.0}}))
    assert found.numbers["yield"]["as it is"]["share"] == 0.5
    assert found.answers[-1] == "4 of 9 designs failed: 3× unstable at … Hz; 1× tips over."
    assert found.tables["failures"]["designs"].values.tolist() == [3, 1]


def test_machines_around_a_design_belong_to_it() -> None:
    around = [{"stage": "tolerance", "parent": 2, STIFF: s, GAIN: 1.0} for s in (4.5, 4.6, 3.0)]
    more: Any = {"objectives": {STIFF: "highest"}, "limits": {STIFF: {"at_least": 4.0}}}
    found = outcome_of(studied([*searched([1.0, 5.0], [1.0, 1.0]), *around], **more))
    assert found.numbers["yield"]["design 2"]["share"] == pytest.approx(2 / 3)
    assert "spread-design-2" in found.drawings


def test_a_rank_correlation_has_fishers_interval() -> None:
    """Ranks that agree but for neighbours, against scipy's own and a bootstrap's width."""
    rng = np.random.default_rng(0)
    mass = rng.uniform(3000.0, 5000.0, 300)
    rows = [{MASS: m, STIFF: m + e, GAIN: 1.0, AREA: a} for m, e, a in
            zip(mass, 800.0 * rng.normal(size=300), rng.uniform(0.01, 0.03, 300), strict=True)]  # fmt: skip
    one = studied(rows)
    found = rank_correlations(one, STIFF)
    assert found is not None
    k = found.parameters.index(MASS)
    ranks = np.array([one.done[MASS].rank(), one.done[STIFF].rank()])
    assert found.measures[0].values[k] == pytest.approx(np.corrcoef(ranks)[0, 1])
    draws = [np.corrcoef(ranks[:, rng.integers(0, 300, 300)])[0, 1] for _ in range(2000)]
    low, high = np.percentile(draws, [2.5, 97.5])
    assert found.measures[0].low is not None
    assert found.measures[0].high is not None
    assert found.measures[0].low[k] == pytest.approx(low, abs=0.03)
    assert found.measures[0].high[k] == pytest.approx(high, abs=0.03)
    assert rank_correlations(one, GAIN) is None  # it never changes


def test_a_study_that_is_not_finished_says_so_and_shows_what_there_is() -> None:
    found = outcome_of(studied(searched([1.0, 5.0], [1.0, 1.0]), complete=False, objectives=BOTH))
    assert any("not finished" in answer and "--resume" in answer for answer in found.answers)


def test_a_study_of_which_nothing_is_done_has_answers_and_no_figures() -> None:
    found = outcome_of(studied([{"status": "failed", "reason": "tips over"}], objectives=BOTH))
    assert found.answers == ("1 of 2 designs failed: 1× tips over.",)
    assert not found.drawings


def test_every_figure_can_be_drawn_and_names_units(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    mass, area = rng.uniform(3000.0, 5000.0, 80), rng.uniform(0.01, 0.03, 80)
    rows = [
        {MASS: m, AREA: a, STIFF: m * a, GAIN: a / m if k % 9 else np.nan}
        for k, (m, a) in enumerate(zip(mass, area, strict=True))
    ]
    rows += [{"stage": "tolerance", "parent": 0, STIFF: s, GAIN: 1e-6} for s in rng.normal(80.0, 1.0, 30)]
    found = outcome_of(studied(rows, objectives=BOTH, limits={STIFF: {"at_least": 60.0, "at_most": 120.0}}))
    kinds = {name.split("-")[0] for name in found.drawings}
    assert kinds == {"pareto", "influence", "spread", "surface", "scatter"}
    for name, drawing in found.drawings.items():
        figure = drawing.draw()
        text = svg(figure, name)
        assert "N/m" in text or "m/s/V" in text or name.startswith("influence"), name
        named = [label for axes in figure.axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
        assert named, name
        assert all("[" in label for label in named), name
        assert drawing.caption.endswith(".")
