"""Modes identified from the simulated machine, beside the published and the computed ones."""

import json
from typing import Any

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.rig.modal_test import ModalTest, modal_test
from ehamj.scenario.load import parse_scenario

MODES = {
    "sway-rocking about x": (70.03, 0.04218),
    "sway-rocking about y": (70.66, 0.03107),
    "yaw": (76.99, 0.02419),
    "rocking about x": (455.2, 0.1139),
    "heave": (528.0, 0.0976),
    "rocking about y": (552.1, 0.0944),
}
"""Natural frequency |λ|/2π [Hz] and damping ratio from an independent model (docs/physics.md, section 3)."""


@pytest.fixture(scope="module", params=["ring-down", "random", "sweep", "hammer"])
def tested(request: pytest.FixtureRequest) -> ModalTest:
    return modal_test(parse_scenario({}), request.param)


@pytest.fixture(scope="module")
def noisy() -> ModalTest:
    return modal_test(parse_scenario({}), "ring-down", noise=0.01, realisations=2)


def test_every_mode_is_found_under_its_name(tested: ModalTest) -> None:
    assert [mode.name for mode in tested.modes] == list(MODES)
    assert tested.missed == ()


def test_frequencies_and_damping_are_the_published(tested: ModalTest) -> None:
    for mode in tested.modes:
        frequency, damping = MODES[mode.name]
        # The promise is 0.2 % and 5 %; published to four digits, and the integration's own error is 1e-4.
        assert mode.frequency == pytest.approx(frequency, rel=5e-4)
        assert mode.damping_ratio == pytest.approx(damping, rel=2e-3)


def test_shapes_are_the_computed(tested: ModalTest) -> None:
    for mode in tested.modes:
        assert mode.computed is not None
        assert mode.likeness > 0.9999
        np.testing.assert_allclose(mode.shape, mode.computed.shape, rtol=0, atol=5e-3)


def test_without_noise_fits_agree(tested: ModalTest) -> None:
    for mode in tested.modes:
        assert mode.frequency_spread <= 2e-4 * mode.frequency
        assert mode.damping_spread <= 1e-3


def test_noise_widens_the_spread_and_moves_little(noisy: ModalTest) -> None:
    assert [mode.name for mode in noisy.modes] == list(MODES)
    for mode in noisy.modes:
        assert mode.frequency_spread > 1e-7 * mode.frequency  # without: 1e-10
        # 1 % of noise on every channel.
        assert mode.frequency == pytest.approx(MODES[mode.name][0], rel=1e-3)
        assert mode.damping_ratio == pytest.approx(MODES[mode.name][1], rel=1e-2)


def test_a_test_as_plain_data_is_strict_json(noisy: ModalTest) -> None:
    table = json.loads(json.dumps(noisy.to_dict(), allow_nan=False))
    assert (table["kind"], len(table["modes"])) == ("ring-down", 6)
    assert table["modes"][2]["computed_frequency_hz"] == pytest.approx(76.99, rel=1e-3)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"kind": "shaker"}, "'shaker': did you mean 'hammer'? must be one of ring-down, random, sweep, hammer"),
        ({"kind": "sweep", "noise": 1.0}, "noise = 1: must be from 0"),
        ({"kind": "sweep", "realisations": 0}, "realisations = 0: must be at least 1"),
    ],
)
def test_impossible_tests_are_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        modal_test(parse_scenario({}), **settings)
    assert message in str(caught.value)


def test_modes_too_far_apart_are_refused() -> None:
    light = {"lateral_stiffness": 1e4, "lateral_damping": 1.0}
    with pytest.raises(InputError, match="one measurement has up to"):
        modal_test(parse_scenario({"actuators": {"isolator": light}}), "random")


def test_a_machine_that_falls_over_is_refused() -> None:
    # m g h = 71 kN m against 4 K_L b² = 6; the oil lets it go slowly.
    isolator = {"membrane_stiffness": 4e3, "moving_volume": False}
    tall = parse_scenario({"machine": {"cg": [0.0, 0.0, 1.8]}, "actuators": {"isolator": isolator}})
    with pytest.raises(InputError, match="unstable with its valves held"):
        modal_test(tall, "ring-down")


def test_a_fast_machine_is_followed_with_a_shorter_step() -> None:
    # Modes up to 1.5 kHz, at which a step of 1e-4 s costs 0.5 % of the frequency.
    found = modal_test(parse_scenario({"actuators": {"isolator": {"preset": "recommended"}}}), "ring-down")
    for mode in found.modes:
        assert mode.computed is not None
        assert mode.frequency == pytest.approx(mode.computed.frequency, rel=2e-4)
        assert mode.damping_ratio == pytest.approx(mode.computed.damping_ratio, rel=1e-3)
