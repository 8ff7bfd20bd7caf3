"""Statistics of a run's levels: verdicts that do not depend on when a strike comes, and what stands beside them."""

from typing import Any

import numpy as np
import pytest
from scipy import signal

from ehamj.criteria.settings import CriteriaSettings
from ehamj.estimate.bands import bands
from ehamj.ground.synthetic import HalfSine
from ehamj.judge import Summary, isolation
from ehamj.judge.isolation import Isolation
from ehamj.plant.mounts import MOUNTS
from ehamj.result import Result, load_result, make_dataset
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

RATE = 1000.0
TIMES = np.arange(20001) / RATE
VC = CriteriaSettings(norms=("vc",))


def judged(floor: np.ndarray, machine: np.ndarray, criteria: CriteriaSettings = VC) -> tuple[Isolation, list[str]]:
    """What is said of a rigid floor and a machine that move along z, (time,) each [m/s]."""
    along = np.array([0.0, 0.0, 1.0])
    values = {
        "ground_velocity": np.repeat((floor[:, None] * along)[:, None], len(MOUNTS), axis=1),
        "foot_velocity": np.zeros((floor.size, len(MOUNTS), 3)),
        "cg_velocity": machine[:, None] * along,
        "machine_velocity": np.zeros((floor.size, 6)),
    }
    dataset = make_dataset(TIMES, values, {}, {"mount": list(MOUNTS)})
    return isolation(dataset, parse_scenario({}).plant, RATE, norms=criteria.chosen())


def strike(begin: float) -> tuple[np.ndarray, np.ndarray]:
    """A half-sine of the floor, and a machine on mounts of 4 Hz and 20 % damping that it strikes."""
    floor = HalfSine(0.5e-3, 0.015, 0.5, begin).sample(TIMES).slope
    omega = 2 * np.pi * 4.0
    mounts = ([2 * 0.2 * omega, omega**2], [1.0, 2 * 0.2 * omega, omega**2])
    return floor, signal.lsim(mounts, floor, TIMES)[1]


STRIKES = (1.0, 3.0, 7.0, 12.3, 19.0)


@pytest.fixture(scope="module")
def struck() -> list[Isolation]:
    return [judged(*strike(begin))[0] for begin in STRIKES]


@pytest.mark.parametrize("statistic", ["rms", "max_1s"])
@pytest.mark.parametrize("place", ["floor", "machine"])
def test_moving_a_strike_moves_no_level(statistic: Any, place: str, struck: list[Isolation]) -> None:
    levels = np.array([list(found.in_bands("velocity", statistic)[place]["z"].values()) for found in struck])
    # 0.3 dB are asked for; the machine's swing after the last strike is cut off with the run.
    np.testing.assert_allclose(20 * np.log10(levels / levels[2]), 0.0, atol=0.2)


def test_moving_a_strike_moves_no_verdict(struck: list[Isolation]) -> None:
    for one in struck:
        judged, beside = one.criterion, one.criterion.max_1s
        assert beside is not None
        assert (judged.floor.z.met, judged.machine.z.met) == ("VC-D", "VC-E")
        assert (beside.floor.z.met, beside.machine.z.met) == ("VC-B", "VC-C")
        assert one.floor_transient is True


def test_a_transient_floor_is_said_in_words_beside_the_class_by_its_largest_second() -> None:
    found, (words,) = judged(*strike(7.0))
    strongest = found.transience
    assert strongest is not None
    assert words.startswith(f"the floor is transient: along z in the {strongest.band} Hz band its largest second is ")
    assert strongest.max_1s == found.in_bands("velocity", "max_1s")["floor"]["z"][strongest.band]
    # One second in nineteen holds it all: √18.9 times the run's RMS.
    assert strongest.max_1s / strongest.rms == pytest.approx(np.sqrt(18.9), rel=0.01)


def test_the_statistic_that_judges_is_the_users_and_each_verdict_says_it() -> None:
    loud = np.where((TIMES > 8.0) & (TIMES < 11.0), 10e-6, 2e-6) * np.sqrt(2) * np.sin(2 * np.pi * 20.0 * TIMES)
    # RMS of the run: √((3·10² + 16·2²)/19) = 4.4 µm/s.
    expected = {"rms": "VC-D", "max_1s": "VC-C", "slow": "VC-C", "fast": "VC-C", "l10": "VC-C", "l50": "VC-E"}
    for statistic, met in {**expected, "l90": "VC-E"}.items():
        criteria = CriteriaSettings(norms=("vc", "nist-a"), statistic=statistic)
        found, _ = judged(loud, loud, criteria)
        verdict = found.criterion.floor.z
        assert (verdict.met, verdict.statistic, verdict.deciding_band) == (met, statistic, "20"), statistic
        assert found.criteria["nist-a"].places["machine"].z.statistic == statistic
        assert found.criterion.max_1s is not None
        assert (found.criterion.max_1s.floor.z.met, found.criterion.max_1s.floor.z.statistic) == ("VC-C", "max_1s")
        assert set(found.in_bands("displacement", statistic)) == {"floor", "feet", "machine"}


def test_a_level_exactly_at_the_limit_meets_the_class_by_any_statistic() -> None:
    """Whatever reads it: scaled so that the band's level is the limit's double, the class is met, above it is not."""
    (band,) = bands(20.0, 20.0)
    wave = np.sin(2 * np.pi * 20.0 * TIMES)
    for statistic in ("rms", "max_1s"):
        criteria = CriteriaSettings(norms=("vc",), statistic=statistic)
        level = judged(wave, wave)[0].in_bands("velocity", statistic)["floor"]["z"][band.name]  # type: ignore[arg-type]
        assert level is not None
        for factor, met in ((1.0 - 1e-12, "VC-D"), (1.0 + 1e-12, "VC-C")):
            scaled = wave * (factor * 6.25e-6 / level)
            assert judged(scaled, scaled, criteria)[0].criterion.floor.z.met == met


def test_the_averaging_time_of_each_band_is_stated() -> None:
    found = judged(*strike(7.0))[0].levels
    assert found is not None
    assert found.averaging_s["fast"]["100"] == 0.125
    assert found.averaging_s["max_1s"]["1"] == pytest.approx(1.0 / 0.23077, rel=1e-4)
    assert found.peak["floor"]["z"] == pytest.approx(0.5e-3, rel=0.01)  # rows of 1 ms beside the crest of 15 ms


@pytest.fixture(scope="module")
def run() -> Result:
    floor = {"kind": "broadband", "level": "VC-A"}
    return simulate(parse_scenario({"plates": "tied", "duration": 3.0, "seed": 7, "ground": floor}))


def test_levels_of_a_run_are_stored_and_loaded(run: Result, tmp_path: Any) -> None:
    run.write(tmp_path)
    summary = load_result(tmp_path).summary
    assert summary == run.summary
    assert summary["statistic"] == "rms"
    assert set(summary["levels"]["velocity"]) == {"max_1s", "slow", "fast", "l10", "l50", "l90"}
    assert set(summary["levels"]["velocity"]["max_1s"]) == {"floor", "feet", "machine", "spindle-nose"}
    assert summary["criterion"]["max_1s"]["machine"]["z"]["statistic"] == "max_1s"


def test_a_summary_that_is_older_is_read(run: Result) -> None:
    older = run.summary.to_dict()
    for key in ("statistic", "levels", "floor_transient", "transience"):
        older.pop(key, None)
    del older["criterion"]["max_1s"]
    for norm in older["criteria"].values():
        for place in norm["places"].values():
            for axis in "xyz":
                del place[axis]["statistic"]
    read = Summary.read(older, "summary.json")
    assert (read.levels, read.floor_transient, read.criterion.max_1s) == (None, None, None)
    assert read.in_bands("velocity", "max_1s") == {}
    assert read.in_bands("velocity") == run.summary.third_octave_velocity
