"""Soft mounts: their presets against closed forms, and the boundary of tipping three ways."""

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.isolator.presets import ELASTIC_MOUNT, FIRST_GENERATION, PNEUMATIC_MOUNT
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario
from ehamj.studies import soft_mounts as study
from ehamj.studies.variants import preset, resized, still, with_every_actuator

MACHINE = parse_scenario({"name": "a machine"})
TALL = 0.5
"""Factor on the mounts' places of a tall machine: ±0.3 m across."""


def heave(actuator: str) -> complex:
    """Eigenvalue of the machine's heave on four such mounts [1/s]."""
    scenario = still(MACHINE, **with_every_actuator(MACHINE, preset(actuator)))
    (mode,) = (mode for mode in modes(linear_model(scenario.plant)) if mode.name == "heave")
    omega = 2 * np.pi * mode.frequency
    return complex(-mode.damping_ratio * omega, omega * np.sqrt(1 - mode.damping_ratio**2))


def test_elastic_mount_is_a_spring_and_a_damper() -> None:
    """Its oil is 1e-5 of the spring, which is the tolerance."""
    a, mass = ELASTIC_MOUNT, MACHINE.plant.total_mass
    roots = np.roots([mass, 4 * a.membrane_damping, 4 * a.membrane_stiffness])
    assert abs(heave("elastic-mount") - roots[np.argmax(roots.imag)]) < 1e-4 * abs(roots[0])


def test_pneumatic_mount_is_a_standard_linear_solid() -> None:
    """Spring in parallel with spring and dashpot in series, A²/K_C; the edges' leakage, 1e-3 of it, is in K_C."""
    a, mass = PNEUMATIC_MOUNT, MACHINE.plant.total_mass
    dashpot = a.piston_area**2 / a.flow_pressure
    lag = dashpot / a.hydraulic_stiffness
    # m s² + c s + k + dashpot·s/(1 + lag·s) = 0, per mount
    m = 0.25 * mass
    k, c = a.membrane_stiffness, a.membrane_damping
    roots = np.roots([m * lag, m + c * lag, c + k * lag + dashpot, k])
    assert abs(heave("pneumatic-mount") - roots[np.argmax(roots.imag)]) < 1e-4 * abs(roots[0])


@pytest.mark.parametrize("name", study.MOUNTS_COMPARED)
def test_presets_are_marked_assumed(name: str) -> None:
    sources = preset(name).sources
    assert {sources[key] for key in ("membrane_stiffness", "lateral_stiffness", "piston_area")} == {"assumed"}


def test_tipping_height_of_a_symmetric_machine() -> None:
    plant = still(MACHINE, **with_every_actuator(MACHINE, ELASTIC_MOUNT)).plant
    k, weight = 4 * ELASTIC_MOUNT.membrane_stiffness, 4000.0 * 9.80665
    assert study.tipping_height(plant) == pytest.approx((k * 0.6**2 / weight, k * 0.9**2 / weight), rel=1e-12)


def test_a_foot_in_series_counts_and_sealed_oil_does() -> None:
    soft = FIRST_GENERATION.with_values({"foot_stiffness": 6.8e8})
    assert soft.static_stiffness == pytest.approx(3.4e8)
    sealed = FIRST_GENERATION.with_values({"flow_pressure": 0.0})
    assert sealed.static_stiffness == pytest.approx(6.8e8 + FIRST_GENERATION.hydraulic_stiffness)


def turned(angle: float) -> Scenario:
    """The machine with its mounts' corners moved as if the rectangle were turned [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    places = np.array(MACHINE.plant.positions)[:, :2] @ np.array([[c, s], [-s, c]])
    return parse_scenario(MACHINE.model_dump() | resized(MACHINE, places=places))


def test_tipping_does_not_depend_on_the_axes() -> None:
    """Turned mounts tip at the same heights, about turned axes."""
    straight = study.tipping_height(MACHINE.plant)
    assert study.tipping_height(turned(0.15).plant) == pytest.approx(straight, rel=1e-12)


@pytest.mark.parametrize("name", study.MOUNTS_COMPARED)
def test_eigenvalues_tip_where_the_closed_form_does(name: str) -> None:
    """Closed form without the sag's higher orders; eigenvalues by differences good to 1e-6."""
    closed = min(study.tipping_height(study.tall(MACHINE, preset(name), 1.0, TALL).plant))
    assert study.boundary(MACHINE, preset(name), TALL) == pytest.approx(closed, rel=1e-4)


@pytest.mark.parametrize(("off", "down"), [(-0.005, False), (0.005, True)])
def test_a_tall_machine_stands_below_the_boundary_and_falls_above(off: float, down: bool) -> None:
    """Half a per cent off on either side: the nonlinear boundary is within 1 % of the eigenvalues'."""
    height = study.boundary(MACHINE, PNEUMATIC_MOUNT, TALL)
    scenario = study.tall(MACHINE, PNEUMATIC_MOUNT, (1 + off) * height, TALL)
    assert study.falls(scenario, "about x") is down


def test_soft_mounts_isolate_where_stiff_ones_follow() -> None:
    table = study.transmissibility_table(study.compared_systems(MACHINE), np.array([0.3, 30.0]))
    gain = table["gain"].sel(axis="z")
    assert gain.sel(system="elastic-mount").values[1] < 0.05
    assert gain.sel(system="pneumatic-mount").values[1] < 0.02
    assert gain.sel(system="its own, valves held").values == pytest.approx([1.0, 1.0], abs=0.05)


def test_a_width_must_be_positive() -> None:
    with pytest.raises(InputError, match="widths"):
        study.soft_mounts.with_settings({"widths": (0.0,)})


def test_a_machine_beside_its_middle_leans() -> None:
    """m g e over Σ k y² − m g h, against the simulator's equilibrium on springs that a millimetre hardly bends."""
    beside = parse_scenario(MACHINE.model_dump() | {"machine": {"cg": (0.0, 0.02, 0.75)}})
    sprung = still(beside, plates="tied", **with_every_actuator(beside, ELASTIC_MOUNT))
    model = linear_model(sprung.plant)
    tilt = abs(model.equilibrium[model.states.index("displacement rx")])
    assert study.lean(beside, ELASTIC_MOUNT) == pytest.approx(tilt, rel=1e-3)
    assert study.lean(MACHINE, ELASTIC_MOUNT) == 0.0


def test_nothing_tips_without_gravity() -> None:
    with pytest.raises(InputError, match="gravity = 0"):
        study.soft_mounts(parse_scenario({"name": "space", "gravity": 0.0}))
