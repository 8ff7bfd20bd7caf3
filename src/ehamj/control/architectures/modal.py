"""Modal control: heave, roll and pitch of the machine held still in space, warp as a balance of pressures.

The four mounts measure and act together: feet, strokes and ground are turned into heave, roll and pitch by the plane
that fits them, z + y·rx − x·ry; the loops' piston velocities (`ehamj.control.inertial`) are handed back the same
way. The fourth pattern of four actuators (+ − − + on a rectangle) moves nothing and only builds pressure; its own loop
keeps the load pressures balanced.

Sway-rocking modes swing the centre of gravity sideways, where no actuator acts. Tilting the machine does act on it:
with the feet turned by θ the mass feels m ẍ + c ẋ + k x = −m h θ̈, so θ = −g ẋ of the feet's sideways velocity ẋ adds
h ω g/2 to the damping ratio.
"""

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.linalg import block_diag

from ehamj.control.blocks import TWO_PI, Block, added, beside, joined, pair
from ehamj.control.inertial import FEET, GROUND, STROKES, Blend, MotionLoop
from ehamj.control.inverse import Inverse, instrument_poles, lag, lost
from ehamj.control.law import Controller
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.control.settings import ISOLATE_FROM, DigitalSettings, NotNegative, Positive, per_mount
from ehamj.plant.mounts import N_MOUNTS
from ehamj.plant.plant import Plant
from ehamj.settings import Settings

Array = NDArray[np.float64]

ALONG, ACROSS = per_mount("foot_velocity", "x"), per_mount("foot_velocity", "y")
PRESSURES = per_mount("load_pressure")
MOTIONS = ("heave", "roll", "pitch")


def plane(plant: Plant) -> Array:
    """Height of each mount per heave [m], roll and pitch [rad]: columns 1, y, −x, shape (4, 3)."""
    return np.array([[1.0, y, -x] for x, y in plant.positions])


def warp(plant: Plant) -> Array:
    """Pattern of forces at the four mounts that moves nothing, (4,), of length two: + − − + on a rectangle."""
    pattern = np.linalg.svd(plane(plant).T)[2][-1]
    return np.asarray(2.0 * pattern * np.sign(pattern[0]))


class SwayDamping(Settings):
    """Damping of the sway-rocking mode of one plane by tilting the machine."""

    gain: NotNegative = Field(description="g: angle per sideways velocity of the feet [rad s/m]; 0: none")
    centre: Positive = Field(description="centre of the band in which it acts [Hz]")
    width: Positive = Field(0.2, description="width of the band: damping ratio of its poles [-]")

    def block(self) -> Block:
        """Angular velocity [rad/s] over sideways velocity [m/s]."""
        gain = self.gain * 2.0 * self.width * TWO_PI * self.centre
        return Block.filter([0.0, 0.0], pair(self.centre, self.width), -gain)


class WarpBalance(Settings):
    """The balance of load pressures in the warp pattern (+ − − + on a rectangle)."""

    crossing: NotNegative = Field(20.0, description="frequency below which the pressures are balanced [Hz]; 0: off")

    def block(self, plant: Plant) -> Block:
        """Command [V] over the warp's load pressure [Pa]: oil and valve together are an integrator, eq. 6."""
        rates = [4.0 * a.bulk_modulus / a.chamber_volume * a.flow_gain * a.valve_gain for a in plant.actuators]
        return Block.gain([[-TWO_PI * self.crossing / float(np.mean(rates))]])


class ModalSettings(DigitalSettings):
    """Modal feedback of the machine's absolute motion, with pressure balance and damping of sway.

    The defaults were found for the default machine by differential evolution: as much attenuation from 5 to 50 Hz as
    leaves 6 dB, 45° and a disk margin of 0.5 with the mass ±30 %, half the oil's stiffness or 1.5 times the flow gain,
    and raises the damping of the sway-rocking modes threefold. `ehamj design` fits the crossings to other machines.
    """

    kind: Literal["modal"] = "modal"
    heave: MotionLoop = MotionLoop(
        crossing=89.0, integral=14.4, lead=85.0, notch=204.0, notch_depth=0.324, notch_width=2.43, rolloff=16500.0
    )
    roll: MotionLoop = MotionLoop(
        crossing=34.5, integral=11.2, lead=103.0, notch=181.0, notch_depth=0.92, notch_width=1.0, rolloff=6880.0
    )
    pitch: MotionLoop = MotionLoop(
        crossing=35.0, integral=16.4, lead=114.0, notch=646.0, notch_depth=0.93, notch_width=0.96, rolloff=17500.0
    )
    blend: Blend = Blend()
    isolate_from: NotNegative = Field(0.0, description=ISOLATE_FROM)
    warp: WarpBalance = WarpBalance()
    sway_x: SwayDamping = SwayDamping(gain=3.12e-4, centre=62.6, width=0.473)
    sway_y: SwayDamping = SwayDamping(gain=4.02e-4, centre=65.9, width=0.32)

    def controller(self, plant: Plant, sensors: Sensors = IDEAL) -> Controller:
        """The law for a plant that is measured by ``sensors``."""
        creep = float(np.mean([Inverse.of(actuator).creep for actuator in plant.actuators]))
        loops: dict[str, MotionLoop] = {motion: getattr(self, motion) for motion in MOTIONS}
        sampled = {name: loop.block(creep).sampled(self.period) for name, loop in loops.items() if loop.crossing}
        return self.with_loops(plant, sensors, sampled)

    def with_loops(self, plant: Plant, sensors: Sensors, loops: Mapping[str, Block]) -> Controller:
        """The law with other loops: for some motions, sampled blocks from blended displacement [m, rad] to piston
        velocity [m/s, rad/s]; those of roll and pitch may have the feet's mean sideways velocity [m/s] as a second
        input.
        """
        wide = [motion for motion, loop in loops.items() if loop.B.shape[1] > 1]
        names = self._inputs(
            bool(loops), bool(self.sway_x.gain or "pitch" in wide), bool(self.sway_y.gain or "roll" in wide)
        )
        volts = np.diag([Inverse.of(actuator).volts for actuator in plant.actuators])
        columns, fit = plane(plant), np.linalg.pinv(plane(plant))
        foot = sensors.of(FEET[0])
        blend = self.blend.block(foot, sensors.of(GROUND[0]), self.isolate_from)
        late = self.hold + lag(instrument_poles(foot)[1])
        owed = lost(plant.actuators[0], late, self.recovery, self.period).times(-1.0)
        blocks = []
        for k, motion in enumerate(MOTIONS):
            if motion in loops:
                measured = np.vstack([_picked(names, group, fit[k]) for group in (FEET, STROKES, GROUND)])
                seen = joined([blend.sampled(self.period), owed])
                rows = block_diag(measured, fit[k])
                if motion in wide:
                    # Sideways velocity lies among the measured, before what the valves did not get.
                    mean = _picked(names, ALONG if motion == "pitch" else ACROSS, np.full(N_MOUNTS, 1.0 / N_MOUNTS))
                    seen = beside([seen, Block.gain([[1.0]])])
                    rows = np.vstack([rows, np.pad(mean, ((0, 0), (0, N_MOUNTS)))])
                blocks.append(seen.then(loops[motion]).between(rows, volts @ columns[:, [k]]))
        # A positive pitch moves what stands above the mounts along x, a positive roll against y.
        for sway, group, k, sign in ((self.sway_x, ALONG, 2, 1.0), (self.sway_y, ACROSS, 1, -1.0)):
            if sway.gain:
                mean = _picked(names, group, np.full(N_MOUNTS, 1.0 / N_MOUNTS))
                one = sway.block().sampled(self.period)
                blocks.append(one.between(mean, sign * volts @ columns[:, [k]]).padded(0, N_MOUNTS))
        if self.warp.crossing:
            pattern = warp(plant)
            measured = _picked(names, PRESSURES, pattern / N_MOUNTS)
            blocks.append(self.warp.block(plant).between(measured, pattern[:, None]).padded(0, N_MOUNTS))
        if not blocks:
            blocks = [Block.gain(np.zeros((N_MOUNTS, N_MOUNTS)))]
        return self.digital(added(blocks), names, plant)

    def _inputs(self, moves: bool, along: bool, across: bool) -> tuple[str, ...]:
        names = (*FEET, *STROKES, *GROUND) if moves else ()
        names += (*(ALONG if along else ()), *(ACROSS if across else ()))
        return names + (PRESSURES if self.warp.crossing else ())


def _picked(names: tuple[str, ...], group: tuple[str, ...], weights: Array) -> Array:
    """Row over the inputs that weighs those of a group, (1, inputs)."""
    row = np.zeros((1, len(names)))
    row[0, [names.index(name) for name in group]] = weights
    return row
