"""Modes of another machine against a scenario's: paired, and what made them found within what is stated."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from ehamj.arrays import Array
from ehamj.designs.parameters import changes_of, value_of
from ehamj.errors import InputError
from ehamj.identification.modal.compared import alike
from ehamj.identification.modal.computed import computed_many, computed_modes, in_closed_form
from ehamj.identification.modal.residuals import ModalResiduals
from ehamj.identification.modal.told import pairing
from ehamj.identification.residual import Failed
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.measured.modes import Deviations, MeasuredModes, ModeTable, measured_modes
from ehamj.measured.sensors import Place
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import changed, parse_scenario

SCENARIO = parse_scenario({})
KEYS = (
    "actuators.isolator.lateral_stiffness",
    "machine.inertia.0",
    "machine.inertia.1",
    "machine.inertia.2",
    "machine.cg.0",
    "machine.cg.1",
    "machine.cg.2",
)
SCALE = np.array([value_of(SCENARIO, key) or 0.3 for key in KEYS])
AT = np.array([value_of(SCENARIO, key) for key in KEYS])
PLACES = {f"F {mount} {axis}": Place(channel=f"foot_velocity {mount} {axis}") for mount in MOUNTS for axis in "xyz"}
PLACES |= {"P x": Place(point=(1.0, 0.7, 1.8), direction=(1.0, 0.0, 0.0))}
PLACES |= {"P y": Place(point=(1.0, 0.7, 1.8), direction=(0.0, -3.0, 0.0))}
HERTZ, RATIO, SHAPE = 0.002, 0.05, 0.02


def measured_of(
    values: Mapping[str, float], random: np.random.Generator, extra: tuple[Array, Array] | None = None
) -> MeasuredModes:
    """Modes of the simulated machine with other values, in any order, with noise; shapes by hand from the feet."""
    found = [
        mode
        for mode in modes(
            linear_model(changed(SCENARIO, changes_of(SCENARIO, values)).plant), points={"P": (1.0, 0.7, 1.8)}
        )
        if mode.machine_moves
    ]
    found = [found[k] for k in random.permutation(len(found))]
    shapes = [
        [*np.concatenate([mode.points[m] for m in MOUNTS]), mode.points["P"][0], -mode.points["P"][1]] for mode in found
    ]
    shape = np.array([row / row[np.argmax(np.abs(row))] for row in np.array(shapes)])
    shape = shape * np.exp(2j * np.pi * random.uniform(size=(len(found), 1)))  # a phase means nothing
    hertz, ratio = np.array([(mode.frequency, mode.damping_ratio) for mode in found]).T
    noise = random.normal(size=(3, *shape.shape))
    table = ModeTable(
        tuple(PLACES),
        hertz * (1.0 + HERTZ * noise[0, :, 0]),
        ratio * (1.0 + RATIO * noise[0, :, 1]),
        HERTZ * hertz,
        RATIO * ratio,
        shape + SHAPE * (noise[1] + 1j * noise[2]) / np.sqrt(2.0),
        np.full(hertz.size, SHAPE),
        False,
        "drawn",
    )
    if extra is not None:
        hertz, shape = np.append(table.frequency, extra[0]), np.vstack([table.shape, extra[1]])
        more = (np.append(column, 0.05 * extra[0]) for column in (table.frequency_deviation,))
        table = ModeTable(
            table.components,
            hertz,
            np.append(table.damping_ratio, 0.01),
            *more,
            np.append(table.damping_deviation, 1e-3),
            shape,
            np.full(hertz.size, SHAPE),
            False,
            "drawn, and one that is none",
        )
    return measured_modes(table, PLACES, Deviations(), SCENARIO.plant, SCENARIO.points)


def errors_of(residuals: ModalResiduals, points: list[Array]) -> list[Array]:
    """All errors over their deviations at each point."""
    rows = []
    for channels in residuals.compared([dict(zip(KEYS, AT + SCALE * point, strict=True)) for point in points]):
        assert not isinstance(channels, Failed)
        each = [
            one.error / (np.tile(one.deviation / np.sqrt(2.0), 2) if np.iscomplexobj(one.measured) else one.deviation)
            for one in channels
        ]
        rows.append(np.concatenate(each))
    return rows


def fitted(residuals: ModalResiduals) -> tuple[Array, Array, float]:
    """Values and their deviations over `SCALE`, and the mean square of the errors: by SciPy and differences alone."""

    def slopes(point: Array) -> Array:
        rows = errors_of(residuals, [point, *(point + 1e-5 * step for step in np.eye(point.size))])
        return np.array([(row - rows[0]) / 1e-5 for row in rows[1:]]).T

    fit = least_squares(
        lambda point: errors_of(residuals, [point])[0], np.zeros(len(KEYS)), slopes, bounds=(-0.5, 0.5), x_scale=0.1
    )
    deviations = np.sqrt(np.diag(np.linalg.inv(fit.jac.T @ fit.jac)))
    return fit.x, deviations, 2.0 * fit.cost / fit.fun.size


def drawn(random: np.random.Generator) -> dict[str, float]:
    """A machine within ±30 %, its centre of gravity off the middle."""
    return dict(zip(KEYS, (AT + SCALE * random.uniform(-0.3, 0.3, len(KEYS))).tolist(), strict=True))


def test_closed_forms_and_the_simulated_model_have_the_same_modes() -> None:
    values = drawn(np.random.default_rng(2))
    one = computed_many(SCENARIO, [values, dict(zip(KEYS, AT.tolist(), strict=True))], True)[0]
    other = computed_modes(changed(SCENARIO, changes_of(SCENARIO, values)))
    assert not isinstance(one, InputError)
    np.testing.assert_allclose(one.poles, other.poles, rtol=1e-6)
    np.testing.assert_allclose(one.shapes, other.shapes, atol=1e-5)


def test_valves_without_a_closed_form_are_linearised_one_by_one() -> None:
    other = changed(SCENARIO, {"supply.dynamic": True})
    assert not in_closed_form(other, ["machine.mass"])
    assert in_closed_form(SCENARIO, ["machine.mass"])
    found = computed_many(other, [{"machine.mass": 4000.0}, {"machine.mass": 1e12}], False)
    assert not isinstance(found[0], InputError)
    assert isinstance(found[1], InputError)
    for hertz in computed_modes(SCENARIO).frequency:  # beside a mode of the supply's line
        np.testing.assert_allclose(min(found[0].frequency, key=lambda f: abs(f - hertz)), hertz, rtol=1e-3)


def test_what_made_the_modes_is_found_within_its_deviations() -> None:
    apart, known = [], []
    for seed in range(5, 8):
        random = np.random.default_rng(seed)
        values = drawn(random)
        residuals = ModalResiduals.of("hammer", False, SCENARIO, KEYS, measured_of(values, random))
        point, deviations, square = fitted(residuals)
        truth = (np.array([values[key] for key in KEYS]) - AT) / SCALE
        apart.append((point - truth) / deviations)
        known.append(deviations)
        assert 0.6 < square < 1.15
    assert 0.65 < np.sqrt(np.mean(np.square(apart))) < 1.35  # of 21 numbers
    assert np.abs(apart).max() < 3.5
    assert (np.median(known, axis=0) < 0.02).all()


def test_modes_that_are_close_or_cross_leave_no_jump() -> None:
    """Yaw comes down from 77 Hz through both ways of sway, at 70.03 and 70.66 Hz."""
    random = np.random.default_rng(3)
    residuals = ModalResiduals.of(
        "hammer", False, SCENARIO, KEYS, measured_of(dict(zip(KEYS, AT, strict=True)), random)
    )
    path = [np.array([0.0, 0.0, 0.0, share, 0.02, 0.01, 0.0]) for share in np.linspace(0.1, 0.3, 41)]
    rows = np.array([errors_of(residuals, [point])[0] for point in path])
    steps = np.linalg.norm(np.diff(rows, axis=0), axis=1)
    assert steps.max() < 3.0 * np.median(steps)
    batch = [dict(zip(KEYS, AT + SCALE * point, strict=True)) for point in path]
    for number, place in ((0, 2), (-1, 0)):  # yaw is the third, and then the first
        computed = computed_many(SCENARIO, batch, True)[number]
        assert not isinstance(computed, InputError)
        assert computed.names[place] == "yaw"


def test_a_mode_that_bends_is_left_out_and_one_that_is_missing_is_told() -> None:
    random = np.random.default_rng(4)
    values = drawn(random)
    whole = measured_of(values, random, (np.array(76.0), random.normal(size=len(PLACES)).astype(complex)))
    missing = np.arange(7) == 1
    left = whole.without(missing)
    residuals = ModalResiduals.of("hammer", False, SCENARIO, KEYS, left)
    assert residuals.count == 5
    assert "76 Hz is left out" in residuals.strange[0]
    point, deviations, _ = fitted(residuals)
    truth = (np.array([values[key] for key in KEYS]) - AT) / SCALE
    assert np.abs((point - truth) / deviations).max() < 3.5
    after = residuals.found(dict(zip(KEYS, AT + SCALE * point, strict=True)))["after"]
    assert len(after["not_measured"]) == 1
    assert [row["why"] is None for row in after["modes"]].count(False) == 1
    assert min(row["mac"] for row in after["modes"] if row["name"] and row["mac_of_close_modes"] is None) > 0.98


def test_a_second_time_the_same_shape_is_the_one_without_a_pair() -> None:
    """Twice as high in frequency as yaw, as a harmonic would be."""
    random = np.random.default_rng(6)
    whole = measured_of(dict(zip(KEYS, AT, strict=True)), random)
    computed = computed_modes(SCENARIO)
    yaw = int(np.argmax(alike(whole, computed)[:, 2]))
    table = measured_of(dict(zip(KEYS, AT, strict=True)), random, (2.0 * whole.frequency[yaw], whole.shape[yaw]))
    found = pairing(table, computed)
    assert [pair.name == "" for pair in found.pairs] == [False, False, False, True, False, False, False]
    residuals = ModalResiduals.of("hammer", False, SCENARIO, KEYS, table)
    assert residuals.count == 6
    point, deviations, _ = fitted(residuals)
    assert np.abs(point / deviations).max() < 3.5


def test_shapes_in_wrong_directions_are_refused_before_anything_is_fitted() -> None:
    measured = measured_of(dict(zip(KEYS, AT, strict=True)), np.random.default_rng(1))
    slower = ModeTable(
        tuple(PLACES),
        measured.frequency / 1000.0,
        *(np.full(6, np.nan) for _ in range(3)),
        measured.shape,
        np.full(6, np.nan),
        False,
        "in kHz",
    )
    scaled = measured_modes(slower, PLACES, Deviations(), SCENARIO.plant, SCENARIO.points)
    with pytest.raises(InputError, match=r"none of its modes .* is like one of the machine's"):
        ModalResiduals.of("hammer", False, SCENARIO, KEYS, scaled)


def test_a_reversed_sensor_and_exchanged_ones_are_named() -> None:
    """Of modes with their errors, by what a rigid machine can do."""
    whole = measured_of(dict(zip(KEYS, AT, strict=True)), np.random.default_rng(7))
    names = whole.sensors.names
    turned, exchanged = whole.shape.copy(), whole.shape.copy()
    turned[:, 4] *= -1.0
    one, other = names.index("F front-left x"), names.index("F rear-right z")
    exchanged[:, [one, other]] = exchanged[:, [other, one]]
    for shape, said in (
        (turned, f"{names[4]} is the wrong way round"),
        (exchanged, "F front-left x and F rear-right z are exchanged"),
    ):
        with pytest.raises(InputError, match=said):
            ModalResiduals.of("hammer", False, SCENARIO, KEYS, replace(whole, shape=shape))
        with pytest.raises(InputError, match=said):
            pairing(replace(whole, shape=shape), computed_modes(SCENARIO))
