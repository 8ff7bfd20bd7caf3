"""Floor to machine: linear against closed forms, nonlinear runs against linear, and the files that hold them."""

import csv
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from oracles import linear
from scipy.linalg import expm

from ehamj.control import Controller
from ehamj.control.sensors import IDEAL
from ehamj.errors import InputError
from ehamj.estimate.bands import band_attenuation, bands
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.linear.response import (
    deviations,
    foot_channels,
    lever_scale,
    machine_channels,
    rigid_floor,
    single_mounts,
    slab_pattern,
)
from ehamj.plant.axes import DOFS
from ehamj.plant.mounts import MOUNTS
from ehamj.rig.comparison import (
    Comparison,
    TransmissibilitySettings,
    compare_result,
    compare_scenario,
)
from ehamj.rig.measurement import Measurement
from ehamj.rig.multisine import by_multisine, settling_time
from ehamj.rig.tables import write_tables
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario

BASE: dict[str, Any] = {"plates": "tied"}
CORNERS = ((0.9, 0.6), (0.8, -0.7), (-1.0, 0.5), (-0.9, -0.6))
ASYMMETRIC: dict[str, Any] = {
    **BASE,
    "machine": {"mass": 5200.0, "cg": [0.12, -0.07, 0.9]},
    "mount": [{"name": name, "position": list(at)} for name, at in zip(MOUNTS, CORNERS, strict=True)],
}
# Small enough that the valves are linear, and no converter: what is left is the loop's arithmetic.
FEEDFORWARD: dict[str, Any] = {**BASE, "control": {"kind": "feedforward", "bits": 52}}
HERTZ = np.array([1.0, 3.0, 10.0, 30.0, 68.0, 71.0, 77.0, 150.0, 300.0])


def feedback(delay: float) -> Controller:
    """Velocities of the feet fed back, each to its own valve, low-passed, and the ground's velocity fed forward."""
    inputs = tuple(f"{what} {mount} z" for what in ("foot_velocity", "ground_velocity") for mount in MOUNTS)
    B = np.hstack([0.2 * np.eye(4), np.zeros((4, 4))])
    D = np.hstack([np.zeros((4, 4)), -3000.0 * np.eye(4)])
    return Controller(0.8 * np.eye(4), B, -5e3 * np.eye(4), D, inputs, 5e-4, delay, bits=None)


# --- linear ----------------------------------------------------------------------------------------------------------


def test_passive_at_the_mount_plane_is_the_oracles() -> None:
    found = rigid_floor(linear_model(parse_scenario(BASE).plant), HERTZ, outputs=machine_channels("mounts"))
    expected = [[linear.transmissibility(linear.LinearMachine(), dof, f) for dof in DOFS] for f in HERTZ]
    # The model is differentiated numerically, to about 1e-7 of each row.
    error = deviations(found.response, np.array(expected).transpose(0, 2, 1), DOFS, DOFS, 1.0)
    assert error.max() < 1e-5


def test_the_centre_of_gravity_moves_as_the_rigid_body_does() -> None:
    model = linear_model(parse_scenario(ASYMMETRIC).plant)
    at_mounts, at_cg = (rigid_floor(model, HERTZ, outputs=machine_channels(where)) for where in ("mounts", "cg"))
    x, y, z = 0.12, -0.07, 0.9
    lever = np.array([[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]])
    np.testing.assert_allclose(at_cg.response[:, :3], lever @ at_mounts.response, atol=1e-12)
    np.testing.assert_allclose(at_cg.response[:, 3:], at_mounts.response[:, 3:], rtol=1e-12)


def test_slowly_the_machine_follows_the_floor() -> None:
    model = linear_model(parse_scenario({**ASYMMETRIC, "gravity": 0.0}).plant)
    found = rigid_floor(model, [1e-3], outputs=machine_channels("mounts"))
    np.testing.assert_allclose(found.response[0], np.eye(6), atol=1e-6)


def test_single_mounts_add_up_to_the_slab() -> None:
    scenario = parse_scenario({**ASYMMETRIC, "control": {"kind": "feedforward"}})
    model, loop = linear_model(scenario.plant), Loop.of(scenario, scenario.controller())
    outputs = (*machine_channels(), *foot_channels(MOUNTS))
    single = single_mounts(model, HERTZ, loop, outputs)
    whole = rigid_floor(model, HERTZ, loop, outputs)
    np.testing.assert_allclose(single.response @ slab_pattern(model.plant), whole.response, atol=1e-12)


def test_feedforward_is_the_series_of_its_parts() -> None:
    """T = T₀ + P_v H e^{−jωτ} C(e^{jωT}) jω on each mount's z, all of it from the oracle's own matrices."""
    scenario = parse_scenario({**BASE, "control": {"kind": "feedforward", "rate": 4000.0, "delay": 4e-4}})
    law = scenario.controller()
    assert law is not None
    A, B, C, _ = linear.state_space(linear.LinearMachine())
    found = rigid_floor(linear_model(scenario.plant), HERTZ, Loop.of(scenario, law), machine_channels("mounts"))
    up = linear.foot_maps(linear.LinearMachine())[2]
    for f, response in zip(HERTZ, found.response, strict=True):
        s, T = 2j * np.pi * f, law.period
        z = np.exp(s * T)
        control = law.C @ np.linalg.solve(z * np.eye(law.states) - law.A, law.B) + law.D
        held = (1 - np.exp(-s * T)) / (s * T) * np.exp(-s * 4e-4)
        valves = (C @ np.linalg.solve(s * np.eye(28) - A, B))[:6, :4]
        passive = np.array([linear.transmissibility(linear.LinearMachine(), dof, f) for dof in DOFS]).T
        expected = passive + valves @ (held * control * s) @ up
        error = deviations(response[None], expected[None], DOFS, DOFS, 1.0)
        # Where feedforward leaves 1e-3 of the floor, 1e-7 of the numeric derivatives count a thousandfold.
        assert error.max() < 1e-3, f


@pytest.mark.parametrize("delay", [0.0, 2e-4, 5e-4, 1.2e-3])
def test_a_loop_is_closed_as_stepping_it_does(delay: float) -> None:
    """The linear machine stepped exactly from sample to sample by hand, at a sine of the floor, settles on it."""
    model, law, f = linear_model(parse_scenario(BASE).plant), feedback(delay), 40.0
    foot = ("foot_displacement front-left z",)
    expected = rigid_floor(model, f, Loop(law, IDEAL, 0), foot, ("z",)).response[0, 0, 0]
    n, s, fine = model.A.shape[0], 2j * np.pi * f, 1e-4
    ground = [
        model.inputs.index(f"ground_{what} {mount} z") for what in ("displacement", "velocity") for mount in MOUNTS
    ]
    wave = model.B[:, ground] @ np.repeat([1.0, s], 4)
    forced = np.linalg.solve(s * np.eye(n) - model.A, wave)  # the part that follows e^{st}; the rest is free
    block = expm(fine * np.block([[model.A, model.B[:, :4]], [np.zeros((4, n + 4))]]))
    move, push = block[:n, :n], block[:n, n:]
    C, _ = model.rows((*law.inputs[:4], "foot_displacement front-left z"))
    free, x = -forced, np.zeros(4, complex)
    every, steps = round(law.period / fine), 20_000
    due: dict[int, np.ndarray] = {}
    held = np.zeros(4, complex)
    total = 0.0 + 0.0j
    for k in range(steps):
        turn = np.exp(s * k * fine)
        if k % every == 0:
            u = np.concatenate([C[:4] @ (free + forced * turn), np.full(4, s * turn)])
            due[k + round(delay / fine)] = law.C @ x + law.D @ u
            x = law.A @ x + law.B @ u
        held = due.pop(k, held)
        if k >= steps // 2:  # 40 periods
            total += (C[4] @ (free + forced * turn)) / turn / (steps - steps // 2)
        free = move @ free + push @ held
    # The images at multiples of the sampling rate average out over whole periods.
    assert total == pytest.approx(expected, rel=1e-6)


def test_a_band_of_constant_response_has_its_level() -> None:
    chosen = bands(1.0, 10.0)
    frequency = np.geomspace(0.8, 13.0, 500)
    np.testing.assert_allclose(band_attenuation(frequency, np.full(500, 0.1j), chosen), 20.0)
    assert np.isnan(band_attenuation(np.array([100.0]), np.array([1.0 + 0j]), chosen)).all()
    half = band_attenuation(np.array([1.0, 1.01]), np.array([1.0, 0.0j]), chosen)[0]
    assert half == pytest.approx(10 * np.log10(2.0))


# --- measured --------------------------------------------------------------------------------------------------------


@cache
def measured(which: str) -> tuple[Scenario, Measurement]:
    table, velocity = {"passive": (ASYMMETRIC, 1e-6), "feedforward": (FEEDFORWARD, 1e-8)}[which]
    scenario = parse_scenario(table)
    return scenario, by_multisine(
        scenario, velocity=velocity, frequency=[1, 2, 5, 10, 20, 40, 60, 69, 75, 90, 150, 300]
    )


@pytest.mark.parametrize("which", ["passive", "feedforward"])
def test_six_by_six_measured_lies_on_the_linear(which: str) -> None:
    """Every element within 2 % where coherent; under feedforward that is 2e-5 of the floor's motion."""
    scenario, found = measured(which)
    model, e = linear_model(scenario.plant), found.estimate
    expected = rigid_floor(model, e.frequency, Loop.of(scenario, scenario.controller())).response
    error = deviations(e.response, expected, found.outputs, found.inputs, lever_scale(model.plant))
    assert e.response.shape == (12, 6, 6)
    assert e.multiple.min() > 0.95
    assert error.max() <= 0.02


def test_feedforward_measured_is_quiet() -> None:
    """The comparison above is of small numbers: below 1e-3 of the floor around 10 Hz."""
    _, found = measured("feedforward")
    z = found.estimate.response[:, 2, 2]
    assert np.abs(z[[3, 4]]).max() < 2e-3


@pytest.mark.parametrize("delay", [2e-4, 1.2e-3])
def test_feedback_measured_lies_on_the_linear(delay: float, tmp_path: Path) -> None:
    law = feedback(delay)
    law.save(tmp_path / "law.json")
    # At the automatic step, 250 µs, the integrator would be out by 2.5e-3 at 300 Hz.
    scenario = parse_scenario(
        {**BASE, "timestep": 1e-4, "control": {"kind": "law", "file": str(tmp_path / "law.json")}}
    )
    found = by_multisine(scenario, dofs=("z", "ry"), velocity=1e-8, frequency=[5, 20, 60, 150, 300])
    model, e = linear_model(scenario.plant), found.estimate
    expected = rigid_floor(model, e.frequency, Loop(law, IDEAL, 0), found.outputs, found.inputs).response
    own = [2, 4]  # z and ry; the rest is zero or sway
    np.testing.assert_allclose(e.response[:, own], expected[:, own], atol=2e-3)
    assert np.abs(expected[:, 2, 0]).min() < 0.8  # the law does something


def test_a_valves_nonlinearity_shows_as_distortion_and_noise_as_incoherence() -> None:
    """Strong motion and four bits: what is measured is less coherent than with a fine converter and weak motion."""
    scenario = parse_scenario({**BASE, "control": {"kind": "feedforward", "bits": 8}})
    coarse = by_multisine(scenario, dofs=("z",), velocity=1e-6, frequency=[5, 10, 20, 40], realisations=3)
    scenario = parse_scenario({**BASE, "control": {"kind": "feedforward", "bits": 52}})
    fine = by_multisine(scenario, dofs=("z",), velocity=1e-6, frequency=[5, 10, 20, 40], realisations=3)
    assert coarse.estimate.multiple[:, 2].min() < 0.95 < fine.estimate.multiple[:, 2].min()
    assert (coarse.estimate.radius[:, 2, 0] > 10 * fine.estimate.radius[:, 2, 0]).all()


def test_settling_follows_the_slowest_mode() -> None:
    """Yaw, 76.99 Hz with ζ 0.0242, leaves 1e-6 after 13.8/(2π·76.99·0.0242) = 1.18 s, after half a second of fading."""
    assert settling_time(linear_model(parse_scenario(BASE).plant), None) == pytest.approx((0.5, 0.5 + 1.2))


def test_high_passes_far_below_the_lines_are_not_waited_for() -> None:
    """The shipped scenario's law and instruments: what is slower than a period is taken out as drift.

    Without noise and with a fine converter the linear response is met at all lines, as with laws that settle: to 1 %,
    and twice the instruments' own error between integration steps, (πfh)²/3 of the floor (docs/physics.md, section 6).
    """
    quiet = ["control.bits=52", *(f"sensors.{group}.noise=0" for group in ("ground", "inertial", "stroke", "pressure"))]
    scenario = load_scenario("recorded", ["plates=tied", *quiet])
    model, loop = linear_model(scenario.plant), Loop.of(scenario, scenario.controller())
    fade_in, settling = settling_time(model, loop)
    assert fade_in == 5.0 < settling < 12.0
    found = by_multisine(scenario, dofs=("z",), velocity=1e-8, frequency=[1, 2, 5, 20, 60, 200]).estimate
    expected = rigid_floor(model, found.frequency, loop, ("cg_displacement z",), ("z",)).response
    between_steps = (np.pi * found.frequency * 1e-4) ** 2 / 3.0
    allowed = 0.01 * np.abs(expected[:, 0, 0]) + 2.0 * between_steps
    assert np.all(np.abs(found.response[:, 2, 0] - expected[:, 0, 0]) <= allowed)


def test_what_cannot_be_measured_is_refused() -> None:
    scenario = parse_scenario(BASE)
    with pytest.raises(InputError, match="realisations = 1: must be at least 2"):
        by_multisine(scenario, realisations=1)
    with pytest.raises(InputError, match="dof = 'w': must be one of x, y, z"):
        by_multisine(scenario, dofs=("z", "w"))
    with pytest.raises(InputError, match="lines must be multiples of 1 Hz"):
        by_multisine(scenario, frequency=[1.0, 2.5])
    with pytest.raises(InputError, match="reference = 'tip': must be 'cg' or 'mounts'"):
        machine_channels("tip")  # type: ignore[arg-type]
    undamped = {"machine": {"mass": 4000.0}, "actuators": {"isolator": {"lateral_damping": 0.0}}}
    with pytest.raises(InputError, match=r"the mode .* has a damping ratio of .*; a measurement needs"):
        by_multisine(parse_scenario({**BASE, **undamped}))


# --- side by side, and files -----------------------------------------------------------------------------------------


@cache
def compared() -> Comparison:
    scenario = parse_scenario({**BASE, "control": {"kind": "feedforward"}})
    return compare_scenario(scenario, TransmissibilitySettings(dofs=("z", "rx"), lines=6, first=2.0, last=100.0))


@cache
def stored() -> Comparison:
    floor = {"kind": "broadband", "level": "VC-C", "axes": ["x", "z"]}
    result = simulate(parse_scenario({**BASE, "duration": 20.0, "ground": floor}))
    return compare_result(result, TransmissibilitySettings(method="welch", joint=True, dofs=("x", "z"), last=200.0))


def test_a_run_shows_its_own_transmissibility() -> None:
    """Broadband floor in x and z, estimated together: on the linear response where that changes slowly."""
    (passive,) = stored().variants
    (one,) = passive.measured
    e = one.estimate
    expected = rigid_floor(linear_model(stored().scenario.plant), e.frequency, None, one.outputs, one.inputs).response
    assert one.outputs == ("cg_displacement x", "cg_displacement z")
    z, slow = np.abs(e.response[:, 1, 1] / expected[:, 1, 1] - 1), e.frequency < 40.0
    assert e.multiple[:, 1].min() > 0.95
    assert z.max() <= 0.02
    assert np.abs(e.response[slow, 0, 0] / expected[slow, 0, 0] - 1).max() <= 0.02
    assert (np.abs(e.response - expected)[slow] < 2 * e.radius[slow] + 1e-3).mean() > 0.9


def test_directions_that_rest_are_not_measured() -> None:
    floor = {"kind": "broadband", "level": "VC-C"}
    result = simulate(parse_scenario({**BASE, "duration": 4.0, "ground": floor}))
    found = compare_result(result, TransmissibilitySettings(method="welch", dofs=("z", "rx", "x"), last=200.0))
    z, rx, x = (one.estimate.response for one in found.variants[0].measured)
    assert np.isfinite(z).all()
    assert np.isnan(rx).all()
    assert np.isnan(x).all()


def test_the_dataset_holds_what_was_computed(tmp_path: Path) -> None:
    found = compared()
    write_tables(tmp_path, found)
    with xr.open_dataset(tmp_path / "transmissibility.nc", engine="h5netcdf") as data:
        assert list(data.variant.values) == ["passive", "feedforward"]
        assert all("units" in data[name].attrs and data[name].attrs["long_name"] for name in data.data_vars)
        for k, variant in enumerate(found.variants):
            (one,) = variant.measured
            np.testing.assert_allclose(data.measured_magnitude[k], np.abs(one.estimate.response))
            np.testing.assert_allclose(data.confidence_radius[k], one.estimate.radius)
            np.testing.assert_allclose(data.linear_magnitude[k], np.abs(variant.linear.response))
            single = data.single_mount_magnitude.sel(point="foot_displacement front-left z", ground="front-left z")
            assert single.shape == (2, variant.single.frequency.size)
        levels = {(name, kind, dof): part for name, kind, dof, part in found.attenuation()}
        quiet = data.attenuation_measured.sel(variant="feedforward", input="z")
        np.testing.assert_allclose(quiet, levels["feedforward", "measured", "z"])
        assert float(quiet.max()) > 40.0


def test_the_tables_hold_the_same_numbers(tmp_path: Path) -> None:
    found = compared()
    write_tables(tmp_path, found)
    with (tmp_path / "transmissibility.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    (one,) = found.variants[1].measured
    wanted = {"variant": "feedforward", "kind": "measured", "output": "machine_displacement rx", "input": "floor rx"}
    shown = [row for row in rows if wanted.items() <= row.items()]
    e, i = one.estimate, one.outputs.index("machine_displacement rx")
    assert {row["unit"] for row in shown} == {"rad/rad"}
    for column, values in (
        ("frequency_hz", e.frequency),
        ("magnitude", np.abs(e.response[:, i, 1])),
        ("radius", e.radius[:, i, 1]),
        ("multiple_coherence", e.multiple[:, i]),
    ):
        np.testing.assert_allclose([float(row[column]) for row in shown], values, rtol=1e-8)
    with (tmp_path / "attenuation.csv").open(encoding="utf-8") as file:
        bands_shown = {(row["variant"], row["kind"], row["dof"], row["band_hz"]): row for row in csv.DictReader(file)}
    for name, kind, dof, levels in found.attenuation():
        for band, level in zip(found.chosen, levels, strict=True):
            text = bands_shown[name, kind, dof, band.name]["attenuation_db"]
            assert (text == "") == np.isnan(level)
            assert not text or float(text) == pytest.approx(level, rel=1e-5)
