"""A control law as data: what is refused and why, from python-control, to a file and back, side by side."""

import json
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ehamj.control import Controller
from ehamj.control.channels import channel_names, is_upstream
from ehamj.control.law import stack
from ehamj.control.sensors import IDEAL
from ehamj.control.windup import anti_windup_gain, limited_radius
from ehamj.errors import InputError
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import parse_scenario

VALVES = [f"valve_command {mount}" for mount in MOUNTS]
STROKES = [f"stroke {mount}" for mount in MOUNTS]
MATRICES = ("A", "B", "C", "D")


def law(**changes: Any) -> Controller:
    """One state, from one stroke to all valves."""
    plain = {
        "A": np.array([[0.5]]),
        "B": np.array([[1.0]]),
        "C": np.ones((4, 1)),
        "D": np.zeros((4, 1)),
        "inputs": ("stroke front-left",),
    }
    return Controller(**{**plain, **changes})


def assert_equal(one: Controller, other: Controller) -> None:
    for name in (*MATRICES, "anti_windup"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for name in ("inputs", "period", "delay", "voltage_limit", "bits", "switch_on", "fade"):
        assert getattr(one, name) == getattr(other, name), name


def response(of: Controller, z: complex) -> np.ndarray:
    return of.C @ np.linalg.solve(z * np.eye(of.states) - of.A, of.B) + of.D


# --- what is refused ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"A": np.eye(2)}, r"controller\.B: has shape \(1, 1\), it must be \(2, 1\) \(2 states, 1 inputs, 4 valves\)"),
        ({"A": np.ones((1, 2))}, r"controller\.A: has shape \(1, 2\), it must be \(1, 1\)"),
        ({"B": np.ones((1, 2))}, r"controller\.B: has shape \(1, 2\), it must be \(1, 1\)"),
        ({"C": np.ones((3, 1))}, r"controller\.C: has shape \(3, 1\), it must be \(4, 1\)"),
        ({"D": np.ones((4, 2))}, r"controller\.D: has shape \(4, 2\), it must be \(4, 1\)"),
        ({"inputs": ()}, r"controller\.B: has shape \(1, 1\), it must be \(1, 0\)"),
        ({"A": [[np.nan]]}, r"controller\.A: entry \(0, 0\) is nan; every entry must be finite"),
        ({"D": [[0], [0], [np.inf], [0]]}, r"controller\.D: entry \(2, 0\) is inf; every entry must be finite"),
        (
            {"A": [[1.0001]]},
            r"controller\.A: unstable by itself, an eigenvalue has magnitude 1\.0001; it must be at mo",
        ),
        ({"A": [[-1.2]]}, r"controller\.A: unstable by itself, an eigenvalue has magnitude 1\.2;"),
        ({"period": 0.0}, r"controller\.period = 0\.0: must be at least 1e-07 s"),
        ({"period": -1e-4}, r"controller\.period = -0\.0001: must be at least 1e-07 s"),
        ({"period": np.nan}, r"controller\.period = nan: must be at least 1e-07 s"),
        ({"period": 1e-8}, r"controller\.period = 1e-08: must be at least 1e-07 s"),
        ({"period": 1e300}, r"controller\.period = 1e\+300: must be at most 1e\+09 s"),
        ({"delay": 1e9}, r"controller\.delay = 1000000000\.0: must be zero, or from 1e-07 to 1 s"),
        ({"fade": 1e-300}, r"controller\.fade = 1e-300: must be zero or at least 1e-09 s"),
        ({"D": [[1e31], [0], [0], [0]]}, r"controller\.D: has entries beyond 1e\+30"),
        ({"delay": 1e-300}, r"controller\.delay = 1e-300: must be zero, or from 1e-07 to 1 s"),
        ({"delay": 0.5}, r"controller\.delay = 0\.5: .* at most 100 periods"),
        ({"delay": -1e-4}, r"controller\.delay = -0\.0001: must be zero, or from 1e-07 to 1 s"),
        ({"delay": np.nan}, r"controller\.delay = nan: must be zero, or from 1e-07 to 1 s"),
        ({"voltage_limit": 0.0}, r"controller\.voltage_limit = 0\.0: must be a positive number"),
        ({"voltage_limit": np.inf}, r"controller\.voltage_limit = inf: must be a positive number"),
        ({"bits": 1}, r"controller\.bits = 1: must be a whole number from 2 to 52, or none"),
        ({"bits": 64}, r"controller\.bits = 64: must be a whole number from 2 to 52, or none"),
        ({"anti_windup": np.ones((2, 4))}, r"controller\.anti_windup: has shape \(2, 4\), it must be \(1, 4\)"),
        (
            {"anti_windup": [[0, 0, np.nan, 0]]},
            r"controller\.anti_windup: entry \(0, 2\) is nan; every entry must be f",
        ),
        (
            {"anti_windup": [[-0.2] * 4]},
            r"controller\.anti_windup: unstable while the commands are limited, an eigenvalue of A − anti_windup·C has "
            r"magnitude 1\.3; it must be at most 1",
        ),
        ({"switch_on": -1.0}, r"controller\.switch_on = -1\.0: must be zero or positive \[s\]"),
        ({"fade": np.inf}, r"controller\.fade = inf: must be zero or positive \[s\]"),
    ],
)
def test_a_law_that_cannot_run_is_refused_with_what_would_fit(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        law(**changes)


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("stroke frnt-left", "stroke front-left"),
        ("stroke", "stroke front-left"),
        ("ground_velocity front-left", "ground_velocity front-left z"),
        ("chamber_pressure rear-right 3", "chamber_pressure rear-right 2"),
        ("cg_aceleration z", "cg_acceleration z"),
    ],
)
def test_an_unknown_channel_is_refused_with_one_that_is_near(name: str, near: str) -> None:
    with pytest.raises(InputError, match=rf"^controller\.inputs: channel '{name}' is unknown; near it are: .*'{near}'"):
        law(inputs=(name,))


@pytest.mark.parametrize("matrix", [[[1.0]], [[-1.0]]])
def test_an_integrator_is_allowed(matrix: list[list[float]]) -> None:
    assert law(A=matrix).states == 1


def test_complex_entries_are_refused() -> None:
    with pytest.raises(InputError, match=r"^controller\.A"):
        law(A=np.array([[0.5 + 0.1j]]))


def test_a_law_cannot_be_changed_afterwards() -> None:
    with pytest.raises(ValueError, match="read-only"):
        law().A[0, 0] = 3.0


def test_a_law_does_not_change_with_the_arrays_it_was_made_from() -> None:
    matrix = np.array([[0.5]])
    made = law(A=matrix)
    matrix[0, 0] = 0.9
    assert made.A[0, 0] == 0.5


def test_without_a_stated_delay_a_command_comes_one_period_after_its_sample() -> None:
    assert (law(period=2e-4).latency, law(period=2e-4, delay=0.0).latency) == (2e-4, 0.0)


# --- channels -----------------------------------------------------------------------------------------------------


BELOW = tuple(name for name in channel_names() if not is_upstream(name))
"""Upstream a sensor must stand first (`tests/control/test_preview.py`)."""


@pytest.mark.parametrize("names", [(), STROKES[:2], BELOW], ids=["none", "two", "all"])
def test_every_channel_can_be_measured(names: tuple[str, ...]) -> None:
    p = len(names)
    made = law(B=np.zeros((1, p)), D=np.zeros((4, p)), inputs=tuple(names))
    rows = IDEAL.rows(made.inputs, parse_scenario({}).plant, 0)
    assert rows.shape[0] == p
    assert np.all(np.abs(rows).sum(axis=1) > 0)


# --- from python-control ------------------------------------------------------------------------------------------


def system(dt: Any = 1e-4, **labels: Any) -> control.StateSpace:
    """Four states in a row, each valve from its own stroke."""
    a, b, c = np.diag([0.1, 0.2, 0.3, 0.4]), np.eye(4), np.diag([1.0, 2.0, 3.0, 4.0])
    return control.ss(a, b, c, np.zeros((4, 4)), dt, **{"inputs": STROKES, "outputs": VALVES, **labels})


def test_a_labelled_state_space_is_the_law() -> None:
    found, given_system = Controller.from_statespace(system(), delay=3e-4, bits=None, voltage_limit=5.0), system()
    for name in MATRICES:
        np.testing.assert_array_equal(getattr(found, name), getattr(given_system, name))
    assert (found.inputs, found.period, found.delay) == (tuple(STROKES), 1e-4, 3e-4)
    assert (found.bits, found.voltage_limit) == (None, 5.0)


def test_labelled_outputs_are_put_into_the_order_of_the_mounts() -> None:
    order = [2, 0, 3, 1]
    found = Controller.from_statespace(system(outputs=[VALVES[k] for k in order]))
    # Output k of the system, of gain k + 1, goes to valve order[k].
    np.testing.assert_array_equal(np.array([found.C[valve].sum() for valve in order]), [1.0, 2.0, 3.0, 4.0])


def test_unlabelled_outputs_are_the_valves_in_order() -> None:
    np.testing.assert_array_equal(Controller.from_statespace(system(outputs=4)).C, system().C)


def test_a_misspelled_valve_is_refused() -> None:
    # In this order: taken by position, two valves would be exchanged.
    outputs = [VALVES[1], VALVES[0], VALVES[2], "valve_command rear-rihgt"]
    with pytest.raises(InputError, match="valve_command rear-rihgt"):
        Controller.from_statespace(system(outputs=outputs))


def test_outputs_may_be_named_by_their_mounts_alone() -> None:
    order = [1, 0, 2, 3]
    outputs = [VALVES[k].removeprefix("valve_command ") for k in order]
    found = Controller.from_statespace(system(outputs=outputs))
    np.testing.assert_array_equal(np.array([found.C[valve].sum() for valve in order]), [1.0, 2.0, 3.0, 4.0])


def test_outputs_of_which_only_some_name_valves_are_refused() -> None:
    with pytest.raises(InputError, match="output 'b' beside those that name valves"):
        Controller.from_statespace(system(outputs=[VALVES[0], "b", VALVES[2], VALVES[1]]))


def test_channels_may_be_given_instead_of_labels() -> None:
    assert Controller.from_statespace(system(inputs=4), inputs=STROKES).inputs == tuple(STROKES)


def test_labels_that_are_no_channels_are_refused() -> None:
    with pytest.raises(InputError, match=r"channel 'u\[0\]' is unknown"):
        Controller.from_statespace(system(inputs=4))


@pytest.mark.parametrize("dt", [None, True, 0])
def test_a_law_without_a_sampling_period_is_refused(dt: Any) -> None:
    with pytest.raises(InputError, match=rf"^controller: dt = {dt} is no sampling period; discretise the law first"):
        Controller.from_statespace(system(dt))


def test_a_period_other_than_the_laws_own_is_refused() -> None:
    with pytest.raises(InputError, match=r"^controller\.period = 0\.0002 s differs from the law's dt = 0\.0001 s"):
        Controller.from_statespace(system(), period=2e-4)


def test_a_law_for_three_valves_is_refused() -> None:
    with pytest.raises(InputError, match=r"^controller: has 3 outputs, it must have 4, one per valve"):
        Controller.from_statespace(system()[:3, :])


def test_transfer_functions_become_the_law_of_the_same_response() -> None:
    numerators = [[[0.1 * (i + 1) + 0.01 * j, 0.02] for j in range(4)] for i in range(4)]
    denominators = [[[1.0, -0.5 - 0.05 * i - 0.02 * j] for j in range(4)] for i in range(4)]
    transfer = control.tf(numerators, denominators, 1e-4, inputs=STROKES, outputs=VALVES)
    found = Controller.from_statespace(transfer)
    assert (found.inputs, found.period) == (tuple(STROKES), 1e-4)
    for hertz in (0.0, 10.0, 1000.0, 5000.0):
        z = np.exp(2j * np.pi * hertz * 1e-4)
        expected = [
            [np.polyval(n, z) / np.polyval(d, z) for n, d in zip(*pair, strict=True)]
            for pair in zip(numerators, denominators, strict=True)
        ]
        # Realisation of sixteen poles between 0.5 and 0.71: gains of 2, conditioned to some 1e3.
        np.testing.assert_allclose(response(found, z), expected, rtol=0, atol=1e-11)


# --- to a file and back -------------------------------------------------------------------------------------------

entries = st.floats(-1e6, 1e6)


@st.composite
def laws(draw: st.DrawFn) -> Controller:
    n, p = draw(st.integers(0, 3)), draw(st.integers(0, 3))
    A = draw(arrays(float, (n, n), elements=st.floats(-0.3, 0.3)))  # rows sum to less than one: stable
    B, C, D = (draw(arrays(float, shape, elements=entries)) for shape in ((n, p), (4, n), (4, p)))
    inputs = draw(st.lists(st.sampled_from(channel_names()), min_size=p, max_size=p, unique=True))
    period = draw(st.floats(1e-6, 1.0))
    windup = draw(st.booleans()) and anti_windup_gain(A, C, 1e-4, 0.01)
    return Controller(
        A,
        B,
        C,
        D,
        tuple(inputs),
        period=period,
        delay=draw(st.none() | st.just(0.0) | st.floats(1e-7, min(1.0, 100 * period))),
        voltage_limit=draw(st.floats(0.1, 100.0)),
        bits=draw(st.none() | st.integers(2, 52)),
        anti_windup=windup if isinstance(windup, np.ndarray) and np.abs(windup).max(initial=0.0) < 1e30 else None,
        switch_on=draw(st.just(0.0) | st.floats(1e-9, 10.0)),
        fade=draw(st.just(0.0) | st.floats(1e-9, 10.0)),
    )


@given(laws())
def test_a_stored_law_is_the_same_to_the_last_bit(tmp_path_factory: pytest.TempPathFactory, law: Controller) -> None:
    path = tmp_path_factory.mktemp("laws") / "law.json"
    law.save(path)
    assert_equal(Controller.load(path), law)


def test_a_stored_law_is_strict_json_that_names_its_units(tmp_path: Path) -> None:
    law(delay=5e-5).save(tmp_path / "law.json")
    table = json.loads((tmp_path / "law.json").read_text())
    assert (table["period_s"], table["delay_s"], table["voltage_limit_v"]) == (1e-4, 5e-5, 10.0)
    assert (table["inputs"], table["outputs"]) == (["stroke front-left"], VALVES)


def test_what_may_be_left_out_has_its_default() -> None:
    table = {"inputs": ["stroke front-left"], "period_s": 1e-4, "A": [], "B": [], "C": [], "D": [[1.0]] * 4}
    found = Controller.from_dict(table)
    assert (found.delay, found.voltage_limit, found.bits, found.states) == (None, 10.0, 16, 0)
    assert (found.anti_windup, found.switch_on, found.fade) == (None, 0.0, 0.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"A": None}, "controller: not a law"),
        ({"A": [[0.1, 0.2]]}, r"controller\.A: has shape \(1, 2\), it must be \(1, 1\)"),
        ({"B": [["0.1"]]}, r"controller\.B: has entries that are no numbers"),
        ({"A": [[float("nan")]]}, r"controller\.A: entry \(0, 0\) is nan"),
        ({"outputs": VALVES[::-1]}, r"controller\.outputs = \['valve_command rear-right', .*: must be \["),
        ({"inputs": ["strok front-left"]}, r"controller\.inputs: channel 'strok front-left' is unknown"),
        ({"period_s": "1e-4"}, r"controller\.period_s = '1e-4': must be a number"),
        ({"bits": "many"}, r"controller\.bits = many: must be a whole number"),
        ({"delay": 1e-3}, r"controller\.delay: unknown key; did you mean 'delay_s'\? allowed: inputs, period_s"),
        (
            {"inputs": ["stroke front-left"] * 2, "B": [[1.0, 1.0]], "D": [[0.0, 0.0]] * 4},
            r"controller\.inputs: 'stroke front-left' stands there twice",
        ),
    ],
)
def test_a_damaged_table_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        Controller.from_dict({**law().to_dict(), **change})


@pytest.mark.parametrize("key", ["inputs", "period_s", *MATRICES])
def test_a_table_without_something_needed_is_refused(key: str) -> None:
    table = law().to_dict()
    del table[key]
    with pytest.raises(InputError, match=f"^controller: {key} is missing; needed are inputs, period_s, A, B, C, D"):
        Controller.from_dict(table)


@pytest.mark.parametrize(
    ("text", "message"), [(None, "cannot be read"), ("{", "cannot be read"), ("[1]", "must hold one JSON object")]
)
def test_a_file_that_is_no_law_is_named(tmp_path: Path, text: str | None, message: str) -> None:
    path = tmp_path / "law.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=rf"^control\.file = '.*law\.json': {message}"):
        Controller.load(path)


# --- side by side -------------------------------------------------------------------------------------------------


def test_laws_side_by_side_add_up() -> None:
    one = law(A=[[0.4]], C=[[1.0], [0.0], [0.0], [2.0]], D=[[0.5], [1.5], [2.5], [3.5]], inputs=("stroke front-left",))
    other = law(
        A=np.diag([0.2, 0.7]),
        B=[[1.0, 0.5], [0.0, 3.0]],
        C=np.arange(8.0).reshape(4, 2),
        D=np.arange(8.0, 16.0).reshape(4, 2),
        inputs=("stroke rear-right", "stroke front-left"),
    )
    both = stack([one, other])
    assert both.inputs == ("stroke front-left", "stroke rear-right")
    z = np.exp(0.3j)
    expected = np.zeros((4, 2), complex)
    expected[:, [0]] += response(one, z)
    expected[:, [1, 0]] += response(other, z)
    np.testing.assert_allclose(response(both, z), expected, rtol=1e-13)


@pytest.mark.parametrize(
    ("name", "value"),
    [("period", 2e-4), ("delay", 5e-5), ("voltage_limit", 5.0), ("bits", None), ("switch_on", 0.1), ("fade", 0.2)],
)
def test_laws_side_by_side_must_share_their_clock_and_converter(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=rf"^controller\.{name}: {value} beside "):
        stack([law(), law(**{name: value})])


def test_one_law_alone_is_itself() -> None:
    assert_equal(stack([law()]), law())


# --- anti-windup --------------------------------------------------------------------------------------------------


def integrator(gain: float = 1.0, **settings: Any) -> Controller:
    """The sum of a stroke, to one valve."""
    return law(A=[[1.0]], C=[[gain], [0], [0], [0]], **settings)


@pytest.mark.parametrize("time", [1e-3, 0.02, 0.5])
@pytest.mark.parametrize("gain", [1e-3, 1.0, 1e6])
def test_an_integrator_is_taken_back_with_the_stated_time_constant(time: float, gain: float) -> None:
    found = integrator(gain).with_anti_windup(time)
    assert found.anti_windup is not None
    pole = float((found.A - found.anti_windup @ found.C)[0, 0])
    # The sampled optimum lags the continuous one by half a sample.
    assert -1e-4 / np.log(pole) == pytest.approx(time, abs=0.55e-4)


def test_the_default_does_not_depend_on_how_states_are_scaled() -> None:
    draw = np.random.default_rng(4)
    A = draw.normal(size=(6, 6))
    A *= 0.999 / np.abs(np.linalg.eigvals(A)).max()
    C, T = draw.normal(size=(4, 6)), draw.normal(size=(6, 6)) * 10.0 ** draw.uniform(-3, 3, 6)
    plain = anti_windup_gain(A, C, 1e-4, 0.02)
    turned = anti_windup_gain(np.linalg.solve(T, A @ T), C @ T, 1e-4, 0.02)
    # T is conditioned to some 1e5, and the Gramian squares that.
    np.testing.assert_allclose(T @ turned, plain, rtol=1e-4, atol=1e-5 * np.abs(plain).max())


def test_a_hundred_states_stay_stable_while_limited() -> None:
    draw = np.random.default_rng(1)
    A = draw.normal(size=(100, 100))
    A *= 1.0 / np.abs(np.linalg.eigvals(A)).max()
    C = draw.normal(size=(4, 100))
    assert limited_radius(A, C, anti_windup_gain(A, C, 1e-4, 0.02)) < 1.0 - 1e-3


def test_an_integrator_that_shows_in_no_command_cannot_be_held() -> None:
    with pytest.raises(InputError, match="shows in no command"):
        law(
            A=np.diag([1.0, 0.5]), B=[[1.0], [1.0]], C=np.hstack([np.zeros((4, 1)), np.ones((4, 1))])
        ).with_anti_windup()


def test_a_time_shorter_than_a_sample_is_refused() -> None:
    with pytest.raises(InputError, match=r"time = 1e-05 s must be at least the controller's period, 0\.0001 s"):
        integrator().with_anti_windup(1e-5)


# --- frequency response -------------------------------------------------------------------------------------------


def test_the_response_is_that_of_the_held_and_delayed_law() -> None:
    # The fundamental of what is held, by Fourier's integral over one period of a sine of 64 samples.
    made, samples, fine = law(D=[[0.3], [0], [1], [2]], delay=1.5e-4), 64, 400
    hertz = 1.0 / (samples * made.period)
    z = np.exp(2j * np.pi / samples)
    plain = response(made, z)[:, 0]
    k = np.arange(samples * fine)
    held = plain[:, None] * z ** (k // fine)
    fundamental = (held * np.exp(-2j * np.pi * (k + 0.5) / k.size)).mean(axis=1)
    expected = fundamental * np.exp(-2j * np.pi * hertz * 1.5e-4)
    # The midpoint rule over 400 points of a sample: (2π/25600)²/24.
    np.testing.assert_allclose(made.response(hertz)[0, :, 0], expected, rtol=1e-7)
