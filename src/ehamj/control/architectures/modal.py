"""Modal control: the motions that the mounts drive held still in space, warp as a balance of pressures.

The mounts measure and act together: feet, strokes and ground, each along its mount, are turned into the rigid motion
that fits them; the loops' piston velocities (`ehamj.control.inertial`) are handed back the same way. Upright ones
drive heave, roll and pitch, z + y·rx − x·ry; mounts in other directions surge, sway and yaw as well. Rotations turn
about the height of the centre of gravity (`Plant.central`), so that with level mounts at that height surge and sway do
not tilt the machine. What actuators can do beside (+ − − + of four on a rectangle) moves nothing and only builds
pressure; a loop of its own keeps the load pressures balanced in every such pattern.

Where nothing acts sideways, sway-rocking modes swing the centre of gravity there. Tilting the machine does act on it:
with the feet turned by θ the mass feels m ẍ + c ẋ + k x = −m h θ̈, so θ = −g ẋ of the feet's sideways velocity ẋ adds
h ω g/2 to the damping ratio. Level mounts damp these modes directly, by their loops, and nothing is tilted.
"""

from collections.abc import Mapping, Sequence
from typing import Literal, Self

import numpy as np
import scipy
from pydantic import Field

from ehamj.arrays import Array
from ehamj.control.balance import WarpBalance
from ehamj.control.blocks import TWO_PI, Block, added, beside, joined, pair, response
from ehamj.control.channels import MountChannels
from ehamj.control.inertial import Blend, MotionLoop
from ehamj.control.inverse import creep, instrument_poles, lag, lost, volts
from ehamj.control.law import Controller
from ehamj.control.preview import followed
from ehamj.control.sensors import Sensors
from ehamj.control.settings import ISOLATE_FROM, DigitalSettings
from ehamj.control.windup import AntiWindup
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative, Positive, Settings

REFERENCE = {"sway_x": 70.66, "sway_y": 70.03}
"""Sway-rocking frequencies of the default machine [Hz], which the damping of sway was found for."""
REFERENCE_HEIGHT = 0.75
"""Height of its centre of gravity [m]."""


class SwayDamping(Settings):
    """Damping of the sway-rocking mode of one plane by tilting the machine, where no mount acts along that axis."""

    gain: NotNegative = Field(description="g: angle per sideways velocity of the feet [rad s/m]; 0: none")
    centre: Positive = Field(description="centre of the band in which it acts [Hz]")
    width: Positive = Field(0.2, description="width of the band: damping ratio of its poles [-]")

    def block(self) -> Block:
        """Angular velocity [rad/s] over sideways velocity [m/s]."""
        gain = self.gain * 2.0 * self.width * TWO_PI * self.centre
        return Block.filter([0.0, 0.0], pair(self.centre, self.width), -gain)


class ModalSettings(DigitalSettings):
    """Modal feedback of the machine's absolute motion, with pressure balance and damping of sway.

    Loops of motions that the mounts do not drive are left out.

    The defaults were found for the default machine by differential evolution: as much attenuation from 5 to 50 Hz as
    leaves 6 dB, 45° and a disk margin of 0.5 with the mass ±30 %, half the oil's stiffness or 1.5 times the flow gain,
    and raises the damping of the sway-rocking modes threefold; those of surge, sway and yaw for the same machine with
    four level isolators beside (scenario ``six-directions``). `ehamj design` fits the crossings to other machines.
    """

    kind: Literal["modal"] = "modal"
    heave: MotionLoop = MotionLoop.stated(
        crossing=89.0, integral=14.4, lead=85.0, notch=204.0, notch_depth=0.324, notch_width=2.43, rolloff=16500.0
    )
    roll: MotionLoop = MotionLoop.stated(
        crossing=34.5, integral=11.2, lead=103.0, notch=181.0, notch_depth=0.92, notch_width=1.0, rolloff=6880.0
    )
    pitch: MotionLoop = MotionLoop.stated(
        crossing=35.0, integral=16.4, lead=114.0, notch=646.0, notch_depth=0.93, notch_width=0.96, rolloff=17500.0
    )
    surge: MotionLoop = MotionLoop.stated(
        crossing=41.0, integral=39.0, lead=92.0, notch=225.0, notch_depth=0.55, notch_width=0.476, rolloff=18700.0
    )
    sway: MotionLoop = MotionLoop.stated(
        crossing=40.5, integral=39.0, lead=90.0, notch=227.0, notch_depth=0.545, notch_width=0.5, rolloff=19000.0
    )
    yaw: MotionLoop = MotionLoop.stated(
        crossing=48.0, integral=39.5, lead=130.0, notch=227.0, notch_depth=0.727, notch_width=0.259, rolloff=17300.0
    )
    blend: Blend = Blend.stated()
    isolate_from: NotNegative = Field(0.0, description=ISOLATE_FROM)
    warp: WarpBalance = WarpBalance.stated()
    sway_x: SwayDamping = SwayDamping.stated(gain=3.12e-4, centre=62.6, width=0.473)
    sway_y: SwayDamping = SwayDamping.stated(gain=4.02e-4, centre=65.9, width=0.32)

    def controller(self, plant: Plant, sensors: Sensors) -> Controller:
        layout, sampled = plant.obeying.central, {}
        for motion, loop in self.loops(plant).items():
            strokes = layout.spread[:, layout.motions.index(motion)]
            sampled[motion] = loop.block(creep(plant, strokes)).sampled(self.period)
        return self.with_loops(plant, sensors, sampled)

    def asked(self, motion: str, s: complex, creep: float) -> complex:
        """What the motion's loop asks for."""
        loop = self.loops().get(motion)
        return 0.0 if loop is None else complex(response(np.array([s]), *loop.block(creep))[0, 0, 0])

    def fitted(self, modes: Sequence[tuple[str, float]], height: float) -> Self:
        """Damping of sway, where there is any, stands at the machine's own sway-rocking modes."""
        changed: dict[str, SwayDamping] = {}
        for name, mode in (("sway_x", "sway-rocking about y"), ("sway_y", "sway-rocking about x")):
            own: SwayDamping = type(self).model_fields[name].default
            found = next((frequency for label, frequency in modes if label.endswith(mode)), None)
            if found is not None and getattr(self, name).gain:
                by = found / REFERENCE[name]
                gain = own.gain * REFERENCE_HEIGHT / max(height, 0.2) / by  # h ω g/2 is the damping added
                changed[name] = own.model_copy(update={"centre": own.centre * by, "gain": gain})
        return self.model_copy(update=changed)

    def with_loops(self, plant: Plant, sensors: Sensors, loops: Mapping[str, Block]) -> Controller:
        """The law with other loops: for some motions, sampled blocks from blended displacement [m, rad] to piston
        velocity [m/s, rad/s]; those of roll and pitch may have the feet's mean sideways velocity [m/s] as a second
        input.
        """
        at, layout, mounts = MountChannels.of(plant), plant.obeying.central, len(plant.obeying.mounts)
        sideways = self._sideways(plant)
        wide = [motion for motion, loop in loops.items() if loop.B.shape[1] > 1]
        names = (*at.feet, *at.strokes, *at.ground) if loops else ()
        for motion, (group, sway, _) in sideways.items():
            names += group if sway.gain or motion in wide else ()
        names += at.pressures if self.warp.crossing else ()
        upstream = sensors.upstream if self.isolate_from and loops else None
        follows = () if upstream is None else tuple(f"followed {motion}" for motion in layout.motions)
        measured, spread = names + follows, volts(plant) @ layout.spread
        mean = np.full(mounts, 1.0 / mounts)
        blocks = []
        seen = self._seen(plant, sensors) if loops else None
        for k, motion in enumerate(layout.motions):
            if motion in loops and seen is not None:
                fit = layout.fit[k]
                seeing = [_picked(measured, group, fit) for group in at[:3]]
                seeing += [_picked(measured, (follows[k],), np.ones(1))] if follows else []
                rows = scipy.linalg.block_diag(np.vstack(seeing), fit)
                own = seen
                if motion in wide:
                    # Sideways velocity lies among the measured, before what the valves did not get.
                    own = beside([seen, Block.gain([[1.0]])])
                    beyond = _picked(measured, sideways[motion][0], mean)
                    rows = np.vstack([rows, np.pad(beyond, ((0, 0), (0, mounts)))])
                blocks.append(own.then(loops[motion]).between(rows, spread[:, [k]]))
        for motion, (group, sway, sign) in sideways.items():
            if sway.gain:
                tilts = sign * spread[:, [layout.motions.index(motion)]]
                blocks.append(
                    sway.block().sampled(self.period).between(_picked(measured, group, mean), tilts).padded(0, mounts)
                )
        if self.warp.crossing:
            blocks.append(self.warp.block(plant).padded(len(names) - mounts, len(follows) + mounts))
        law = added(blocks) if blocks else Block.gain(np.zeros((mounts, mounts)))
        if upstream is not None:
            weights = np.zeros((len(follows), len(plant.mounts), len(AXES)))
            weights[:, list(plant.layout.active)] = layout.fit[:, :, None] * np.array(plant.obeying.directions)
            ahead, block = followed(plant, upstream, self.isolate_from, weights)
            whole = [Block.gain(np.eye(len(names))), block.sampled(self.period), Block.gain(np.eye(mounts))]
            names, law = names + ahead, beside(whole).then(law)
        return self.digital(law, names, plant, sensors=sensors, anti_windup=AntiWindup.INPUTS)

    def _sideways(self, plant: Plant) -> dict[str, tuple[tuple[str, ...], SwayDamping, float]]:
        """By the motion that damps sway where nothing else does: the feet's sideways velocities, its damping, and sign.

        A positive pitch moves what stands above the mounts along x, a positive roll against y.
        """
        at, driven = MountChannels.of(plant), plant.layout.motions
        found = {"pitch": (at.ahead, self.sway_x, 1.0), "roll": (at.across, self.sway_y, -1.0)}
        own = {"pitch": "surge", "roll": "sway"}
        return {name: one for name, one in found.items() if name in driven and own[name] not in driven}

    def _seen(self, plant: Plant, sensors: Sensors) -> Block:
        """Sampled: displacement of a motion from inertial velocity, stroke, ground velocity, with a sensor upstream the
        velocity that it follows, and what valves lost."""
        at = MountChannels.of(plant)
        foot = sensors.of(at.feet[0])
        blend = self.blend.seeing(foot, sensors.of(at.ground[0]), self.isolate_from, sensors.upstream is not None)
        late = self.hold + lag(instrument_poles(foot)[1])
        owed = lost(plant.obeying.actuators[0], late, self.recovery, self.period).times(-1.0)
        return joined([blend.sampled(self.period), owed])


def _picked(names: tuple[str, ...], group: tuple[str, ...], weights: Array) -> Array:
    """Row over the inputs that weighs those of a group, (1, inputs)."""
    row = np.zeros((1, len(names)))
    row[0, [names.index(name) for name in group]] = weights
    return row
