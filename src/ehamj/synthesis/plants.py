"""The plant of one motion: what its loop sees from sample to sample, as its bilinear image (`ehamj.synthesis.images`).

Heave, roll and pitch are nearly decoupled (`ehamj.control.architectures.modal`). A loop's plant reaches from the piston
velocity that it asks for to the blended displacement (`ehamj.control.inertial`), through converter delay and hold,
valves, oil, machine and instruments, with the warp balance closed. Roll and pitch are measured by the feet's sideways
velocity too: with the angle held still, sway has the damping of the membranes alone.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ehamj.control.blocks import Block, beside
from ehamj.control.channels import MountChannels
from ehamj.control.inverse import volts
from ehamj.control.sensors import Sensors
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel
from ehamj.linear.sampled import sampled_machine
from ehamj.plant.plant import Plant
from ehamj.synthesis.images import continuous, reduced

if TYPE_CHECKING:
    from ehamj.synthesis.settings import SynthesisSettings


def motion_plants(
    model: LinearModel, settings: "SynthesisSettings", plant: Plant, sensors: Sensors, order: int, seed: int = 0
) -> dict[str, Block]:
    """Of each motion the bilinear image of its plant, with at most ``order`` states (balanced truncation).

    One input, the piston velocity [m/s, rad/s]; outputs are the blended displacement [m, rad], of roll and pitch also
    the feet's mean sideways velocity [m/s].

    Args:
        model: linearised machine that the law runs on; a varied one where robustness is in question.
        settings: blending, and what is closed within.
        plant: whose actuators the law inverts.
        sensors: that measure.
        order: states that are kept.
        seed: that draws the directions of misaligned instruments.
    """
    at, layout, mounts = MountChannels.of(plant), plant.obeying.central, len(plant.obeying.mounts)
    machine = _with_inner(model, Loop(settings.modal().controller(plant, sensors), sensors, seed))
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
