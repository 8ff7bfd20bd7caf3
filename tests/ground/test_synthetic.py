"""Grounds made from formulas: against closed forms, derivatives against the integral that must give the motion back."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import linear

from ehamj.errors import InputError
from ehamj.ground import Motion
from ehamj.scenario.load import parse_scenario

DOFS = ("x", "y", "z", "rx", "ry", "rz")
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


def motion_of(ground: dict[str, Any]) -> Motion:
    return parse_scenario({"ground": ground}).motion()


def displacement(motion: Motion, times: Any, axis: int = 2) -> np.ndarray:
    """Of all mounts along one axis, (n, 4)."""
    return motion.sample(np.atleast_1d(np.asarray(times, float))).displacement[:, :, axis]


def assert_consistent(motion: Motion, begin: float, end: float) -> None:
    """Velocity integrates to displacement and acceleration to velocity: 12-point Gauss–Legendre, exact to rounding.

    1e-9 of the largest value within, or of a micrometre or µm/s: the angle 2πft, at most 1e4 rad, is rounded to 2e-12,
    of which a difference over a fraction of a period sees a hundred times its share.
    """
    half, middle = 0.5 * (end - begin), 0.5 * (begin + end)
    edges, inside = motion.sample(np.array([begin, end])), motion.sample(middle + half * NODES)
    for value, slope, least in zip(edges[:2], inside[1:], (1e-6, 1e-6 / (end - begin)), strict=True):
        integral = half * np.tensordot(WEIGHTS, slope, axes=1)
        assert np.abs(integral - (value[1] - value[0])).max() <= 1e-9 * max(np.abs(value).max(), least)


# --- a rigid slab -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dof", DOFS)
def test_a_slab_carries_each_mount_as_a_rigid_body(dof: str) -> None:
    sine = {"kind": "sine", "dof": dof, "amplitude": 3e-6, "frequency": 7.0, "phase": 0.4}
    found = motion_of(sine).sample(np.linspace(0.0, 1.0, 101)).displacement
    wave = 3e-6 * np.sin(2 * np.pi * 7.0 * np.linspace(0.0, 1.0, 101) + 0.4)
    lever = np.stack([part[:, DOFS.index(dof)] for part in linear.foot_maps(linear.LinearMachine())], axis=1)
    np.testing.assert_allclose(found, wave[:, None, None] * lever, rtol=0, atol=1e-12 * 3e-6)


def test_a_slab_turns_about_the_mount_planes_centre_wherever_the_mounts_are() -> None:
    spots = {"front-left": [1.0, 0.5], "front-right": [0.8, -0.7], "rear-left": [-0.6, 0.3], "rear-right": [-1.1, -0.1]}
    table = {
        "mount": [{"name": name, "position": at} for name, at in spots.items()],
        "ground": {"kind": "sine", "dof": "ry", "amplitude": 1e-5, "frequency": 5.0},
    }
    heights = displacement(parse_scenario(table).motion(), 0.05)[0]  # a quarter period: the peak
    np.testing.assert_allclose(heights, [-1.0e-5, -0.8e-5, 0.6e-5, 1.1e-5], rtol=1e-12)


def test_a_ground_at_rest_never_moves() -> None:
    motion = motion_of({"kind": "rest"})
    assert motion.at_rest
    np.testing.assert_array_equal(motion.sample(np.linspace(0.0, 9.0, 10)), np.zeros((3, 10, 4, 3)))


# --- derivatives --------------------------------------------------------------------------------------------------

amplitudes, frequencies = st.floats(1e-7, 1e-4), st.floats(0.5, 200.0)
sines = st.fixed_dictionaries(
    {"kind": st.just("sine"), "dof": st.sampled_from(DOFS), "amplitude": amplitudes, "frequency": frequencies},
    optional={"phase": st.floats(-6.0, 6.0)},
)
multisines = st.fixed_dictionaries(
    {
        "kind": st.just("multisine"),
        "dof": st.sampled_from(DOFS),
        "frequencies": st.lists(frequencies, min_size=1, max_size=4),
        "velocities": st.lists(st.floats(1e-6, 1e-3), min_size=1, max_size=1),
    }
)
sweeps = st.fixed_dictionaries(
    {"kind": st.just("sweep"), "dof": st.sampled_from(DOFS), "first": frequencies, "last": frequencies}
)


@given(st.one_of(sines, multisines, sweeps), st.floats(0.0, 10.0))
def test_displacement_velocity_and_acceleration_belong_together(ground: dict[str, Any], begin: float) -> None:
    assert_consistent(motion_of(ground), begin, begin + 1e-3)


@given(sines, st.floats(0.1, 3.0), st.floats(0.0, 0.99))
def test_they_do_so_while_the_motion_fades_in(ground: dict[str, Any], fade_in: float, share: float) -> None:
    begin = share * (fade_in - 1e-3)
    assert_consistent(motion_of({**ground, "fade_in": fade_in}), begin, begin + 1e-3)


@given(sines, st.floats(0.1, 3.0))
def test_a_faded_motion_begins_at_rest(ground: dict[str, Any], fade_in: float) -> None:
    np.testing.assert_array_equal(motion_of({**ground, "fade_in": fade_in}).sample(np.zeros(1)), np.zeros((3, 1, 4, 3)))


def test_a_faded_motion_is_the_motion_afterwards() -> None:
    ground = {"kind": "multisine", "frequencies": [3.0, 5.0], "velocities": [1e-5]}
    times = np.linspace(0.7, 2.0, 50)
    faded, plain = (motion_of({**ground, "fade_in": fade}).sample(times) for fade in (0.7, 0.0))
    np.testing.assert_array_equal(faded, plain)


# --- multisine ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("velocities", [[2e-6], [1e-6, 4e-6, 3e-6]])
def test_each_line_has_the_velocity_that_is_stated(velocities: list[float]) -> None:
    motion = motion_of({"kind": "multisine", "frequencies": [16.0, 25.0, 49.0], "velocities": velocities})
    velocity = motion.sample(np.arange(1000) / 1000.0).velocity[:, 0, 2]
    lines = np.sqrt(2.0) / 1000 * np.abs(np.fft.rfft(velocity))
    expected = np.zeros(501)
    expected[[16, 25, 49]] = velocities
    np.testing.assert_allclose(lines, expected, rtol=0, atol=1e-12 * 4e-6)


def test_phases_that_are_given_are_used() -> None:
    motion = motion_of(
        {"kind": "multisine", "frequencies": [2.0, 3.0], "velocities": [1e-5], "phases": [0.0, np.pi / 2]}
    )
    # At time zero the first sine is zero, the second at its peak: √2·v/(2πf).
    assert displacement(motion, 0.0)[0, 0] == pytest.approx(np.sqrt(2) * 1e-5 / (2 * np.pi * 3.0), rel=1e-12)


def test_phases_that_are_not_given_keep_the_peak_low() -> None:
    lines = {"kind": "multisine", "frequencies": list(range(20, 60)), "velocities": [1e-6]}
    times = np.arange(4000) / 4000.0
    own, aligned = (
        np.abs(motion_of({**lines, **phases}).sample(times).velocity[:, 0, 2]).max()
        for phases in ({}, {"phases": [np.pi / 2] * 40})
    )
    # Aligned velocities of 40 lines add to their sum at one moment; Schroeder's are near 1.7 times their RMS, √40.
    assert own < 0.35 * aligned


# --- sweep --------------------------------------------------------------------------------------------------------


def test_a_sweep_is_the_exponential_one_from_its_beginning_to_its_end() -> None:
    sweep = {"kind": "sweep", "amplitude": 2e-6, "first": 5.0, "last": 80.0, "sweep_time": 4.0, "begin": 1.5}
    times = np.linspace(0.0, 6.0, 601)
    since, ratio = times - 1.5, 80.0 / 5.0
    angle = 2 * np.pi * 5.0 * 4.0 / np.log(ratio) * (ratio ** (since / 4.0) - 1.0)
    expected = np.where((since >= 0.0) & (since < 4.0 - 1e-9), 2e-6 * np.sin(angle), 0.0)
    # The angle reaches 700 rad: 1e-12 of it, either way.
    np.testing.assert_allclose(displacement(motion_of(sweep), times)[:, 2], expected, rtol=0, atol=1e-9 * 2e-6)


@pytest.mark.parametrize("begin", [0.0, 1.5])
def test_a_sweep_fades_in_from_its_beginning(begin: float) -> None:
    sweep = {"kind": "sweep", "amplitude": 2e-6, "first": 5.0, "last": 80.0, "sweep_time": 4.0}
    since = np.linspace(0.0, 3.9, 200)
    plain = displacement(motion_of(sweep), since)[:, 2]
    faded = displacement(motion_of({**sweep, "fade_in": 1.0, "begin": begin}), begin + since)[:, 2]
    s = np.minimum(since, 1.0)
    # Times of 5 s are rounded to 1e-15 s, at 80 Hz.
    np.testing.assert_allclose(faded, s**3 * (10 - 15 * s + 6 * s * s) * plain, rtol=0, atol=1e-12 * 2e-6 * 500)


def test_a_sweep_that_travels_fades_in_when_it_arrives() -> None:
    sweep = {"kind": "sweep", "amplitude": 2e-6, "sweep_time": 2.0, "begin": 1.0, "fade_in": 0.5}
    motion = motion_of({**sweep, "wave": {"speed": 9.0}})  # front 0.1 s late, rear 0.1 s early
    since = np.linspace(0.0, 1.0, 50)
    front, rear = (motion.sample(1.0 + delay + since).displacement[:, m, 2] for delay, m in ((0.1, 0), (-0.1, 2)))
    np.testing.assert_allclose(front, rear, rtol=0, atol=1e-12 * 2e-6 * 500)
    assert np.abs(front[:3]).max() < 10 * 0.082**3 * 2e-6  # the quintic is below 10 s³, here up to s = 0.04/0.5


# --- shock --------------------------------------------------------------------------------------------------------

shocks = st.fixed_dictionaries(
    {
        "kind": st.just("shock"),
        "dof": st.sampled_from(("x", "y", "z")),
        "velocity": st.floats(1e-5, 1e-2),
        "pulse_time": st.floats(2e-3, 0.1),
        "return_time": st.floats(0.05, 2.0),
        "begin": st.floats(0.0, 3.0),
    }
)


def shock_times(ground: dict[str, Any]) -> tuple[float, float, float]:
    """Begin and end of the pulse, and end of the way back."""
    end = ground["begin"] + ground["pulse_time"]
    return ground["begin"], end, end + ground["return_time"]


def along(ground: dict[str, Any], times: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Displacement, velocity and acceleration of one mount in the direction of the shock, (n,) each."""
    sample = motion_of(ground).sample(np.atleast_1d(np.asarray(times, float)))
    return tuple(part[:, 1, DOFS.index(ground["dof"])] for part in sample)  # type: ignore[return-value]


@given(shocks, st.floats(0.0, 1.0))
def test_the_pulse_of_a_shock_is_a_half_sine_of_velocity(ground: dict[str, Any], share: float) -> None:
    begin, _, _ = shock_times(ground)
    _, velocity, _ = along(ground, begin + share * ground["pulse_time"])
    # Times near 3 s are rounded to 4e-16 s, a 2e-13 of the shortest pulse.
    assert velocity[0] == pytest.approx(ground["velocity"] * np.sin(np.pi * share), abs=1e-11 * ground["velocity"])


@given(shocks)
def test_the_pulse_lifts_the_ground_by_its_area(ground: dict[str, Any]) -> None:
    rise, _, _ = along(ground, shock_times(ground)[1])
    assert rise[0] == pytest.approx(2 / np.pi * ground["velocity"] * ground["pulse_time"], rel=1e-12)


@given(shocks, st.integers(0, 1), st.floats(0.02, 0.9))
def test_motion_of_a_shock_belongs_together_in_the_pulse_and_on_the_way_back(
    ground: dict[str, Any], piece: int, share: float
) -> None:
    edges = shock_times(ground)
    length = edges[piece + 1] - edges[piece]
    begin = edges[piece] + share * length
    assert_consistent(motion_of(ground), begin, begin + 0.05 * length)


@given(shocks)
def test_displacement_and_velocity_of_a_shock_never_jump(ground: dict[str, Any]) -> None:
    step, rise = 1e-9, 2 / np.pi * ground["velocity"] * ground["pulse_time"]
    # The largest slopes of either piece; a quintic's are 15/8 and 10/√3 over its duration and its square.
    speed = max(ground["velocity"], 15 / 8 * rise / ground["return_time"])
    acceleration = max(
        np.pi / ground["pulse_time"] * ground["velocity"], 10 / 3**0.5 * rise / ground["return_time"] ** 2
    )
    for moment in shock_times(ground):
        before, after = (along(ground, moment + side * step) for side in (-1, 1))
        # 2.1 for 2: at 3 s the times themselves are rounded to 4e-16 s.
        assert abs(after[0][0] - before[0][0]) <= 2.1 * step * speed
        assert abs(after[1][0] - before[1][0]) <= 2.1 * step * acceleration


@given(shocks)
def test_before_and_after_a_shock_the_ground_is_at_rest_in_its_place(ground: dict[str, Any]) -> None:
    begin, _, end = shock_times(ground)
    outside = [0.5 * begin, np.nextafter(begin, -1.0), end + 1e-9, end + 1.0, end + 100.0]
    np.testing.assert_array_equal(along(ground, outside), np.zeros((3, 5)))


# --- several at once ----------------------------------------------------------------------------------------------


def test_grounds_of_a_sum_add_up() -> None:
    parts = [
        {"kind": "sine", "dof": "rx", "frequency": 3.0},
        {"kind": "shock", "dof": "x", "begin": 0.3},
        {"kind": "sine", "amplitude": 2e-6, "frequency": 11.0, "wave": {"speed": 150.0}},
        {"kind": "rest"},
    ]
    times = np.linspace(0.0, 1.0, 201)
    total = motion_of({"kind": "sum", "parts": parts}).sample(times)
    alone = [motion_of(part).sample(times) for part in parts]
    # Rounding of a sum of four.
    np.testing.assert_allclose(total, np.sum(alone, axis=0), rtol=0, atol=1e-15)


def test_a_sum_is_at_rest_when_all_its_parts_are() -> None:
    resting, sine = {"kind": "rest"}, {"kind": "sine"}
    assert motion_of({"kind": "sum", "parts": [resting, resting]}).at_rest
    assert not motion_of({"kind": "sum", "parts": [resting, sine]}).at_rest


# --- bad input ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("ground", "message"),
    [
        ({"kind": "sin"}, r"ground\.kind = 'sin': did you mean 'sine'\? must be one of 'rest', 'sine', "),
        ({}, r"ground\.kind: is missing; must be one of .*'rest', 'shaped', 'shock', 'sine', "),
        ({"kind": "sine", "dof": "w"}, r"ground\.dof = 'w': must be 'x', 'y', 'z', 'rx', 'ry' or 'rz'"),
        ({"kind": "sine", "frequency": 0.0}, r"ground\.frequency = 0\.0: must be greater than 0"),
        ({"kind": "sine", "amplitude": float("inf")}, r"ground\.amplitude = inf: must be a finite number"),
        ({"kind": "sine", "frequncy": 3.0}, r"ground\.frequncy = 3\.0: unknown key; did you mean 'frequency'\?"),
        ({"kind": "sine", "fade_in": -1.0}, r"ground\.fade_in = -1\.0: must be greater than or equal to 0"),
        ({"kind": "multisine", "frequencies": [3.0]}, r"ground\.velocities: is missing"),
        ({"kind": "multisine", "frequencies": [], "velocities": [1.0]}, r"ground\.frequencies = \[\]: must have"),
        (
            {"kind": "multisine", "frequencies": [3.0, -1.0], "velocities": [1.0]},
            r"ground\.frequencies\.1 = -1\.0: must be greater than 0",
        ),
        (
            {"kind": "multisine", "frequencies": [3.0, 4.0], "velocities": [1.0] * 3},
            r"ground: velocities has 3 values; it must have 1 or 2",
        ),
        (
            {"kind": "multisine", "frequencies": [3.0, 4.0], "velocities": [1.0], "phases": [0.0]},
            r"ground: phases has 1 values; it must have 2",
        ),
        ({"kind": "sweep", "first": 0.0}, r"ground\.first = 0\.0: must be greater than 0"),
        ({"kind": "sweep", "sweep_time": -2.0}, r"ground\.sweep_time = -2\.0: must be greater than 0"),
        ({"kind": "shock", "pulse_time": 0.0}, r"ground\.pulse_time = 0\.0: must be greater than 0"),
        ({"kind": "shock", "return_time": 0.0}, r"ground\.return_time = 0\.0: must be greater than 0"),
        ({"kind": "shock", "begin": -1.0}, r"ground\.begin = -1\.0: must be greater than or equal to 0"),
        ({"kind": "sum", "parts": []}, r"ground\.parts = \[\]: must have at least 1 item"),
        ({"kind": "sum", "parts": [{"kind": "sum", "parts": []}]}, r"ground\.parts\.0\.kind = 'sum': must be one of"),
        (
            {"kind": "sum", "parts": [{"kind": "rest"}, {"kind": "sine", "frequency": -1.0}]},
            r"ground\.parts\.1\.frequency = -1\.0: must be greater than 0",
        ),
    ],
)
def test_bad_input_is_named_with_its_value_and_what_is_allowed(ground: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        parse_scenario({"ground": ground})
