"""The native corner: struct offsets, installing and restoring, the callbacks' equations, batches and threads."""

import ctypes
import os
import subprocess
import sys
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import mujoco.batch
import numpy as np
import pytest
from mujoco.introspect import structs
from oracles import linear, machine

from ehamj.control.loop import no_loop
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.supply import Supply
from ehamj.memory import ISOLATOR, activations, exchange, inputs, isolators, step
from ehamj.mujoco import ForeignCallbackError, hydraulics
from ehamj.mujoco.advance import advance
from ehamj.mujoco.callbacks import callbacks
from ehamj.mujoco.equilibrium import Inputs, equilibrium, rates
from ehamj.mujoco.hold import default_timer, installed, library
from ehamj.mujoco.model import build_model
from ehamj.mujoco.offsets import LayoutError, Offsets, offsets
from ehamj.mujoco.rows import Recording
from ehamj.plant.axes import DOF_OF_JOINT
from ehamj.plant.machine import Machine
from ehamj.plant.mounts import MOUNTS
from ehamj.plant.plant import Plant
from ehamj.run.many import simulate_many
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario
from ehamj.stopped import CHAMBER_1_EMPTY, DONE, NOT_FINITE

STEP = 1e-4
TOPOLOGIES = ("sliding", "tied")
DOFS = list(DOF_OF_JOINT)
Pair = Callable[[str], tuple[Plant, machine.OracleMachine]]


def default_model(plates: str = "tied") -> mujoco.MjModel:
    return build_model(parse_scenario({"plates": plates}).plant, STEP)


def started(model: mujoco.MjModel, control: Any = (0.0, 0.0, 0.0, 0.0)) -> mujoco.MjData:
    """At the static equilibrium, without inputs, driven by ctrl alone."""
    data = mujoco.MjData(model)
    with hydraulics():
        equilibrium(model, data, Inputs.rest(model))
    data.userdata[:] = 0.0
    data.ctrl[:] = control
    return data


def state(data: mujoco.MjData) -> np.ndarray:
    return np.concatenate([data.qpos, data.qvel, data.act])


def recording(model: mujoco.MjModel, every: int, count: int) -> Recording:
    return Recording.of(model, no_loop(len(MOUNTS)), every, count)


def timer() -> int | None:
    return ctypes.c_void_p.in_dll(library(), "mjcb_time").value


# offsets


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_offsets_lead_to_the_fields_of_any_model(plates: str) -> None:
    model = default_model(plates)
    data = mujoco.MjData(model)
    data.time = 0.7
    at = offsets()
    assert ctypes.c_double.from_address(data._address + at.time).value == 0.7
    for name in Offsets._fields[1:]:
        owner = model if name == "actuator_user" else data
        found = ctypes.c_void_p.from_address(owner._address + getattr(at, name)).value
        assert found == getattr(owner, name).ctypes.data, name


def test_a_struct_laid_out_otherwise_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    other = deepcopy(structs.STRUCTS["mjData"])
    names = [field.name for field in other.fields]
    swapped = list(other.fields)
    one, two = names.index("qpos"), names.index("qvel")
    swapped[one], swapped[two] = swapped[two], swapped[one]
    object.__setattr__(other, "fields", tuple(swapped))
    monkeypatch.setitem(structs.STRUCTS, "mjData", other)
    with pytest.raises(LayoutError, match="qpos, qvel are not where they should be"):
        offsets.__wrapped__()


# installing


def test_callbacks_are_installed_within_and_gone_afterwards() -> None:
    with hydraulics():
        assert all(installed().values())
    assert not any(installed().values())


def test_nested_use_keeps_them_until_the_outermost_ends() -> None:
    with hydraulics():
        with hydraulics():
            pass
        assert all(installed().values())


def test_an_error_within_leaves_nothing_behind() -> None:
    with pytest.raises(ZeroDivisionError), hydraulics():
        1 / 0  # noqa: B018
    assert not any(installed().values())


def test_the_profiling_timer_is_off_within_and_restored() -> None:
    before = timer()
    assert before is not None
    with hydraulics():
        assert timer() is None
    assert timer() == before


@pytest.mark.parametrize("off", [False, True])
def test_the_default_timer_is_switched_for_timings_and_restored(off: bool) -> None:
    before = timer()
    with default_timer(off):
        assert timer() == (None if off else before)
    assert timer() == before


@pytest.mark.parametrize("compiled", [True, False])
def test_a_foreign_callback_is_refused_and_left_alone(compiled: bool) -> None:
    model = default_model()
    data = mujoco.MjData(model)
    with hydraulics():
        pass
    if not compiled:  # as in a fresh process
        callbacks.cache_clear()
        offsets.cache_clear()
    calls: list[int] = []
    mujoco.set_mjcb_passive(lambda model, data: calls.append(1))
    try:
        with pytest.raises(ForeignCallbackError, match="mjcb_passive is set by other code"), hydraulics():
            pass
        mujoco.mj_forward(model, data)
    finally:
        mujoco.set_mjcb_passive(None)
    assert calls == [1]


# equations


def random_state(seed: int) -> tuple[machine.OracleState, Inputs]:
    """A state far from rest in everything that acts linearly or through the oil.

    The machine itself hardly moves, 1e-10 m and 1e-5 m/s: the oracle's kinematics are linear. Strokes come from the
    ground.
    """
    draw = np.random.default_rng(seed).uniform
    oracle = machine.OracleState(
        draw(-1e-10, 1e-10, 6),
        draw(-1e-5, 1e-5, 6),
        draw(-25.0, 25.0, 4),
        draw(-1e4, 1e4, 4),
        draw(1e5, 69e5, (4, 2)),
    )
    return oracle, Inputs(draw(-1e-4, 1e-4, (4, 3)), draw(-1e-2, 1e-2, (4, 3)), draw(-12.0, 12.0, 4))


UNEVEN = (1.0, 1.3, 0.7, 1.1)
"""Scales that make no two mounts alike."""


def default_pair(plates: str) -> tuple[Plant, machine.OracleMachine]:
    return parse_scenario({"plates": plates}).plant, machine.default_machine()


def uneven_pair(plates: str) -> tuple[Plant, machine.OracleMachine]:
    """Mounts, valves and oil unlike each other, everything off centre; the same for the oracle, by value."""
    positions = ((0.95, 0.62), (0.8, -0.55), (-0.9, 0.7), (-1.0, -0.48))
    cg, inertia = (0.12, -0.07, 0.9), (1500.0, 2500.0, 3200.0)
    ours = tuple(
        Actuator(
            piston_area=3e-2 * s,
            chamber_volume=6e-4 / s,
            bulk_modulus=1e9 * s,
            membrane_stiffness=5e8 * s,
            membrane_damping=4e3 / s,
            lateral_stiffness=2e8 / s,
            lateral_damping=3e4 * s,
            plate_mass=15 / s,
            flow_gain=2e-6 * s,
            flow_pressure=7e-11 / s,
            edge_leakage_share=0.3 * s,
            laminar_ratio=1e-2 * s,
            valve_gain=1.5 * s,
            valve_frequency=1200 * s,
            valve_damping=0.7 / s,
            spool_drive_limit=5e6 / s,
            spool_stroke=15 * s,
            voltage_limit=8 / s,
        )
        for s in UNEVEN
    )
    theirs = tuple(
        machine.OracleActuator(
            A_p=3e-2 * s,
            V_t=6e-4 / s,
            beta=1e9 * s,
            K_L=5e8 * s,
            C=4e3 / s,
            k_lat=2e8 / s,
            c_lat=3e4 * s,
            m_plate=15 / s,
            K_Q=2e-6 * s,
            g0=7e-11 / s * 0.3 * s,
            cross=7e-11 / s * (1 - 0.3 * s),
            eps=1e-2 * s,
            K_v=1.5 * s,
            omega_v=1200 * s,
            zeta=0.7 / s,
            a_max=5e6 / s,
            x_max=15 * s,
            v_max=8 / s,
            P_s=90e5,
            P_t=1e5,
        )
        for s in UNEVEN
    )
    plant = replace(
        parse_scenario({"plates": plates}).plant,
        machine=Machine(mass=3500.0, inertia=inertia, cg=cg),
        positions=tuple((*at, 0.0) for at in positions),
        actuators=ours,
        supply=Supply(pressure=90e5, tank_pressure=1e5),
    )
    return plant, machine.OracleMachine(mass=3500.0, inertia=inertia, cg=cg, mounts=positions, actuators=theirs)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("pair", [default_pair, uneven_pair])
@pytest.mark.parametrize(("plates", "tolerance"), [("tied", 1e-9), ("sliding", 1e-6)])
def test_rates_are_the_oracles(plates: str, tolerance: float, pair: Pair, seed: int) -> None:
    oracle, inputs = random_state(seed)
    plant, theirs = pair(plates)
    model = build_model(plant, STEP)
    data = mujoco.MjData(model)
    heights = linear.foot_maps(linear.LinearMachine(mounts=tuple(at[:2] for at in plant.positions)))[2]
    motion = np.zeros((2, model.nq))
    motion[:, DOFS] = oracle.q, oracle.qd
    motion[:, 6:] = (motion[:, DOFS] @ heights.T)[:, : model.nq - 6]
    act = np.column_stack([oracle.spool, oracle.spool_rate, oracle.pressure])
    with hydraulics():
        found = rates(model, data, np.concatenate([*motion, act.ravel()]), inputs)
    expected = machine.rates(theirs, oracle, inputs.command, inputs.displacement, inputs.velocity)
    acceleration = found[model.nq : model.nq + model.nv][DOFS]
    states = activations(model, found[model.nq + model.nv :]).isolators
    spool_rate, spool_bend, *pressure_rate = (states[name] for name in states.dtype.names)
    # Tied: second-order kinematics of 1e-10 rad and 1e-5 m/s. Sliding: the plate's tie yields by 1e-7 of its force.
    assert np.abs(acceleration - expected.qd).max() <= tolerance * np.abs(expected.qd).max()
    np.testing.assert_array_equal(spool_rate, oracle.spool_rate)
    # The oil knows nothing of the plates: rounding.
    np.testing.assert_allclose(spool_bend, expected.spool_rate, rtol=1e-12)
    scale = np.abs(expected.pressure).max()
    np.testing.assert_allclose(np.transpose(pressure_rate), expected.pressure, rtol=0, atol=1e-12 * scale)


def test_inputs_follow_their_cubics_at_the_time_of_a_stage() -> None:
    # A cubic is its own Hermite interpolant: ground and command must be exact anywhere inside the step.
    ground, command = np.polynomial.Polynomial([1e-5, 2e-3, -0.3, 40.0]), np.polynomial.Polynomial([1.0, 50, -9, 4e4])
    begin, length, moment = 0.25, 0.01, 0.2537
    model = default_model()
    data = mujoco.MjData(model)
    data.time = moment
    step(data)["start"], step(data)["rate"] = begin, 1 / length
    mounts = exchange(data, 4)
    for polynomial, names in ((ground, ("ground_x", "ground_y", "ground_z")), (command, ("open_loop",))):
        ends = np.array([begin, begin + length]) - begin
        for name in names:
            mounts[name]["value"], mounts[name]["end_value"] = polynomial(ends)
            mounts[name]["slope"], mounts[name]["end_slope"] = length * polynomial.deriv()(ends)
    with hydraulics():
        mujoco.mj_forward(model, data)
    since = moment - begin
    held = mujoco.MjData(model)
    still = Inputs(np.full((4, 3), ground(since)), np.full((4, 3), ground.deriv()(since)), np.full(4, command(since)))
    with hydraulics():
        rates(model, held, state(data), still)
    np.testing.assert_allclose(data.act_dot, held.act_dot, rtol=1e-10, atol=1e-6)
    np.testing.assert_allclose(data.qacc, held.qacc, rtol=1e-10, atol=1e-10)


# stepping


@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_advance_is_the_engines_own_step(plates: str) -> None:
    model = default_model(plates)
    control = np.array([1.0, -2.0, 0.5, 4.0])
    ours, engine = started(model, control), started(model, control)
    nothing = inputs(300, len(MOUNTS))
    with hydraulics():
        stopped, recorded = advance(model, ours, 0, 300, (nothing, nothing), recording(model, 100, 3))
        mujoco.mj_step(model, engine, nstep=300)
    assert (stopped.steps, stopped.status, recorded) == (300, DONE, 3)
    np.testing.assert_array_equal(state(ours), state(engine))


def test_advance_records_the_state_at_the_beginning_of_a_step() -> None:
    model = default_model()
    control = np.array([1.0, -2.0, 0.5, 4.0])
    ours, engine = started(model, control), started(model, control)
    record, nothing = recording(model, 10, 3), inputs(21, len(MOUNTS))
    with hydraulics():
        _, recorded = advance(model, ours, 0, 20, (nothing, nothing), record, last=True)
        assert recorded == 3
        for row in range(3):
            mujoco.mj_forward(model, engine)
            for field in ("qpos", "qvel", "qacc", "act"):
                np.testing.assert_array_equal(getattr(record.rows, field)[row], getattr(engine, field))
            mujoco.mj_step(model, engine, nstep=10)


def test_a_state_that_is_not_finite_stops_with_its_mount() -> None:
    model = default_model()
    data = started(model)
    activations(model, data.act).isolators["pressure_2"][2] = np.inf
    nothing = inputs(10, len(MOUNTS))
    with hydraulics():
        stopped, recorded = advance(model, data, 0, 10, (nothing, nothing), recording(model, 1, 10))
    assert (stopped, recorded) == ((0, NOT_FINITE, 2), 0)


def test_an_empty_chamber_stops_with_its_mount() -> None:
    model = default_model()
    data = started(model)
    # The ground below the second mount is lifted by 9 mm; 8.475 mm empty the chamber.
    start = inputs(10, len(MOUNTS))
    start[:, 1, 2, 0] = 9e-3
    with hydraulics():
        stopped, _ = advance(model, data, 0, 10, (start, start), recording(model, 1, 10))
    assert stopped == (0, CHAMBER_1_EMPTY, 1)


# batches and threads

CONTROLS = np.array([[1.0, -2.0, 0.5, 4.0], [0.0, 0.0, 0.0, 0.0], [9.0, 11.0, -3.0, 2.0]])


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("plates", TOPOLOGIES)
def test_a_batch_gives_what_single_simulations_give(plates: str, threads: int) -> None:
    model = default_model(plates)
    singles = [started(model, control) for control in CONTROLS]
    batch = mujoco.batch.Batch(model, nsim=len(CONTROLS), nthread=threads)
    for field in ("qpos", "act", "ctrl"):
        batch.bind(field)[:] = [getattr(single, field) for single in singles]
    with hydraulics():
        batch.step(nstep=200)
        for single in singles:
            mujoco.mj_step(model, single, nstep=200)
    for field in ("qpos", "qvel", "act"):
        np.testing.assert_array_equal(batch.bind(field), [getattr(single, field) for single in singles])


def test_each_simulation_of_a_batch_can_have_parameters_of_its_own() -> None:
    model = default_model()
    scales = np.array([1.0, 0.5, 2.0])
    batch = mujoco.batch.Batch(model, nsim=3, nthread=2)
    start = started(model, CONTROLS[0])
    for field in ("qpos", "act", "ctrl"):
        batch.bind(field)[:] = getattr(start, field)
    table = batch.expand("actuator_user").view(ISOLATOR)
    table["flow_gain"] *= scales[:, None, None]
    with hydraulics():
        batch.step(nstep=200)
    found = batch.bind("act").copy()
    for k, scale in enumerate(scales):
        single = deepcopy(start)
        other = deepcopy(model)
        isolators(other)["flow_gain"] *= scale
        with hydraulics():
            mujoco.mj_step(other, single, nstep=200)
        np.testing.assert_array_equal(found[k], single.act)


def variants() -> list[Scenario]:
    """Six unlike runs, long enough to overlap on two threads."""
    amplitudes = [0.1, 0.5, 1.0, 2.0, 4.0, 9.0]
    plates = ["tied", "sliding"] * 3
    return [
        load_scenario("benchmark", ["duration=0.2", f"control.signals.0.amplitude={a}", f"plates='{p}'", *WITH_PLATES])
        for a, p in zip(amplitudes, plates, strict=True)
    ]


WITH_PLATES = ("machine.mass=4000", "actuators.isolator.plate_mass=14")


def test_two_threads_give_what_one_after_the_other_gives() -> None:
    together = simulate_many(variants(), threads=2)
    for parallel, scenario in zip(together, variants(), strict=True):
        assert parallel.dataset.identical(simulate(scenario).dataset)


# the cache


def test_everything_works_where_no_cache_can_be_written(tmp_path: Path) -> None:
    blocked = tmp_path / "blocked"
    blocked.write_text("not a folder")  # nobody can write below a file, not even root
    code = "import ehamj; print(ehamj.simulate(ehamj.load_scenario('benchmark', ['duration=0.01'])).complete)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "EHAMJ_CACHE_DIR": str(blocked)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout.strip()) == (0, "True"), done.stderr
    assert blocked.read_text() == "not a folder"
