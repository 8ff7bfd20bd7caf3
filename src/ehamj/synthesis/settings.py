"""What every synthesised law has around the loops of heave, roll and pitch, and the margins that it is to leave."""

import threading
from abc import abstractmethod
from collections import deque
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Final, Self

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, field_serializer, model_validator

from ehamj.control.architectures.feedforward import FeedforwardSettings
from ehamj.control.architectures.modal import ModalSettings, SwayDamping
from ehamj.control.balance import WarpBalance
from ehamj.control.blocks import Block
from ehamj.control.inertial import LEAK, Blend, MotionLoop
from ehamj.control.law import Controller, stack
from ehamj.control.sensors import Sensors
from ehamj.control.settings import ISOLATE_FROM, SHARED, DigitalSettings, SwingsUpError
from ehamj.errors import InputError
from ehamj.plant.levers import MOTIONS
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative, Positive, Settings
from ehamj.synthesis.requirements import Requirements, Variations

if TYPE_CHECKING:
    from ehamj.linear.machine import LinearModel
    from ehamj.synthesis.search import Found

NO_LOOP, NO_SWAY = MotionLoop(crossing=0.0), SwayDamping(gain=0.0, centre=70.0)
THIRD = 2.0 ** (1 / 6) - 2.0 ** (-1 / 6)
"""Width of a third-octave over its centre."""

_RECENT: Final[deque[tuple["SynthesisSettings", Plant, Sensors, "Found"]]] = deque(maxlen=64)
"""Laws that were found: a run asks for its law more than once."""
_FINDING: Final = threading.Lock()
"""Of threads that want one law, the first finds it."""


class MotionWeights(Settings):
    """Weights of one motion."""

    bandwidth: Positive = Field(description="frequency below which the floor counts, ω₀/2π [Hz]")
    integral: Positive = Field(description="frequency below which it counts twice as steeply [Hz]")
    effort: Positive = Field(description="weight of the piston velocity over ω₀ times the displacement [-]")
    inside: NotNegative = Field(description="g: disturbance behind the valve over that at the output [-]")
    sway: NotNegative = Field(
        0.0, description="weight of sideways velocity/ω₀ [m] over the angle [rad]; roll and pitch"
    )
    doubt: Positive = Field(1.0, description="noise of sideways velocity/ω₀ over that of the angle; roll and pitch")
    gain: Positive = Field(1.0, description="factor on the loop that is found; below one it buys margins [-]")


class SynthesisSettings(DigitalSettings):
    """What every synthesised law has around the loops of heave, roll and pitch.

    The law is found for the machine at hand, such that its margins hold there and on the variations. The default
    weights of each synthesis do so on the default machine as they are, and damp its sway threefold (differential
    evolution over the weights); elsewhere they are eased until they do.
    """

    heave: MotionWeights
    roll: MotionWeights
    pitch: MotionWeights
    margins: Requirements = Requirements.stated()
    variations: Variations = Variations.stated()
    feedforward: FeedforwardSettings = Field(
        FeedforwardSettings.stated(rolloff=1200.0, restore=0.03),
        description="feedforward of the ground's velocity beside the loops; gain = 0: none",
    )
    blend: Blend = Blend.stated(restore=0.03)
    warp: WarpBalance = WarpBalance.stated()
    isolate_from: NotNegative = Field(0.0, description=ISOLATE_FROM)

    floor: Positive = Field(
        12.5e-6, description="velocity of the floor, RMS per third-octave from 1 to 80 Hz [m/s]; default: VC-C"
    )
    plant_order: Annotated[int, Field(ge=4)] = Field(
        16,
        description="states kept of each motion's plant; an eccentric centre of gravity brings yaw and both sways in",
    )
    order: Annotated[int, Field(ge=2)] = Field(10, description="states kept of each motion's loop")

    @model_validator(mode="before")
    @classmethod
    def _partly_stated(cls, table: Any) -> Any:
        """Tables of which a part is stated, completed by what the synthesis states of them: weights belong together."""
        if not isinstance(table, Mapping):
            return table
        defaults = {name: cls.model_fields[name].default for name in table if name in cls.model_fields}
        stated = {name: default for name, default in defaults.items() if isinstance(default, Settings)}
        return dict(table) | {
            name: {key: getattr(default, key) for key in default.model_fields_set} | dict(table[name])
            for name, default in stated.items()
            if isinstance(table[name], Mapping)
        }

    @model_validator(mode="after")
    def _one_clock(self) -> Self:
        for name in self.feedforward.model_fields_set.intersection(SHARED):
            if getattr(self.feedforward, name) != getattr(self, name):
                raise ValueError(f"feedforward.{name}: is stated once, for the whole law: control.{name}")
        if self.feedforward.isolate_from:
            raise ValueError(
                f"feedforward.isolate_from = {self.feedforward.isolate_from:g} Hz: is stated once, for the whole law: "
                "control.isolate_from"
            )
        return self

    @field_serializer("feedforward", mode="wrap")
    def _said_once(self, feedforward: Any, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {key: value for key, value in handler(feedforward).items() if key not in SHARED}

    @abstractmethod
    def loop(self, motion: Block, weights: MotionWeights, plant: Plant, sensors: Sensors) -> Block:
        """The loop of one motion by the synthesis: the bilinear image from blended displacement [m, rad], of roll and
        pitch also from the feet's mean sideways velocity [m/s], to piston velocity [m/s, rad/s].

        Args:
            motion: its plant (`ehamj.synthesis.plants`).
            weights: of the motion.
            plant: whose valves have a range.
            sensors: whose noise counts.

        Raises:
            InputError: if there is none.
        """

    def found(self, plant: Plant, sensors: Sensors) -> "Found":
        """The law that leaves the margins on a plant and its variations, and what it has in hand there.

        Raises:
            InputError: if no law exists for these weights, it is unstable by itself, the mounts drive other motions,
                or none leaves the margins.
        """
        from ehamj.synthesis.search import find

        own = self.model_copy(update={"designed_for": None})
        with _FINDING:
            for settings, machine, instruments, known in _RECENT:
                if settings == own and machine == plant and instruments == sensors:
                    return known
            known = find(own, plant, sensors)
            _RECENT.appendleft((own, plant, sensors, known))
            return known

    def controller(self, plant: Plant, sensors: Sensors) -> Controller:
        """The law that leaves the margins on a plant that is measured by ``sensors``, and on its variations."""
        return self.found(plant, sensors).law

    def law(self, plant: Plant, sensors: Sensors, model: "LinearModel", seed: int = 0) -> Controller:
        """The law of these weights as they are, whatever its margins.

        Args:
            plant: that it is derived from.
            sensors: that it reads.
            model: the linearised plant.
            seed: that draws the directions of misaligned instruments.

        Raises:
            InputError: if no law exists for these weights, it is unstable by itself, or the mounts drive other motions.
        """
        return self.with_feedforward(self.feedback(plant, sensors, model, seed), plant, sensors)

    def feedback(self, plant: Plant, sensors: Sensors, model: "LinearModel", seed: int = 0) -> Controller:
        """The loops of `law` alone, which are all that margins are of."""
        from ehamj.synthesis.plants import motion_plants

        more = [motion for motion in plant.layout.motions if motion not in MOTIONS]
        if more:
            raise InputError(
                f"design: the {self.kind} synthesis has weights for {', '.join(MOTIONS)}, and the mounts drive "
                f"{', '.join(more)} as well; take combined (--architecture combined), which has a loop for each"
            )
        plants = motion_plants(model, self, plant, sensors, self.plant_order, seed).items()
        loops = {name: self.loop(own, getattr(self, name), plant, sensors).sampled(self.period) for name, own in plants}
        try:
            return self.modal().with_loops(plant, sensors, loops)
        except SwingsUpError as error:
            raise InputError(
                "design: loops were found that would swing up while commands are limited, since they lean on the "
                "machine's sway, which the model of what the valves lost does not have; less gain helps"
            ) from error

    def with_feedforward(self, feedback: Controller, plant: Plant, sensors: Sensors) -> Controller:
        """The loops with the feedforward beside them."""
        if not self.feedforward.gain:
            return feedback
        forward = self.feedforward.model_copy(update=self.clock)
        if self.isolate_from:
            forward = forward.isolating_from(self.isolate_from)
        return stack([feedback, forward.controller(plant, sensors)])

    def noise_over_floor(self, weights: MotionWeights, sensors: Sensors) -> float:
        """r: the inertial instruments' noise over the floor's motion in the third-octave at the bandwidth [-]."""
        sensor = sensors.inertial
        if sensor is None:
            return 0.0
        return float(sensor.noise_density(weights.bandwidth) * np.sqrt(THIRD * weights.bandwidth) / self.floor)

    def low(self, weights: MotionWeights, sensors: Sensors) -> float:
        """ω_l/ω₀: where the floor's weight, ω₀ω_i/ω_l² at its end, is as far above one as the noise is below [-].

        Instruments allow no more, and the loop's integrals end there.

        Raises:
            InputError: if the noise leaves no room.
        """
        integral, noise = weights.integral / weights.bandwidth, self.noise_over_floor(weights, sensors)
        low = max(np.sqrt(integral * noise), LEAK / weights.bandwidth)
        if low >= min(1.0, integral):
            raise InputError(
                f"design: the inertial instruments' noise is {noise:.2g} of the floor at {weights.bandwidth:g} Hz, "
                f"where {weights!r} asks for isolation; take quieter instruments, or state a stronger floor"
            )
        return float(low)

    def modal(self) -> ModalSettings:
        """The modal law without loops: the warp balance, which runs inside the loops of the motions."""
        still = dict.fromkeys(MOTIONS, NO_LOOP) | {"sway_x": NO_SWAY, "sway_y": NO_SWAY}
        own = {"blend": self.blend, "warp": self.warp, "isolate_from": self.isolate_from}
        return ModalSettings().model_copy(update={**self.clock, **own, **still})
