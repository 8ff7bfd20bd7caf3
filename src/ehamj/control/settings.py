"""What a control is: what a scenario, a sum of laws and a design may ask of it."""

from abc import abstractmethod
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Self, get_args

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from ehamj.arrays import Array
from ehamj.control.blocks import Block
from ehamj.control.clock import MOST_WAITING, SHORTEST, waits_in_time
from ehamj.control.inertial import MotionLoop
from ehamj.control.installation import DesignedFor
from ehamj.control.law import UNSTABLE, Controller
from ehamj.control.learning import Learning
from ehamj.control.linearisation import NOTHING, Linearisation
from ehamj.control.lines import Line
from ehamj.control.spool_feedback import SpoolFeedback
from ehamj.control.spools import followed
from ehamj.control.windup import AntiWindup, limited_radius, parted
from ehamj.errors import InputError
from ehamj.plant.layout import MOTION_NAMES
from ehamj.plant.plant import Plant
from ehamj.settings import Fade, NotNegative, Positive, Settings
from ehamj.signals import Signal, Zero

if TYPE_CHECKING:
    from ehamj.control import LinearController
    from ehamj.control.sensors import Sensors


ISOLATE_FROM = (
    "frequency at which isolation begins on floors too strong for the voltage; below it the machine follows the floor "
    "[Hz]; 0: everywhere"
)


def _switched(given: Any) -> Any:
    """A switch in place of a table: on with all its defaults, or off."""
    return ({} if given else None) if isinstance(given, bool) else given


Stage = Annotated[Linearisation | None, BeforeValidator(_switched, json_schema_input_type=Linearisation | bool | None)]
Spools = Annotated[SpoolFeedback | None, BeforeValidator(_switched, json_schema_input_type=SpoolFeedback | bool | None)]


Learns = Annotated[Learning | None, BeforeValidator(_switched, json_schema_input_type=Learning | bool | None)]


class SwingsUpError(InputError):
    """A law whose states run away while its commands are limited."""


class ControlSettings(Settings):
    """A table [control]: a digital law, or signals for the valves, or nothing."""

    kind: str

    @classmethod
    def name(cls) -> str:
        """The ``kind`` that stands in a scenario."""
        return str(get_args(cls.model_fields["kind"].annotation)[0])

    @classmethod
    def standard(cls) -> Self | None:
        """The control with all its defaults; none where something must be given."""
        return None if any(field.is_required() for field in cls.model_fields.values()) else cls.stated()

    def commands(self, mounts: Sequence[str], duration: float) -> tuple[Signal, ...]:
        """Open-loop command of each mount [V] in a run of ``duration`` [s]; beside a digital law there is none."""
        return tuple(Zero() for _ in mounts)

    def named_mounts(self) -> Iterable[tuple[str, str]]:
        """Mounts that it calls by name, each with the key within [control] that does."""
        return ()

    def controller(self, plant: Plant, sensors: "Sensors") -> "LinearController | None":
        """The digital law for a plant that is measured by ``sensors``, if there is one."""
        return None


class SampledSettings(ControlSettings):
    """Clock and converter of a digital law: what an architecture has, and a synthesis or adaptation that makes one."""

    rate: Positive = Field(10_000.0, description="sampling rate [Hz]")
    delay: Annotated[float, Field(ge=0, le=1)] | None = Field(
        None, description="computation delay [s]; without: one sample"
    )
    bits: Annotated[int, Field(ge=2, le=52)] = Field(16, description="resolution of the command converter [bit]")
    switch_on: NotNegative = Field(0.0, description="time at which the controller takes over [s]")
    fade: Fade = Field(0.0, description="time over which its commands fade in [s]")
    recovery: Positive = Field(
        0.15, description="time over which motion that the valves could not follow is made good [s]"
    )

    linearisation: Stage = Field(
        None, description="what of the valves is made good before the converter; without, or false: nothing"
    )
    learning: Learns = Field(
        None, description="what is learnt of each isolator while the law runs; without, or false: nothing"
    )
    spool_feedback: Spools = Field(
        None,
        description="loop about the spool of each valve, whose position is measured ([sensors.spool]); linearisation "
        "then leaves to it what it takes back; without, or false: none",
    )

    @model_validator(mode="after")
    def _waits_in_time(self) -> Self:
        if self.delay is not None and not waits_in_time(self.delay, self.period):
            raise ValueError(
                f"delay = {self.delay:g} s is {self.delay * self.rate:.3g} samples at rate = {self.rate:g} Hz; it "
                f"must be zero, or at least {SHORTEST:g} s and at most {MOST_WAITING} samples"
            )
        return self

    @property
    def clock(self) -> dict[str, Any]:
        """What makes it digital, by name: clock, converter and recovery."""
        return {name: getattr(self, name) for name in CLOCK}

    @property
    def period(self) -> float:
        """Sampling period [s]."""
        return 1.0 / self.rate

    @property
    def hold(self) -> float:
        """Delay of computation and of the hold, half a sample, together [s]."""
        return (self.period if self.delay is None else self.delay) + 0.5 * self.period

    def known(self, plant: Plant, sensors: "Sensors") -> dict[str, Any]:
        """What a law knows of a plant's valves and their spools, and learns of its isolators."""
        learning = self.learning
        made_good = self.linearisation or (NOTHING if learning else None)
        spools = () if self.spool_feedback is None else self.spool_feedback.known(plant, sensors)
        valves = () if made_good is None else made_good.known(followed(plant, spools))
        learners = () if learning is None else learning.learners(plant, valves, sensors)
        for one in learners:
            blocks = self.rate / one.samples(self.period, self.period if self.delay is None else self.delay)
            if one.high >= 0.25 * blocks:
                raise InputError(
                    f"control.learning.band: {one.high:g} Hz must be below a quarter of {blocks:g} Hz, at which the "
                    f"oil is balanced at most with control.rate = {self.rate:g} Hz and its delays; lower it, or raise "
                    "control.rate"
                )
        return {"valves": valves, "learners": learners, "spools": spools}

    def digital(
        self,
        block: Block,
        inputs: tuple[str, ...],
        plant: Plant,
        *,
        sensors: "Sensors",
        anti_windup: AntiWindup | Array,
        lines: tuple[Line, ...] = (),
    ) -> Controller:
        """The law that a sampled ``block`` from ``inputs`` to the commands [V] becomes.

        Args:
            block: the law, to the commands of the active mounts, or of all; its inputs are those measured, and with
                `AntiWindup.INPUTS` one more per command. Passive mounts get nothing.
            inputs: channels that it measures.
            plant: whose valves it commands.
            sensors: that measure what it reads.
            anti_windup: how its states learn what the valves did not get, or the matrix (states, valves).
            lines: whose frequency it follows.

        Raises:
            InputError: if the law is unstable by itself, or while its commands are limited; if it samples too slowly
                for what it is to learn from.
            ValueError: if the block's inputs are not these.
        """
        law, gain = parted(block, len(inputs), anti_windup, self.period, self.recovery)
        if len(law.C) != len(plant.mounts):
            reach = np.eye(len(plant.mounts))[:, list(plant.layout.active)]
            law, gain = law.between(np.eye(len(inputs)), reach), None if gain is None else gain @ reach.T
        if gain is not None and limited_radius(law.A, law.C, gain) > UNSTABLE:
            raise SwingsUpError(
                f"control.recovery = {self.recovery:g} s: too slow for loops that cross so low, which would swing up "
                "while commands are limited; shorten it, or raise the crossing, or lower the integral"
            )
        return Controller(
            *law,
            inputs,
            self.period,
            self.delay,
            mounts=plant.mounts,
            voltage_limit=min(actuator.voltage_limit for actuator in plant.obeying.actuators),
            bits=self.bits,
            switch_on=self.switch_on,
            fade=self.fade,
            from_rest=True,
            anti_windup=gain,
            lines=lines,
            **self.known(plant, sensors),
        )


class DigitalSettings(SampledSettings):
    """What every architecture has; it alone commands the valves.

    An architecture builds its `controller`. The other methods say what a sum of laws, a design or a study may do with
    it; by default its loops are its fields of that kind, and nothing depends on the machine or must be known to others.
    """

    designed_for: DesignedFor = Field(
        None,
        description="machine and instruments that the law is derived from and held for: a table of what differs from "
        "the scenario's own, or the name or file of another scenario; without: derived from the scenario's own",
    )

    @property
    def shared(self) -> dict[str, Any]:
        """What laws that run together have in common, by name: as `clock`, and the machine that they are held for."""
        return {name: getattr(self, name) for name in SHARED}

    @abstractmethod
    def controller(self, plant: Plant, sensors: "Sensors") -> Controller:
        """The law for a plant that is measured by ``sensors``."""

    def beside(self, others: "Sequence[DigitalSettings]", plant: Plant, sensors: "Sensors") -> Controller:
        """The law as it runs while ``others`` do."""
        return self.controller(plant, sensors)

    @property
    def members(self) -> "tuple[DigitalSettings, ...]":
        """The laws that add up, each as it runs: this one alone."""
        return (self,)

    def with_member(self, number: int, member: "DigitalSettings") -> "DigitalSettings":
        """The whole with another law in place of one of its `members`."""
        return member

    def loops(self, plant: Plant | None = None) -> dict[str, MotionLoop]:
        """Loops that a design may lower or raise, by the field that holds each; one of a motion bears its name.

        With a ``plant``, those of motions that its mounts drive.
        """
        other = () if plant is None else set(MOTION_NAMES.values()).difference(plant.layout.motions)
        fields = ((name, getattr(self, name)) for name in type(self).model_fields)
        return {n: loop for n, loop in fields if isinstance(loop, MotionLoop) and loop.crossing and n not in other}

    def fitted(self, modes: Sequence[tuple[str, float]], height: float) -> Self:
        """The settings for a machine: names and frequencies of its modes [Hz], height of its centre of gravity [m]."""
        return self

    def isolating_from(self, hertz: float) -> Self:
        """The settings that leave what is slower to the floor; unchanged where an architecture cannot."""
        able = "isolate_from" in type(self).model_fields
        return self.model_copy(update={"isolate_from": hertz}) if able else self

    def asked(self, motion: str, s: complex, creep: float) -> complex:
        """Piston velocity that a broadband loop asks for per displacement of a motion, at s = jω [rad/s]; 0: none."""
        return 0.0


CLOCK = tuple(name for name in SampledSettings.model_fields if name != "kind")
"""Settings that make a law digital: clock, converter and recovery."""
SHARED = tuple(name for name in DigitalSettings.model_fields if name != "kind")
"""Settings that laws which run together share: clock, converter, recovery, and the machine that they are held for."""
