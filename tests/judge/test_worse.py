"""An axis that gets worse is found with band and decibel, wherever on the machine; what nobody would measure is not."""

from typing import Any

import numpy as np
import pytest

from ehamj.judge import isolation
from ehamj.judge.isolation import Isolation
from ehamj.judge.worse import LEAST, Worse, cancelled, worse
from ehamj.plant.mounts import MOUNTS
from ehamj.result import make_dataset
from ehamj.scenario.load import parse_scenario

RATE = 500.0
TIMES = np.arange(10001) / RATE
PLANT = parse_scenario({}).plant
ARM = PLANT.positions[0][1]
X, Y, Z = range(3)


def line(frequency: float, rms: float) -> Any:
    return rms * np.sqrt(2) * np.sin(2 * np.pi * frequency * TIMES)


def found(**moved: Any) -> list[Worse]:
    """What gets worse, see `judged`."""
    return worse(judged(**moved))


def judged(**moved: Any) -> Isolation:
    """Of a floor that moves at 20 and 63 Hz along all axes; the machine at rest but where told."""
    floor = line(20.0, 1e-5) + line(63.0, 1e-5)
    motion = {
        "ground_velocity": np.broadcast_to(floor[:, None, None], (TIMES.size, 4, 3)).copy(),
        "foot_velocity": np.full((TIMES.size, 4, 3), 1e-9),
        "cg_velocity": np.zeros((TIMES.size, 3)),
        "point_velocity": np.zeros((TIMES.size, 1, 3)),
        "machine_velocity": np.zeros((TIMES.size, 6)),
    }
    for name, (where, value) in moved.items():
        motion[name][(slice(None), *(where if isinstance(where, tuple) else (where,)))] = value
    dataset = make_dataset(TIMES, motion, {}, {"mount": list(MOUNTS), "point": ["nose"]})
    return isolation(dataset, PLANT, RATE)[0]


def test_the_worst_place_and_band_are_named_with_their_decibel() -> None:
    (one,) = found(cg_velocity=(X, line(63.0, 2e-5)), point_velocity=((0, X), line(63.0, 5e-5)))
    assert (one.axis, one.place, one.band, one.first_band, one.last_band) == ("x", "nose", "63", "63", "63")
    assert one.amplification_db == pytest.approx(20 * np.log10(5.0), abs=0.01)
    assert (
        one.in_words()
        == "along x the machine moves more than the floor at any mount: by 14.0 dB in the 63 Hz band at nose"
    )


def test_two_bands_apart_are_two_findings() -> None:
    low, high = found(cg_velocity=(Z, line(20.0, 2e-5) + line(63.0, 3e-5)))
    assert [(one.axis, one.band) for one in (low, high)] == [("z", "20"), ("z", "63")]


@pytest.mark.parametrize(("amplified", "told"), [(LEAST - 0.1, 0), (LEAST + 0.1, 1)])
def test_what_no_measurement_would_show_is_not_told(amplified: float, told: int) -> None:
    assert len(found(cg_velocity=(Y, line(20.0, 1e-5 * 10 ** (amplified / 20))))) == told


def test_roll_is_held_against_the_floors() -> None:
    rolling = line(20.0, 1e-5)
    signs = np.sign([at[1] for at in PLANT.positions])
    assert found(ground_velocity=((slice(None), Z), rolling[:, None] * signs)) == []
    (one,) = found(
        ground_velocity=((slice(None), Z), rolling[:, None] * signs),
        machine_velocity=(3, 2.0 * rolling / ARM),
    )
    assert (one.axis, one.band, one.level) == ("rx", "20", None)
    assert one.amplification_db == pytest.approx(20 * np.log10(2.0), abs=0.01)
    assert one.in_words().startswith("in roll (rx) the machine moves more than the floor: by 6.0 dB in the 20 Hz band")


@pytest.mark.parametrize(("level", "told"), [(0.8, 0), (2.0, 1)])
def test_a_wave_that_cancels_in_the_mean_is_no_reason(level: float, told: int) -> None:
    """The mounts move against each other but for a fifth, so that the mean is a fifth of each mount's motion."""
    floor = line(20.0, 1e-5)[:, None] * np.array([1.2, -0.8, 1.2, -0.8]) / 1.2
    isolated = judged(ground_velocity=((slice(None), Z), floor), cg_velocity=(Z, line(20.0, level * 1e-5)))
    assert isolated.attenuation_db["z"]["20"] == pytest.approx(20 * np.log10(0.2 / 1.2 / level), abs=0.01)
    assert cancelled(isolated, "z") == (("20",) if not told else ())
    found = worse(isolated)
    assert [(one.axis, one.band) for one in found] == [("z", "20")] * told
    assert [one.amplification_db for one in found] == [pytest.approx(20 * np.log10(level), abs=0.01)] * told


def test_an_axis_along_which_only_the_machine_moves_is_told_where_it_moves_most() -> None:
    """Along x the floor is still: at 63 Hz the machine moves more along x than along y and z, at 20 Hz less."""
    still = {"ground_velocity": ((slice(None), X), 0.0)}
    along = line(20.0, 1e-7) + line(63.0, 1e-6)
    (one,) = found(**still, cg_velocity=([X, Z], np.stack([along, line(20.0, 1e-6) + line(63.0, 1e-7)], axis=1)))
    assert (one.axis, one.place, one.band, one.amplification_db) == ("x", "machine", "63", None)
    assert one.beside_db == pytest.approx(-20.0, abs=0.01)
    assert "1 µm/s in the 63 Hz band at centre of gravity, 20.0 dB below the floor's " in one.in_words()


def test_a_floor_at_rest_makes_nothing_worse() -> None:
    assert found(ground_velocity=((slice(None), slice(None)), 0.0), cg_velocity=(Z, line(20.0, 1e-5))) == []


@pytest.mark.parametrize(("beside", "worse_off"), [(None, True), (1.0, True), (0.0, False), (-1.0, False)])
def test_a_machine_that_moves_no_more_than_its_floor_s_strongest_motion_is_not_made_worse(
    beside: float | None, worse_off: bool
) -> None:
    one = Worse(
        axis="x",
        place="nose",
        band="63",
        amplification_db=None,
        beside_db=beside,
        beside="z",
        level=1e-6,
        first_band="63",
        last_band="63",
    )
    assert one.made_worse is worse_off
