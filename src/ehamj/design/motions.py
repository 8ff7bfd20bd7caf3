"""What synthesis starts from and ends in: the plant of one motion, and the law that loops of motions make.

Heave, roll and pitch are nearly decoupled (`ehamj.control.architectures.modal`). The plant of one is what its loop sees
from sample to sample: from the piston velocity that it asks for to the blended displacement (`ehamj.control.inertial`),
through converter delay and hold, valves, oil, machine and instruments, with the warp balance closed. Roll and pitch are
measured by the feet's sideways velocity too: with the angle held still, sway has the damping of the membranes alone.

Synthesis works on the bilinear image of that sampled plant, s = (2/T)(z − 1)/(z + 1), and the loop that it finds goes
back by the same map (`Block.sampled`): peaks of responses, and with them H∞ norms and margins, are those of the sampled
loop exactly; only frequencies are stretched, f → tan(π f T)/(π T).
"""

import warnings
from abc import abstractmethod
from dataclasses import replace
from typing import Annotated

import numpy as np
from pydantic import Field

from ehamj.control import Controller
from ehamj.control.architectures.feedforward import FeedforwardSettings
from ehamj.control.architectures.modal import ModalSettings, SwayDamping
from ehamj.control.balance import WarpBalance
from ehamj.control.blocks import TWO_PI, Block, beside
from ehamj.control.channels import MountChannels
from ehamj.control.inertial import LEAK, Blend, MotionLoop
from ehamj.control.inverse import volts
from ehamj.control.law import stack
from ehamj.control.settings import SampledSettings, SwingsUpError
from ehamj.errors import InputError
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel
from ehamj.linear.sampled import sampled_machine
from ehamj.plant.levers import MOTIONS
from ehamj.scenario.model import Scenario
from ehamj.settings import NotNegative, Positive, Settings

NO_LOOP, NO_SWAY = MotionLoop(crossing=0.0), SwayDamping(gain=0.0, centre=70.0)
THIRD = 2.0 ** (1 / 6) - 2.0 ** (-1 / 6)
"""Width of a third-octave over its centre."""


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


class SynthesisSettings(SampledSettings):
    """What every synthesised law has around the loops of heave, roll and pitch.

    The default weights of each synthesis leave the default machine 6 dB, 45° and a disk margin of 0.5 with its mass
    ±30 %, half the oil's stiffness or 1.5 times the flow gain, and damp its sway threefold (differential evolution over
    the weights).
    """

    kind: str
    heave: MotionWeights
    roll: MotionWeights
    pitch: MotionWeights
    feedforward: FeedforwardSettings | None = Field(
        FeedforwardSettings(), description="feedforward of the ground's velocity beside the loops; none: loops alone"
    )
    blend: Blend = Blend()
    warp: WarpBalance = WarpBalance()

    floor: Positive = Field(
        12.5e-6, description="velocity of the floor, RMS per third-octave from 1 to 80 Hz [m/s]; default: VC-C"
    )
    plant_order: Annotated[int, Field(ge=4)] = Field(
        16,
        description="states kept of each motion's plant; an eccentric centre of gravity brings yaw and both sways in",
    )
    order: Annotated[int, Field(ge=2)] = Field(10, description="states kept of each motion's loop")

    @abstractmethod
    def loop(self, plant: Block, weights: MotionWeights, scenario: Scenario) -> Block:
        """The loop of one motion by the synthesis: the bilinear image from blended displacement [m, rad], of roll and
        pitch also from the feet's mean sideways velocity [m/s], to piston velocity [m/s, rad/s].

        Raises:
            InputError: if there is none.
        """

    def law(self, scenario: Scenario, model: LinearModel) -> Controller:
        """The law for the linearised machine and the instruments of a scenario; ground and control play no part.

        Raises:
            InputError: if no law exists for these weights, it is unstable by itself, or the mounts drive other motions.
        """
        plant, sensors = scenario.plant, scenario.sensors
        more = [motion for motion in plant.layout.motions if motion not in MOTIONS]
        if more:
            raise InputError(
                f"design: the {self.kind} synthesis has weights for {', '.join(MOTIONS)}, and the mounts drive "
                f"{', '.join(more)} as well; take --architecture combined, which has a loop for each"
            )
        plants = motion_plants(scenario, model, self, self.plant_order).items()
        loops = {name: self.loop(own, getattr(self, name), scenario).sampled(self.period) for name, own in plants}
        try:
            laws = [self.modal().with_loops(plant, sensors, loops)]
        except SwingsUpError as error:
            raise InputError(
                "design: loops were found that would swing up while commands are limited, since they lean on the "
                "machine's sway, which the model of what the valves lost does not have; less gain helps"
            ) from error
        if self.feedforward is not None:
            laws.append(self.feedforward.model_copy(update=self.clock).controller(plant, sensors))
        return stack(laws)

    def noise_over_floor(self, weights: MotionWeights, scenario: Scenario) -> float:
        """r: the inertial instruments' noise over the floor's motion in the third-octave at the bandwidth [-]."""
        sensor = scenario.sensors.inertial
        if sensor is None:
            return 0.0
        return float(sensor.noise_density(weights.bandwidth) * np.sqrt(THIRD * weights.bandwidth) / self.floor)

    def low(self, weights: MotionWeights, scenario: Scenario) -> float:
        """ω_l/ω₀: where the floor's weight, ω₀ω_i/ω_l² at its end, is as far above one as the noise is below [-].

        Instruments allow no more, and the loop's integrals end there.

        Raises:
            InputError: if the noise leaves no room.
        """
        integral, noise = weights.integral / weights.bandwidth, self.noise_over_floor(weights, scenario)
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
        return ModalSettings().model_copy(update={**self.clock, "blend": self.blend, "warp": self.warp, **still})


def motion_plants(scenario: Scenario, model: LinearModel, settings: SynthesisSettings, order: int) -> dict[str, Block]:
    """Of each motion the bilinear image of its plant, with at most ``order`` states (balanced truncation).

    One input, the piston velocity [m/s, rad/s]; outputs are the blended displacement [m, rad], of roll and pitch also
    the feet's mean sideways velocity [m/s].

    Args:
        scenario: whose actuators the law inverts, and whose instruments measure.
        model: linearised machine that the law runs on; a varied one where robustness is in question.
        settings: blending, and what is closed within.
        order: states that are kept.
    """
    plant, sensors = scenario.plant, scenario.sensors
    at, layout, mounts = MountChannels.of(plant), plant.obeying.central, len(plant.obeying.mounts)
    machine = _with_inner(model, Loop.of(scenario, settings.modal().controller(plant, sensors)))
    blend = settings.blend.block(sensors.of(at.feet[0]), sensors.of(at.ground[0])).sampled(settings.period)
    valves = np.eye(len(plant.mounts))[:, list(plant.layout.active)]
    spread, fit, mean = valves @ volts(plant) @ layout.spread, layout.fit, np.full(mounts, 1.0 / mounts)
    sideways = {"roll": np.kron([0.0, 1.0], mean), "pitch": np.kron([1.0, 0.0], mean)}
    found = {}
    for k, motion in enumerate(layout.motions):
        readings = np.vstack([np.kron(np.eye(2), fit[k]), np.zeros((1, 2 * mounts))])  # the ground stands still
        readings, after = np.pad(readings, ((0, 0), (0, 2 * mounts))), blend
        if motion in sideways:
            readings = np.vstack([readings, np.pad(sideways[motion], (2 * mounts, 0))])
            after = beside([blend, Block.gain([[1.0]])])
        whole = machine.between(spread[:, [k]], readings).then(after)
        found[motion] = reduced(continuous(whole, settings.period), order)
    return found


def normalised(plant: Block, weights: MotionWeights) -> Block:
    """A motion's plant in units of ω₀: time ω₀ t, input piston velocity over ω₀, sideways velocity over ω₀."""
    omega = TWO_PI * weights.bandwidth
    units = np.array([1.0, 1.0 / omega])[: plant.C.shape[0], None]
    return Block(plant.A / omega, plant.B, units * plant.C, omega * units * plant.D)


def restored(law: Block, weights: MotionWeights) -> Block:
    """The loop for a `normalised` plant in SI."""
    omega = TWO_PI * weights.bandwidth
    units = np.array([omega, 1.0])[: law.B.shape[1]]
    return Block(omega * law.A, law.B * units, omega * law.C, law.D * units).times(weights.gain)


def towards_one(corner: float, low: float) -> Block:
    """(s + corner)/(s + low), its state of a size between input and output: slycot wants that."""
    share = np.sqrt(corner - low)
    return Block(*(np.array([[value]]) for value in (-low, share, share, 1.0)))


def continuous(block: Block, period: float) -> Block:
    """The continuous block whose trapezoidal image (`Block.sampled`) is this sampled one."""
    A, B, C, D = block
    inverse = np.linalg.inv(np.eye(A.shape[0]) + A)
    return Block(
        2.0 / period * (A - np.eye(A.shape[0])) @ inverse, 2.0 / period * inverse @ B, 2.0 * C @ inverse,
        D - C @ inverse @ B,
    )  # fmt: skip


def reduced(block: Block, order: int) -> Block:
    """A stable block with at most ``order`` states by balanced truncation (slycot AB09AD); it keeps its fast end.

    Raises:
        InputError: if the block is not stable.
    """
    import control

    if block.A.shape[0] <= order:
        return block
    if np.linalg.eigvals(block.A).real.max() >= 0.0:
        raise InputError(
            "design: what is to be reduced is not stable; loosen the weights, or check warp and sway loops"
        )
    with warnings.catch_warnings():
        # A block whose minimal realisation is smaller still becomes that one, which is what is wanted.
        warnings.filterwarnings("ignore", message="(?s).*greater.*minimal realization")
        small = control.balred(control.ss(*block), order, method="truncate")
    return Block(small.A, small.B, small.C, small.D)


def _with_inner(model: LinearModel, loop: Loop) -> Block:
    """The sampled machine from commands to its feet and strokes, the inner law of one rate closed around it.

    Outputs are what answers a command: vertical velocity of the feet, strokes, and the feet's velocity along x and y.
    """
    (inner,), at, mounts = loop.law.parts, MountChannels.of(model.plant), len(model.plant.mounts)
    names = (*at.feet, *at.strokes, *at.ahead, *at.across, *inner.inputs)
    outputs = len(names) - len(inner.inputs)
    probe = replace(inner, inputs=names, B=np.zeros((inner.states, len(names))), D=np.zeros((mounts, len(names))))
    open_loop = sampled_machine(model, replace(loop, law=probe))
    seen, read = open_loop.C[:outputs], open_loop.C[outputs:]
    A = np.block([[open_loop.A + open_loop.B @ inner.D @ read, open_loop.B @ inner.C], [inner.B @ read, inner.A]])
    B, C = np.pad(open_loop.B, ((0, inner.states), (0, 0))), np.pad(seen, ((0, 0), (0, inner.states)))
    return Block(A, B, C, np.zeros((outputs, mounts)))
