"""A machine stepped from outside: the run of `simulate`, whoever steps it and however often he looks."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
import pytest

import ehamj
from ehamj.errors import InputError
from ehamj.forces import Load
from ehamj.ground import GroundSample
from ehamj.mujoco import hydraulics
from ehamj.run.drive import drive
from ehamj.run.observe import observe
from ehamj.run.prepare import prepare
from ehamj.scenario.model import Scenario
from ehamj.signals import Array, Sample

END, LOOK = 0.02, 0.002
NAMES = (
    "cg_displacement", "cg_velocity", "cg_acceleration", "foot_velocity", "stroke", "spool", "chamber_pressure",
    "valve_command", "ground_displacement", "ground_velocity", "ground_acceleration", "actuator_force",
)  # fmt: skip


@pytest.fixture(scope="module")
def active() -> Scenario:
    """Nonlinear, noisy sensors, sliding plates, a wave, forces, a law and a fault."""
    changes = [
        *(f"duration={END}", "compare=[]", "record_rate=500", "control={kind='skyhook',rate=5000.0,delay=2e-4}"),
        "force=[{kind='hammer',peak=500.0,begin=0.003}]",
        "fault=[{kind='sensor-gain',mount='front-left',sensor='inertial',time=0.0113,factor=0.5}]",
    ]
    return ehamj.load_scenario("vc-c-floor", changes)


@dataclass(frozen=True)
class Pieces:
    """Constant acceleration in each of some equal intervals [m/s²], or constant values: integrated by hand, interval by
    interval."""

    values: Array
    every: float
    integrated: bool = False

    def sample(self, time: Array, left: bool = False) -> Sample:
        found = np.zeros((3, len(time)))
        for number, t in enumerate(time):
            at = t / self.every
            whole = min(int(np.ceil(at - 1e-6)) - 1 if left else int(np.floor(at + 1e-6)), len(self.values) - 1)
            whole = max(whole, 0)
            x = v = 0.0
            for value in self.values[:whole]:
                x, v = x + v * self.every + value * self.every**2 / 2, v + value * self.every
            rest = t - whole * self.every
            value = self.values[whole]
            own = (x + v * rest + value * rest**2 / 2, v + value * rest, value)
            found[:, number] = own if self.integrated else (value, 0.0, 0.0)
        return Sample(*found)


@dataclass(frozen=True)
class Shaken:
    """A motion with held accelerations (interval, mount, axis) added."""

    own: object
    held: Array
    at_rest: bool = False
    notes: tuple[str, ...] = ()
    usable_to: float = float("inf")
    usable_from: float = 0.0

    def sample(self, time: Array) -> GroundSample:
        found = self.own.sample(time)
        for mount, axis in np.ndindex(self.held.shape[1:]):
            added = Pieces(self.held[:, mount, axis], LOOK, integrated=True).sample(time)
            for part, own in zip(found, added, strict=True):
                part[:, mount, axis] += own
        return found


def test_it_is_the_run_of_simulate_to_the_bit(active: Scenario) -> None:
    """Noise, filters, delay and law included; looking twice, or at odd instants, leaves no trace."""
    whole = ehamj.simulate(active).dataset
    with ehamj.Stepper(active) as machine:
        for row in range(1, 11):
            machine.step(row * LOOK - machine.timestep)
            now = machine.step(row * LOOK)
            assert machine.now is now
            machine.hold()
            again = machine.now
            for name in (*NAMES, "measured"):
                exact = not name.startswith("ground")  # sampled one by one, sums of sines round otherwise
                np.testing.assert_allclose(now[name][0], whole[name][row], 0 if exact else 1e-12, 1e-16, err_msg=name)
                np.testing.assert_array_equal(again[name], now[name], err_msg=name)


@pytest.mark.parametrize(("plates", "within"), [("tied", 1e-12), ("sliding", 1e-6)])
def test_what_is_held_does_what_the_same_inputs_of_a_whole_run_do(active: Scenario, plates: str, within: float) -> None:
    """Sums that round otherwise in the last digit show at 1e-7 where plates slide: the engine's solver ends there."""
    active = active.model_copy(update={"plates": plates})
    rng = np.random.default_rng(5)
    commands, ground = rng.normal(0.0, 0.3, (10, 4)), rng.normal(0.0, 0.02, (10, 4, 3))
    force = rng.normal(0.0, 100.0, (10, 6))
    with hydraulics():
        prepared = prepare(active, None)
        signals = tuple(Pieces(commands[:, mount], LOOK) for mount in range(4))
        pushes = (*prepared.load.signals, *(Pieces(force[:, dof], LOOK) for dof in range(6)))
        load = Load(np.vstack([prepared.load.patterns, np.eye(6)]), pushes)
        prepared = replace(prepared, commands=signals, load=load, motion=Shaken(prepared.motion, ground))
        rows = drive(prepared).rows
    assert rows is not None
    whole = observe(prepared, rows)
    machine = ehamj.Stepper(active)
    for row in range(10):
        machine.hold(commands[row], ground[row], force[row])
        if row:
            for name in (*NAMES, "measured"):
                peak = np.abs(whole[name].values).max()
                np.testing.assert_allclose(machine.now[name][0], whole[name][row], 0, within * peak, err_msg=name)
        machine.step((row + 1) * LOOK)
    np.testing.assert_allclose(machine.now["external_force"][0], force[-1])  # the blow is over


def test_several_are_stepped_in_turn_and_by_threads(active: Scenario) -> None:
    def end(machine: ehamj.Stepper) -> Array:
        for row in range(1, 6):
            machine.step(row * LOOK, force=[0.0, 0.0, 10.0 * row, 0.0, 0.0, 0.0])
        return np.asarray(machine.now["foot_velocity"])

    alone = end(ehamj.Stepper(active))
    with ehamj.Stepper(active) as one, ehamj.Stepper(active) as other:
        for row in range(1, 6):
            for machine in (one, other):
                machine.step(row * LOOK, force=[0.0, 0.0, 10.0 * row, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(one.now["foot_velocity"], alone)
    with ThreadPoolExecutor(2) as pool:
        for found in pool.map(end, [ehamj.Stepper(active), ehamj.Stepper(active)]):
            np.testing.assert_array_equal(found, alone)


def test_a_machine_without_a_law_is_read_through_its_instruments(active: Scenario) -> None:
    passive, channel = active.variant("passive"), "foot_velocity front-left z"
    machine = ehamj.Stepper(passive, reads=[channel], reads_every=1e-3)
    now = machine.step(0.01)
    read, true = now.value("measured", channel), now.value("foot_velocity", "front-left", "z")
    assert read != true
    assert abs(read - true) < 0.5 * abs(true) + 1e-6
    with pytest.raises(KeyError, match="'front' is none of front-left"):
        now.value("foot_velocity", "front", "z")


def test_what_cannot_be_stepped_is_refused_in_one_line(active: Scenario) -> None:
    machine = ehamj.Stepper(active)
    machine.step(LOOK)
    for until in (LOOK, 0.5 * LOOK, LOOK + 0.4 * machine.timestep, float("nan")):
        with pytest.raises(ehamj.InputError, match=r"until = .*: must be a whole number of timesteps of .*; nearest: "):
            machine.step(until)
    with pytest.raises(ehamj.InputError, match=r"must be at most the scenario's duration = 0.02 s"):
        machine.step(2 * END)
    with pytest.raises(ehamj.InputError, match=r"commands = \[1.0\]: must be one command per mount"):
        machine.hold(commands=[1.0])
    with pytest.raises(ehamj.InputError, match=r"force = .*nan.*: must be force x, y, z \[N\]"):
        machine.step(2 * LOOK, force=[np.nan] * 6)
    assert machine.time == pytest.approx(LOOK)
    for refused, words in (
        ({"engine": "small-motion"}, "engine = 'small-motion'"),
        ({"timestep": 2e-3, "record_rate": 500.0}, "beyond the integrator's stability"),
    ):
        with pytest.raises(ehamj.InputError, match=words):
            ehamj.Stepper(active.variant("passive").model_copy(update=refused))
    with pytest.raises(ehamj.InputError, match="reads: the law says what is read"):
        ehamj.Stepper(active, reads=["stroke front-left"])


def test_a_machine_that_failed_stays_where_it_is(active: Scenario) -> None:
    machine = ehamj.Stepper(active.variant("passive"))
    with pytest.raises(ehamj.SimulationFailed, match="simulation failed at") as first:
        machine.step(END, force=[0.0, 0.0, 1e9, 0.0, 0.0, 0.0])
    with pytest.raises(ehamj.SimulationFailed, match=str(first.value)[:30]):
        machine.step(END)


def test_what_strikes_at_an_instant_is_seen_there(active: Scenario) -> None:
    """As the row of a whole run has it."""
    fault = [{"kind": "supply-lost", "mount": "front-left", "time": 0.004}]
    scenario = active.varied({"fault": fault, "duration": 0.006})
    row = ehamj.simulate(scenario).dataset.isel(time=2)
    machine = ehamj.Stepper(scenario)
    machine.step(0.002)
    now = machine.step(0.004)
    for name in ("supply_pressure", "chamber_flow"):
        np.testing.assert_array_equal(np.float32(now[name][0]), np.float32(row[name].values), err_msg=name)


def test_a_value_is_named_as_it_is(active: Scenario) -> None:
    now = ehamj.Stepper(active).now
    with pytest.raises(KeyError, match="foot_velocity: has 2 labels, mount, axis"):
        now.value("foot_velocity", "front-left", "z", "more")
    with pytest.raises(KeyError, match="did you mean 'stroke'"):
        now.value("strok", "front-left")
    with pytest.raises(InputError, match=r"reads = 'stroke front-left': must be a list"):
        ehamj.Stepper(active.variant("passive"), reads="stroke front-left")
