"""Run one scenario, or many → Result."""

import math
import time as clock
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import mujoco
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.control import AnyController, Controller, PythonController, as_controller
from ehamj.control.commands import Passive
from ehamj.control.compiled.loop import Loop, make_loop
from ehamj.control.noise import ReadingNoise
from ehamj.errors import InputError, SimulationFailed
from ehamj.forces import Load
from ehamj.ground import Motion
from ehamj.judge.summary import summarise
from ehamj.memory import LEDGER_STATES, N_INPUTS, N_STATES, SUPPLY_STATES
from ehamj.mujoco import hydraulics
from ehamj.mujoco.advance import (
    CHAMBER_1_EMPTY,
    CHAMBER_2_EMPTY,
    DONE,
    LAW_FAILED,
    N_TALLY,
    NOT_LOADED,
    Stopped,
    advance,
    columns,
    compile_loop,
    row_size,
)
from ehamj.mujoco.equilibrium import EquilibriumError, Inputs, equilibrium, jacobian
from ehamj.mujoco.model import build_model, drawn_xml, reduced
from ehamj.plant.axes import DOF_OF_JOINT
from ehamj.plant.kinematics import points_motion
from ehamj.plant.mounts import MOUNTS, N_MOUNTS
from ehamj.plant.plant import Plant
from ehamj.result import CONTROLLER_FILE, Result, make_dataset
from ehamj.run.chambers import Chambers
from ehamj.scenario.model import Law, Scenario
from ehamj.signals import Signal

Array = NDArray[np.float64]
Progress = Callable[[float], None]

STRETCH = 2048
"""Steps between two returns to Python."""

SHORTEST_STEP = 2e-6
"""Step below which the automatic choice gives up [s]: periods that have no common divisor were hardly meant."""

STEP_PER_TIME_CONSTANT = 1.2
"""Largest |λ|·step of the automatic step. RK4 is stable to 2.8; at 1.2 the fastest mode itself is followed to a few per
cent and motions below 100 Hz to 1e-4."""


class Incomplete(SimulationFailed):
    """A simulation that stopped early; ``result`` holds what was computed until then."""

    def __init__(self, message: str, result: Result) -> None:
        super().__init__(message)
        self.result = result


@dataclass(frozen=True)
class _Prepared:
    """A scenario ready to step."""

    scenario: Scenario
    model: mujoco.MjModel
    data: mujoco.MjData
    motion: Motion
    commands: tuple[Signal, ...]
    load: Load
    controller: AnyController | None
    loop: Loop
    noise: ReadingNoise | None
    every: int
    steps: int


def simulate(scenario: Scenario, progress: Progress | None = None, controller: Any = None) -> Result:
    """Run a scenario.

    Args:
        scenario: what to simulate.
        progress: called now and then with the fraction done.
        controller: runs instead of the scenario's control: a `ehamj.Controller`, a bank of them, a
            `ehamj.PythonController`, or a python-control system with ``dt`` and channels as input labels.

    Raises:
        InputError: if the scenario cannot be run as it is.
        Incomplete: if the simulation fails; its ``result`` holds what was computed until then.
    """
    started = clock.perf_counter()
    controller = None if controller is None else as_controller(controller)
    with hydraulics():
        prepared = _prepare(scenario, controller)
        rows, tally, stopped, wall = _run(prepared, progress)
    values = _channels(prepared, rows)
    times = _recorded_times(prepared, rows)
    stable = scenario.timestep == "auto" or _follows(scenario.plant, prepared.model.opt.timestep)
    complete = stopped.status == DONE and stable
    law = prepared.controller
    labels: dict[str, list[Any]] = {
        "point": list(scenario.points),
        "relative": [relative.name for relative in scenario.relative],
        "sensor": list(law.inputs) if law is not None else [],
        "law_state": list(range(law.states)) if law is not None else [],
    }
    labels = {name: along for name, along in labels.items() if along}
    dataset = make_dataset(times, values, {"title": scenario.name, "complete": int(complete)}, labels)
    summary = summarise(
        scenario=scenario,
        dataset=dataset,
        tally=tally,
        steps=stopped.steps,
        timestep=prepared.model.opt.timestep,
        stepping_seconds=wall,
        total_seconds=clock.perf_counter() - started,
        complete=complete,
        notes=_notes(prepared),
        usable_to=prepared.motion.usable_to,
        law=None if isinstance(law, PythonController) else law,
    )
    xml = drawn_xml(scenario.plant, prepared.model.opt.timestep)
    law = None if isinstance(law, PythonController) else law
    if law is not None and (controller is not None or isinstance(scenario.control, Law)):
        scenario = scenario.model_copy(update={"control": Law(kind="law", file=CONTROLLER_FILE)})
    result = Result(scenario, dataset, summary, xml, law)
    if not complete:
        message = _why(stopped, prepared, float(times[-1]) if times.size else 0.0)
        if stopped.status == DONE:
            message = _why_unstable(dataset, prepared.model.opt.timestep)
        summary["failure"] = message
        raise Incomplete(message, result) from next(iter(prepared.loop.failures), None)
    return result


def simulate_many(
    scenarios: Iterable[Scenario], threads: int | None = None, controllers: Sequence[Any] | None = None
) -> list[Result]:
    """Run scenarios on threads inside this process; results come in order.

    Args:
        scenarios: what to simulate.
        threads: how many at once; by default as many as the machine has.
        controllers: one for each scenario, see `simulate`; None leaves a scenario its own control.

    Raises:
        InputError: if there are not as many controllers as scenarios.
        As `simulate`, for the first scenario that fails.
    """
    cases = list(scenarios)
    laws = [None] * len(cases) if controllers is None else list(controllers)
    if len(laws) != len(cases):
        raise InputError(f"controllers: are {len(laws)}, they must be one for each of the {len(cases)} scenarios")
    with hydraulics(), ThreadPoolExecutor(max_workers=threads) as pool:
        return list(pool.map(lambda case, law: simulate(case, controller=law), cases, laws))


def choose_timestep(scenario: Scenario, controller: AnyController | None = None) -> float:
    """The integration step [s]: as stated, or the longest that resolves the fastest mode at equilibrium.

    It divides the recording period, and the controller's sampling period and delay, and follows the shortest force on
    the machine. Call it with the hydraulics
    installed.

    Raises:
        InputError: if a stated step does not divide them.
    """
    periods = {"the recording period 1/record_rate": 1.0 / scenario.record_rate}
    parts: Sequence[Controller | PythonController] = controller.parts if controller is not None else ()
    for number, part in enumerate(parts, start=1):
        whose = "the controller's" if len(parts) == 1 else f"the controller's part {number}'s"
        periods[f"{whose} period"] = part.period
        if part.latency > 0:
            periods[f"{whose} delay"] = part.latency
    if scenario.timestep != "auto":
        for name, period in periods.items():
            ratio = period / scenario.timestep
            if abs(ratio - round(ratio)) > 1e-6 * ratio or round(ratio) < 1:
                raise InputError(
                    f"timestep = {scenario.timestep:g} s must divide {name} = {period:g} s; "
                    f"nearest: {period / max(1, round(ratio)):.9g}"
                )
        first = next(iter(periods.values()))
        return first / round(first / scenario.timestep)
    fastest = float(np.abs(_modes(scenario.plant)).max())
    fastest = max(fastest, STEP_PER_TIME_CONSTANT / scenario.load().longest_step)
    period = _common_divisor(periods.values())
    if period < SHORTEST_STEP:
        times = ", ".join(f"{name} = {value:.9g} s" for name, value in periods.items())
        raise InputError(
            f"timestep = 'auto': no step of {SHORTEST_STEP:g} s or more divides {times}; choose record_rate, "
            "control.rate and control.delay that are multiples of each other, or state a timestep"
        )
    return period / max(1, math.ceil(period * fastest / STEP_PER_TIME_CONSTANT - 1e-9))


def _modes(plant: Plant) -> NDArray[np.complex128]:
    """Eigenvalues at the equilibrium at rest [rad/s]; of oil without its air, which is stiffest."""
    stiff = tuple(actuator.with_values({"air_fraction": 0.0}) for actuator in plant.actuators)
    model = _model(reduced(replace(plant, actuators=stiff)), 1e-4)
    data = mujoco.MjData(model)
    with hydraulics():
        matrix = jacobian(model, data, equilibrium(model, data, Inputs.rest()), Inputs.rest())
    return np.linalg.eigvals(matrix).astype(complex)


def _follows(plant: Plant, timestep: float) -> bool:
    """Whether RK4 at this step lets every mode decay that decays: |1 + z + z²/2 + z³/6 + z⁴/24| ≤ 1 at z = λ·step."""
    modes = _modes(plant)
    z = modes[modes.real < 0] * timestep
    return bool(np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4)))).max() <= 1.0)


def _common_divisor(periods: Iterable[float]) -> float:
    """The longest time of which all periods are multiples [s]."""
    exact = [Fraction(period).limit_denominator(10**7) for period in periods]
    divisor = exact[0]
    for other in exact[1:]:
        n = math.gcd(divisor.numerator * other.denominator, other.numerator * divisor.denominator)
        divisor = Fraction(n, divisor.denominator * other.denominator)
    return float(divisor)


def _model(plant: Plant, timestep: float) -> mujoco.MjModel:
    try:
        return build_model(plant, timestep)
    except ValueError as error:
        raise InputError(str(error)) from error


def _prepare(scenario: Scenario, controller: AnyController | None) -> _Prepared:
    motion, commands, load = scenario.motion(), scenario.commands(), scenario.load()
    if controller is None:
        controller = scenario.controller()
    else:  # instead of the scenario's control, its open-loop commands too
        commands = Passive().commands()
    try:
        timestep = choose_timestep(scenario, controller)
        loop = make_loop(controller, scenario.plant, timestep, scenario.sensors, scenario.seed)
        model = _model(scenario.plant, timestep)
        data = mujoco.MjData(model)
        start = np.zeros(1)
        ground = motion.sample(start)
        command = np.array([signal.sample(start, left=True).value[0] for signal in commands])
        equilibrium(model, data, Inputs(ground.displacement[0], ground.velocity[0], command))
    except EquilibriumError as error:
        raise InputError(f"{error} (machine.mass, actuators, supply, control)") from error
    steps = round(scenario.duration / timestep)
    every = round(1.0 / (scenario.record_rate * timestep))
    if steps < every:
        raise InputError(
            f"duration = {scenario.duration:g} s must be at least one recording period, {every * timestep:g} s"
        )
    noise = None
    if controller is not None:
        made = ReadingNoise(tuple(controller.inputs), scenario.sensors, scenario.seed, loop.base * timestep)
        noise = None if made.silent else made
    return _Prepared(scenario, model, data, motion, commands, load, controller, loop, noise, every, steps)


def _run(prepared: _Prepared, progress: Progress | None) -> tuple[Array, Array, Stopped, float]:
    """Step to the end, or until something fails: rows, tally, how it ended, seconds spent in the stepping loop."""
    compile_loop()
    count = prepared.steps // prepared.every + 1
    try:
        rows = np.empty((count, row_size(prepared.model, prepared.loop)))
    except MemoryError:
        s = prepared.scenario
        raise InputError(
            f"duration = {s.duration:g} s at record_rate = {s.record_rate:g} Hz: {count} rows do not fit in memory"
        ) from None
    tally = np.zeros(N_TALLY)
    loop = prepared.loop
    done, recorded, wall = 0, 0, 0.0
    stopped = Stopped(0, DONE, -1)
    while stopped.status == DONE and done < prepared.steps:
        steps = min(STRETCH, prepared.steps - done)
        last = done + steps == prepared.steps
        timestep = prepared.model.opt.timestep
        inputs = sample_inputs(prepared.motion, prepared.commands, done, steps + last, timestep)
        noise = None if prepared.noise is None else prepared.noise.take(loop.samples(done, steps + last)[1])
        began = clock.perf_counter()
        stopped, count = advance(
            prepared.model,
            prepared.data,
            done,
            steps,
            inputs,
            prepared.every,
            rows[recorded:],
            tally,
            last,
            loop,
            noise,
            NOT_LOADED if prepared.load.absent else sample_load(prepared.load, done, steps + last, timestep),
        )
        wall += clock.perf_counter() - began
        done += stopped.steps
        recorded += count
        if progress is not None:
            progress(done / prepared.steps)
    return rows[:recorded], tally, stopped._replace(steps=done), wall


def sample_inputs(
    motion: Motion, commands: tuple[Signal, ...], first: int, steps: int, timestep: float
) -> tuple[Array, Array]:
    """Inputs of some steps: value, slope·timestep, second derivative at start and end, (steps, n_inputs, 3) each."""
    times = np.arange(first, first + steps + 1, dtype=np.float64) * timestep
    points = np.zeros((steps + 1, N_INPUTS, 3))
    if not motion.at_rest:
        for order, part in enumerate(motion.sample(times)):
            points[:, :12, order] = part.reshape(-1, 12)
    starts = points[:-1].copy()
    ends = points[1:]
    for mount, signal in enumerate(commands):
        now = signal.sample(times[:-1])
        then = signal.sample(times[1:], left=True)
        starts[:, 12 + mount, 0], starts[:, 12 + mount, 1] = now.value, now.slope
        ends[:, 12 + mount, 0], ends[:, 12 + mount, 1] = then.value, then.slope
    starts[:, :, 1] *= timestep
    ends[:, :, 1] *= timestep
    return starts, ends


def sample_load(load: Load, first: int, steps: int, timestep: float) -> tuple[Array, Array]:
    """Force on the machine in some steps: value and slope·timestep at start and end, (steps, 6, 2) each."""
    times = np.arange(first, first + steps + 1, dtype=np.float64) * timestep
    scale = np.array([1.0, timestep])
    starts, ends = load.sample(times[:-1]), load.sample(times[1:], left=True)
    return np.stack(starts, axis=2) * scale, np.stack(ends, axis=2) * scale


def _recorded_times(prepared: _Prepared, rows: Array) -> Array:
    """Time of each recorded row [s]."""
    return np.arange(rows.shape[0], dtype=np.float64) / prepared.scenario.record_rate


def _channels(prepared: _Prepared, rows: Array) -> dict[str, Array]:
    """Everything that a result holds, from the recorded rows."""
    model, plant = prepared.model, prepared.scenario.plant
    at = columns(model, prepared.loop)
    times = _recorded_times(prepared, rows)
    ground = prepared.motion.sample(times)
    dofs = list(DOF_OF_JOINT)
    displacement, velocity, acceleration = (rows[:, slice(*part)][:, dofs] for part in (at.qpos, at.qvel, at.qacc))
    places = [*((*position, 0.0) for position in plant.positions), plant.machine.cg]
    places += prepared.scenario.points.values()
    moved = points_motion(displacement, velocity, acceleration, places)
    feet, cg, points = moved[:N_MOUNTS], moved[N_MOUNTS], moved[N_MOUNTS + 1 :]
    foot = [np.stack(part, axis=1) for part in zip(*feet, strict=True)]
    states = rows[:, slice(*at.act)]
    own = N_MOUNTS * N_STATES
    act = states[:, :own].reshape(-1, N_MOUNTS, N_STATES)
    chambers = Chambers.of(plant)
    pressure = chambers.pressure(act[:, :, 2:])
    supply = np.full(rows.shape[0], plant.supply.pressure)
    if plant.supply.dynamic:
        supply = states[:, own + SUPPLY_STATES.index("supply_pressure")]
    if plant.plates == "sliding":
        plate, plate_velocity = rows[:, slice(*at.qpos)][:, 6:], rows[:, slice(*at.qvel)][:, 6:]
    else:
        lever = np.array([[0, 0, 1, y, -x, 0] for x, y in plant.positions])
        plate, plate_velocity = displacement @ lever.T, velocity @ lever.T
    stroke = plate - ground.displacement[:, :, 2]
    found = {
        "ground_displacement": ground.displacement,
        "ground_velocity": ground.velocity,
        "ground_acceleration": ground.acceleration,
        "machine_displacement": displacement,
        "machine_velocity": velocity,
        "foot_displacement": foot[0],
        "foot_velocity": foot[1],
        "foot_acceleration": foot[2],
        "cg_displacement": cg[0],
        "cg_velocity": cg[1],
        "cg_acceleration": cg[2],
        "stroke": stroke,
        "stroke_velocity": plate_velocity - ground.velocity[:, :, 2],
        "spool": act[:, :, 0],
        "valve_command": rows[:, slice(*at.command)],
        "actuator_force": pressure[:, :, 0] * chambers.area[:, 0] - pressure[:, :, 1] * chambers.area[:, 1],
        "chamber_pressure": pressure,
        "chamber_void": chambers.void(act[:, :, 2:], stroke),
        "chamber_flow": rows[:, slice(*at.flow)].reshape(-1, N_MOUNTS, 2),
        "supply_pressure": supply,
    }
    found |= _observed(prepared.scenario, found, points)
    if not prepared.load.absent:
        found["external_force"] = prepared.load.sample(times)[0]
    if prepared.loop.readings:
        found["measured"] = rows[:, slice(*at.readings)]
    if prepared.loop.states:
        # Single precision: they are looked at, not calculated with, and may be many.
        found["controller_state"] = rows[:, slice(*at.states)].astype(np.float32)
    if plant.bookkeeping:
        ledger = states[:, -len(LEDGER_STATES) :]
        border = dict(zip(LEDGER_STATES[2 * N_MOUNTS :], ledger[:, 2 * N_MOUNTS :].T, strict=True))
        found |= {"oil_in": ledger[:, : 2 * N_MOUNTS].reshape(-1, N_MOUNTS, 2), **border}
        found |= {
            "oil_held": chambers.mass(act[:, :, 2:], stroke),
            "oil_energy": chambers.energy(act[:, :, 2:], stroke).sum(axis=(1, 2)),
        }
    return found


def _observed(
    scenario: Scenario, found: dict[str, Array], points: list[tuple[Array, Array, Array]]
) -> dict[str, Array]:
    """Motion of the points that the scenario names, and of places relative to each other."""
    motions = ("displacement", "velocity", "acceleration")
    observed = {}
    if points:
        stacked = (np.stack(part, axis=1) for part in zip(*points, strict=True))
        observed = {f"point_{motion}": part for motion, part in zip(motions, stacked, strict=True)}

    def motion_at(place: str, motion: str) -> Array:
        if place in scenario.points:
            return observed[f"point_{motion}"][:, list(scenario.points).index(place)]
        what, _, mount = place.partition(" ")
        values = found[f"{what}_{motion}"]
        return values[:, MOUNTS.index(mount)] if mount else values

    if scenario.relative:
        for motion in motions[:2]:
            parts = [motion_at(r.origin, motion) - motion_at(r.to, motion) for r in scenario.relative]
            observed[f"relative_{motion}"] = np.stack(parts, axis=1)
    return observed


def _notes(prepared: _Prepared) -> tuple[str, ...]:
    """What a reader of the result must know."""
    if not isinstance(prepared.controller, PythonController):
        return prepared.motion.notes
    said = "the commands came from a Python function, which is not in the scenario: it runs again without"
    return (*prepared.motion.notes, said)


def _why_unstable(dataset: xr.Dataset, timestep: float) -> str:
    """What a run says that ended although its step is too long: where and when the oil first tore, if it did."""
    voids = dataset["chamber_void"].max("chamber").values
    torn = np.argwhere(voids > 0.0)
    where = f" at {float(dataset.time[torn[0][0]]):.6g} s, at {MOUNTS[torn[0][1]]}" if torn.size else ""
    return (
        f"simulation failed{where}: timestep = {timestep:g} s is beyond the integrator's stability for the fastest "
        "mode, and only voids in the oil kept the motion bounded. Kept to the end, marked incomplete; use "
        "timestep = 'auto' or a shorter one"
    )


def _why(stopped: Stopped, prepared: _Prepared, recorded: float) -> str:
    """What failed, where and when, and what is kept."""
    where = MOUNTS[stopped.mount] if stopped.mount >= 0 else "the machine"
    what = {
        CHAMBER_1_EMPTY: "chamber 1 ran empty: the stroke left its range, or the step is too long to follow the oil",
        CHAMBER_2_EMPTY: "chamber 2 ran empty: the stroke left its range, or the step is too long to follow the oil",
    }.get(stopped.status, "a state is no longer finite")
    at = stopped.steps * prepared.model.opt.timestep
    if stopped.status == LAW_FAILED:
        error = prepared.loop.failures[0]
        return (
            f"simulation failed at {at:.6g} s, in the Python controller: {type(error).__name__}: {error}. "
            f"Kept until {recorded:.6g} s, marked incomplete"
        )
    return (
        f"simulation failed at {at:.6g} s, at {where}: {what}; step {prepared.model.opt.timestep:.3g} s. "
        f"Kept until {recorded:.6g} s, marked incomplete. A shorter timestep or smaller commands may help"
    )
