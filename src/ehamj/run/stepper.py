"""A machine that is stepped from instant to instant by whoever drives it: another simulator, a loop in Python."""

import threading
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Any, Final, Self

import numpy as np
from numpy.typing import ArrayLike

from ehamj.control import LinearController, PythonController, as_controller
from ehamj.control.law import silent
from ehamj.errors import InputError, SimulationFailed
from ehamj.interruption import check
from ehamj.mujoco import hydraulics
from ehamj.mujoco.advance import advance
from ehamj.mujoco.rows import Recording
from ehamj.mujoco.warned import warned
from ehamj.run.ahead import NoiseAhead, remember, twin_of
from ehamj.run.drive import STRETCH, Driving, Faults, driving
from ehamj.run.faults import plants
from ehamj.run.held import Held, Moved, about_carrier, add
from ehamj.run.instant import Instant
from ehamj.run.prepare import Prepared, prepare
from ehamj.run.timestep import follows
from ehamj.scenario.load import Given, as_scenario
from ehamj.scenario.model import Scenario
from ehamj.stopped import DONE, Stopped

NEVER: Final = 2**62
"""Steps between two rows of a stretch that is not recorded."""
ON_A_STEP: Final = 1e-3
"""Share of a timestep by which an instant may miss it: others add up times in floating point."""


class Stepper:
    """A scenario's machine, stepped from instant to instant with inputs that are held between them.

        passive = ehamj.load_scenario("vc-c-floor").variant("passive")
        with ehamj.Stepper(passive, reads=["foot_velocity front-left z"]) as machine:
            now = machine.step(0.001, commands=[0.1, 0.0, 0.0, 0.0])
            now["cg_velocity"]  # (1, axis) [m/s], as a row of a result
            now.value("measured", "foot_velocity front-left z")  # through the scenario's instrument
            machine.step(0.002, force=[0.0, 0.0, 50.0, 0.0, 0.0, 0.0])

    It is the run that `ehamj.simulate` makes: the same floor, law, instruments, faults and step, and beside them what
    is held. Commands [V] add to the law's. Ground is given as acceleration [m/s²]: held, it is integrated exactly to
    velocity and displacement, since a displacement that is held would be a blow. Force and moment [N, N m] act at the
    centre of gravity, in the axes of the ground. All of them stay until others are given.

    Several may be stepped in turn or by several threads. Within ``with`` the hydraulics stay installed in MuJoCo, else
    each step installs and removes them, which takes some 20 µs; nothing else needs to be freed.
    """

    def __init__(
        self, scenario: Given, controller: Any = None, *, reads: Sequence[str] = (), reads_every: float | None = None
    ) -> None:
        """Prepare the machine; it stands in its equilibrium at time zero.

        Args:
            scenario: as of `ehamj.simulate`; ends at its ``duration``.
            controller: as of `ehamj.simulate`, but no Python function: whoever steps can call that himself.
            reads: channels to read through the scenario's instruments where it has no law, which would say what is
                read; a law's are read in any case.
            reads_every: period of these readings [s]; without: 1/record_rate.

        Raises:
            InputError: if the scenario cannot be run, or not step by step.
        """
        if isinstance(reads, str):
            raise InputError(f"reads = {reads!r}: must be a list of channels, such as [{reads!r}]")
        given, law = as_scenario(scenario), None if controller is None else as_controller(controller)
        self._lock, self._within = threading.RLock(), ExitStack()
        with hydraulics():
            self._prepared = _prepared(given, law, tuple(reads), reads_every)
        self._loop, self._peeked = self._prepared.loop, twin_of(self._prepared.loop)
        self._noise, self._faults = NoiseAhead(self._prepared), Faults(self._prepared)
        self._timestep, self._mounts = self._prepared.timestep, tuple(given.plant.mounts)
        model, mounts = self._prepared.model, self._mounts
        self._unseen = Recording.of(model, self._loop, NEVER, 1)
        self._held, self._moved = Held.nothing(len(mounts)), Moved.at_rest(len(mounts))
        self._carrier, self._load = about_carrier(given.plant), given.load()
        self._done, self._since, self._broken = 0, 0, ""
        self._block, self._first = driving(self._prepared, 0, STRETCH), 0
        self._now: Instant | None = None

    @property
    def scenario(self) -> Scenario:
        """What is stepped."""
        return self._prepared.scenario

    @property
    def mounts(self) -> tuple[str, ...]:
        """Names of the mounts, in the order of all inputs."""
        return self._mounts

    @property
    def controller(self) -> LinearController | None:
        """The law that runs, or that only reads."""
        return self._prepared.law

    @property
    def timestep(self) -> float:
        """Of the integrator [s]; instants are multiples of it."""
        return self._timestep

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader must know of the run."""
        return self._prepared.notes

    @property
    def time(self) -> float:
        """Of the present instant [s]."""
        return self._done * self.timestep

    def __repr__(self) -> str:
        return f"Stepper of {self.scenario.name!r} at {self.time:.9g} s, timestep {self.timestep:.9g} s"

    def __enter__(self) -> Self:
        self._within.enter_context(hydraulics())
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of MuJoCo's callbacks; a further step installs them for itself."""
        self._within.close()

    def hold(
        self, commands: ArrayLike | None = None, ground: ArrayLike | None = None, force: ArrayLike | None = None
    ) -> None:
        """State what is held from now on; without: as before.

        Args:
            commands: of each mount, beside its law's (mount,) [V]: added behind the law's converter, which does not
                limit them; the valve limits the sum to its range, ``voltage_limit``.
            ground: acceleration of the ground below each mount (mount, axis) [m/s²].
            force: force and moment at the machine's centre of gravity (6,) [N, N m].

        Raises:
            InputError: if they are not as many finite numbers.
        """
        with self._lock:
            held = self._held.changed(self.mounts, commands=commands, ground=ground, force=force)
            self._moved = self._moved.after((self._done - self._since) * self.timestep, self._held.ground)
            self._since, self._held, self._now = self._done, held, None

    def step(
        self,
        until: float,
        *,
        commands: ArrayLike | None = None,
        ground: ArrayLike | None = None,
        force: ArrayLike | None = None,
    ) -> Instant:
        """Step to the instant ``until`` [s], a whole number of timesteps on; inputs as of `hold`.

        Returns:
            What the machine shows there, under what was held until then.

        Raises:
            InputError: if that is no instant, or lies beyond the scenario's duration.
            SimulationFailed: if the simulation fails; this machine then stays where it is.
        """
        with self._lock:
            steps = self._number_of(until) - self._done
            if not (commands is None and ground is None and force is None):
                self.hold(commands, ground, force)
            with hydraulics():
                while steps > 0:
                    steps -= self._stretch(steps)
            return self.now

    @property
    def now(self) -> Instant:
        """What the machine shows at the present instant, under what is held now."""
        with self._lock:
            if self._now is None:
                self._now = self._seen()
            return self._now

    def _number_of(self, until: float) -> int:
        """Number of the step at an instant."""
        if not isinstance(until, int | float | np.number):
            raise InputError(f"until = {until!r}: must be a time [s]")
        own, steps = self.scenario, float(until) / self.timestep
        if self._broken:
            raise SimulationFailed(self._broken)
        if not np.isfinite(steps) or abs(steps - round(steps)) > ON_A_STEP or round(steps) <= self._done:
            near = max(round(steps), self._done + 1) if np.isfinite(steps) else self._done + 1
            raise InputError(
                f"until = {until:.9g} s: must be a whole number of timesteps of {self.timestep:.9g} s, after "
                f"{self.time:.9g} s; nearest: {near * self.timestep:.9g} s"
            )
        if round(steps) > self._prepared.steps:
            raise InputError(
                f"until = {until:.9g} s: must be at most the scenario's duration = {own.duration:g} s, for which its "
                "floor is made; duration sets another"
            )
        return round(steps)

    def _driving(self, steps: int) -> Driving:
        """What drives so many steps from the present one, with what is held."""
        begin = self._done - self._first
        if begin + steps > len(self._block.inputs[0]):
            self._block, self._first, begin = driving(self._prepared, self._done, STRETCH), self._done, 0
        part = slice(begin, begin + steps)
        (starts, ends), load = self._block.inputs, self._block.load
        force = [np.zeros((steps, 6, 2)) if not len(one) else one[part].copy() for one in load[:2]]
        slides = load[2][part] if len(load[2]) else load[2]
        own = Driving((starts[part].copy(), ends[part].copy()), (force[0], force[1], slides))
        carried = self._carrier @ self._held.force
        return add(own, self._held, self._moved, self._done - self._since, self.timestep, carried)

    def _stretch(self, steps: int) -> int:
        """Take some of so many steps, up to the next fault; how many were taken."""
        check()
        own = self._prepared
        self._faults.strike(self._done)
        steps = min(STRETCH, steps, self._faults.steps_left(self._done))
        driven, noise = self._driving(steps), self._noise.take(self._loop.samples(self._done, steps)[1])
        given = (driven.inputs, self._unseen, False, self._loop, noise, driven.load)
        stopped, _ = advance(own.model, own.data, self._done, steps, *given)
        self._done, self._now = self._done + stopped.steps, None
        self._check(stopped)
        return steps

    def _seen(self) -> Instant:
        """The present instant, without a trace of having looked: law and instruments are as they were."""
        own = self._prepared
        self._faults.strike(self._done)  # what strikes at an instant is seen there, as in a result
        remember(self._loop, self._peeked)
        driven, noise = self._driving(1), self._noise.ahead(self._loop.samples(self._done, 1)[1])
        recording = Recording.of(own.model, self._loop, 1, 1)
        before = own.data.ctrl.copy(), own.data.qacc_warmstart.copy()
        with hydraulics():
            given = (driven.inputs, recording, True, self._peeked, noise, driven.load)
            stopped, _ = advance(own.model, own.data, self._done, 0, *given)
        own.data.ctrl[:], own.data.qacc_warmstart[:] = before
        self._check(stopped, False)
        return Instant(own, recording.rows, self._faults.found, self.time, driven, self._held, self._load)

    def _check(self, stopped: Stopped, moved: bool = True) -> None:
        """Raise SimulationFailed where the stepping broke off, or the engine warned of where it moved."""
        if stopped.status != DONE:
            from ehamj.run.failures import broken_off

            found = broken_off(self._prepared, stopped._replace(steps=self._done))
            self._broken = ". ".join(part for part in found if part)
        elif moved and (doubt := warned(self._prepared.data)):
            self._broken = f"simulation failed at {self.time:.6g} s: {doubt}"
        if self._broken:
            raise SimulationFailed(self._broken)


def _prepared(scenario: Scenario, law: Any, reads: tuple[str, ...], every: float | None) -> Prepared:
    """What is stepped; call it with the hydraulics installed."""
    if scenario.engine != "mujoco":
        raise InputError(f"engine = {scenario.engine!r}: steps whole runs only; instant by instant 'mujoco' does")
    if isinstance(law, PythonController):
        raise InputError("controller: a Python function is called by whoever steps: hand its commands to step()")
    if reads and (law is not None or scenario.controller() is not None):
        raise InputError("reads: the law says what is read; without one (control.kind = 'passive') reads do")
    if reads:
        period = 1.0 / scenario.record_rate if every is None else every
        reader = silent(reads, scenario.plant.mounts, period, 0.0)
        found = replace(prepare(scenario, reader), commands=scenario.commands())
    else:
        found = prepare(scenario, law)
    if scenario.timestep != "auto" and not all(follows(plant, found.timestep) for plant in plants(scenario)):
        raise InputError(
            f"timestep = {found.timestep:g} s: is beyond the integrator's stability for the fastest mode; use 'auto' "
            "or a shorter one"
        )
    return found
