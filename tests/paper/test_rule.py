"""The paper's rule: its map against whole designs, its curves against what theory says of their ends."""

import numpy as np
import pytest
import xarray as xr

from ehamj.errors import InputError
from ehamj.isolator.presets import FIRST_GENERATION, RECOMMENDED
from ehamj.paper.merits import figures_of_merit
from ehamj.paper.rule import RuleStudy, paper_marks, rule_chart, rule_curves, rule_map, rule_maps


@pytest.fixture(scope="module")
def curves() -> xr.Dataset:
    return rule_curves(RuleStudy(damping=(0.1, 0.2, 0.3, 0.7)), points=41)


def test_map_is_the_loop_at_each_place() -> None:
    study = RuleStudy(points=9)
    found = rule_map((0.2,), study)
    for load, valve in ((0, 0), (3, 7), (8, 1)):
        here = found.isel(damping=0, load_hz=load, valve_hz=valve)
        ratio = float(here.load_hz / here.valve_hz)
        bandwidth, crossover = study.reach(ratio, 0.2)
        # The map takes powers of the grid's step for the ratio.
        assert float(here.bandwidth) == pytest.approx(bandwidth * float(here.valve_hz), rel=1e-11)
        assert float(here.gain_crossover) == pytest.approx(crossover * float(here.valve_hz), rel=1e-11)
    assert found.bandwidth.attrs["units"] == "Hz"


@pytest.mark.parametrize("design", [FIRST_GENERATION, RECOMMENDED])
def test_map_is_the_figures_of_merit_without_membrane(design: object) -> None:
    assert isinstance(design, type(FIRST_GENERATION))
    bare = design.with_values({"membrane_stiffness": 0.0, "membrane_damping": 0.0})
    found, whole = figures_of_merit(bare), figures_of_merit(design)
    bandwidth, crossover = RuleStudy().reach(1.0 / found.valve_ratio, found.delta_h)
    assert bandwidth * found.valve_hz == pytest.approx(found.bandwidth_hz, rel=1e-10)
    assert found.gain_crossover_hz is not None
    assert crossover * found.valve_hz == pytest.approx(found.gain_crossover_hz, rel=1e-10)
    assert 1.0 <= whole.bandwidth_hz / found.bandwidth_hz < 1.09  # what the map's docstring promises


def test_bandwidth_is_limited_by_the_lesser_frequency(curves: xr.Dataset) -> None:
    """The paper's rule: where the two are ten times apart the bandwidth is at most 5 % above the lesser one."""
    for ratio in (0.1, 10.0):
        reached = curves.bandwidth.sel(ratio=ratio, method="nearest")
        assert float(reached.max()) < 1.05
    valve_limited = curves.bandwidth.sel(ratio=10.0, method="nearest")
    np.testing.assert_allclose(valve_limited, 1.0, atol=0.05)


def test_a_slow_lightly_damped_load_allows_far_less(curves: xr.Dataset) -> None:
    """Behind a fast valve Merritt's limit with 6 dB is a velocity gain of δ_hω_h, and the bandwidth about that."""
    for damping in (0.1, 0.2):
        reached = curves.gain_crossover.sel(damping=damping, ratio=0.1, method="nearest")
        assert float(reached) == pytest.approx(damping, rel=0.05)  # valve and resonance add a little


def test_where_the_frequencies_meet_the_loop_reaches_less(curves: xr.Dataset) -> None:
    """Against a load three times as fast as the valve, where they meet, the gain crossover is well below."""
    crossover = curves.gain_crossover
    meeting, apart = crossover.sel(ratio=1.0, method="nearest"), crossover.sel(ratio=3.2, method="nearest")
    assert bool((meeting < 0.66 * apart).all())


def test_marks_are_the_papers_designs() -> None:
    first, slow, recommended, fast = paper_marks().values()
    assert (first.valve_hz, slow.valve_hz, recommended.valve_hz, fast.valve_hz) == pytest.approx(
        (250.03, 100.0, 250.03, 400.0), abs=0.005
    )
    assert recommended.omega_h_hz == fast.omega_h_hz == pytest.approx(724.5, abs=0.05)


def test_figures_show_the_designs_and_take_other_studies() -> None:
    study = RuleStudy(points=15, damping=(0.2, 0.4))
    marks = paper_marks()
    assert [len(drawn.axes) for drawn in rule_maps(study, marks)] == [1, 1]  # the prototype's damping, and the other
    (legend,) = rule_maps(study, marks)[0].legends
    assert "first prototype, valve at ±5 %: 232 Hz" in [text.get_text() for text in legend.get_texts()]
    bare, marked = rule_chart(study, {}).axes, rule_chart(study, marks).axes
    assert [len(after.lines) - len(before.lines) for before, after in zip(bare, marked, strict=True)] == [4, 4]


def test_what_is_not_physical_is_refused() -> None:
    with pytest.raises(InputError, match=r"hertz = .* rising"):
        RuleStudy(hertz=(100.0, 10.0))
    with pytest.raises(InputError, match=r"damping = 0.0"):
        RuleStudy(damping=(0.0,))
    with pytest.raises(InputError, match=r"damping = -1.0"):
        rule_map((-1.0,))
    with pytest.raises(InputError, match="points = 1"):
        RuleStudy(points=1)
