"""Resonators at lines: what is left of the machine's motion there, by itself and beside a broadband loop."""

import numpy as np
import pytest

from ehamj.control import Controller
from ehamj.control.architectures.modal import ModalSettings
from ehamj.control.architectures.resonant import ResonantSettings
from ehamj.control.kinds import CombinedSettings
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.response import rigid_floor
from ehamj.linear.sampled import spectral_radius
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

GEOPHONE = {"kind": "geophone"}
SENSORS = {"ground": GEOPHONE, "inertial": GEOPHONE, "stroke": {}, "pressure": {}}
DELAY = 1.5e-4
LINES = (16.7, 24.5, 49.0)
MOTIONS = {"heave": ("z", "cg_displacement z"), "roll": ("rx", "machine_displacement rx")}
MODAL = ModalSettings(delay=DELAY)


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return parse_scenario({"plates": "tied", "sensors": SENSORS})


@pytest.fixture(scope="module")
def model(scenario: Scenario) -> LinearModel:
    return linear_model(scenario.plant)


def laws(scenario: Scenario, gain: float, beside: bool, lines: tuple[float, ...] = LINES) -> list[Controller | None]:
    """The law without and with resonators."""
    resonant = ResonantSettings(lines=lines, gain=gain, delay=DELAY)
    plant, sensors = scenario.plant, scenario.sensors
    if not beside:
        return [None, resonant.controller(plant, sensors)]
    both = CombinedSettings(parts=(MODAL, resonant), delay=DELAY)
    return [MODAL.controller(plant, sensors), both.controller(plant, sensors)]


def left(scenario: Scenario, model: LinearModel, pair: list[Controller | None], hertz: float, motion: str) -> complex:
    """Motion with the resonators over that without."""
    dof, output = MOTIONS[motion]
    without, with_them = (
        rigid_floor(model, hertz, Loop.of(scenario, law), (output,), (dof,)).response[0, 0, 0] for law in pair
    )
    return complex(with_them / without)


# Left out of a resonator's phase are the oil (2ζf/f_h, 2 % at 49 Hz) and what one line's skirt (bandwidth·f over the
# distance to the next, 1 %) does at another; of roll also the sway-rocking mode at 70 Hz, (49/70)²·its share of 15 %.
TOLERANCE = {"heave": 0.05, "roll": 0.12}


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("beside", [False, True], ids=["alone", "beside modal feedback"])
@pytest.mark.parametrize("gain", [3.0, 10.0])
def test_at_each_line_the_motion_falls_by_one_plus_gain(
    scenario: Scenario, model: LinearModel, gain: float, beside: bool, motion: str
) -> None:
    pair = laws(scenario, gain, beside)
    for line in LINES:
        rest = left(scenario, model, pair, line, motion)
        assert abs(rest) * (1 + gain) == pytest.approx(1.0, abs=TOLERANCE[motion]), f"{line} Hz"


@pytest.mark.parametrize("beside", [False, True], ids=["alone", "beside modal feedback"])
@pytest.mark.parametrize("mass", [0.7, 1.0, 1.3])
def test_it_is_stable_with_another_mass_too(scenario: Scenario, beside: bool, mass: float) -> None:
    heavier = parse_scenario({"plates": "tied", "sensors": SENSORS, "machine": {"mass": mass * 4000.0}})
    law = laws(scenario, 10.0, beside)[1]
    assert law is not None
    assert spectral_radius(linear_model(heavier.plant), Loop.of(scenario, law)) < 1.0


def test_far_from_its_line_it_does_nothing(scenario: Scenario, model: LinearModel) -> None:
    # At half its line the loop gain is g/|1 + j(½ − 2)/(2ζ)|: 1.3 % for ζ = 0.005.
    pair = laws(scenario, 2.0, False, lines=(40.0,))
    assert abs(left(scenario, model, pair, 20.0, "heave") - 1) < 0.016
    assert abs(left(scenario, model, pair, 40.0, "heave")) == pytest.approx(1 / 3, rel=0.03)


def test_width_of_the_dip_is_that_of_the_closed_resonator(scenario: Scenario, model: LinearModel) -> None:
    # 1/(1 + g·r), r = 1/(1 + j x/(2ζ)), x = f/f₀ − f₀/f: at x = 2ζ this is |(1 + j)/(1 + j + g)|.
    gain, line, zeta = 3.0, 24.5, 0.005
    pair = laws(scenario, gain, False, lines=(line,))
    beside = line * (zeta + np.sqrt(1 + zeta**2))
    assert abs(left(scenario, model, pair, beside, "heave")) == pytest.approx(abs((1 + 1j) / (1 + 1j + gain)), rel=0.03)
