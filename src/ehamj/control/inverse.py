"""What a law must know of an isolator: how fast a command moves its piston, and what instruments add.

About rest, with the machine's inertia left out (eqs. 3, 6, 7 with M s² x_p = 0), a command v moves the piston as

    ẋ_p = v·valve(s)/b·s/(s + c),   b = (A_p/(K_Q K_v))·(1 + K_L/K_h + K_C C/A_p²),   c = K_C K_L/A_p²/(1 + …)

so that below c (7 Hz in the paper's prototype) leakage and membrane ask for a command that grows as 1/f. The term
C s/K_h, 4e-4 at 100 Hz, is left out.

Isolators in several directions carry more than their own membranes: what the lateral membranes of all mounts, and
passive mounts, exert on the machine is shared by those that act (`shares`), and K_L becomes a matrix over them
(`carried`). Upright ones in the mount plane carry none of it.
"""

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ehamj.arrays import Array, ComplexArray
from ehamj.control.blocks import Block
from ehamj.control.instruments import Instrument
from ehamj.isolator.actuator import Actuator
from ehamj.plant.levers import lever
from ehamj.plant.plant import Plant

SLOW = 5.0
"""Corner that parts an instrument's high-pass from its low-pass [Hz]."""


class Inverse(NamedTuple):
    """The inverse of an isolator without its valve's dynamics."""

    volts: float
    """b: command per piston velocity [V s/m]."""
    creep: float
    """c: corner below which leakage and membrane bind [rad/s]."""

    @classmethod
    def of(cls, actuator: Actuator, more: float = 0.0) -> "Inverse":
        """Of one actuator, which carries ``more`` than its own membrane [N/m]."""
        a = actuator
        stiffness = a.membrane_stiffness + more
        damping = a.flow_pressure * a.membrane_damping / a.piston_area**2
        speed = 1.0 + stiffness / a.hydraulic_stiffness + damping
        creep = a.flow_pressure * stiffness / a.piston_area**2
        return cls(a.piston_area / (a.flow_gain * a.valve_gain) * speed, creep / speed)


class Others(NamedTuple):
    """What a mount exerts on the machine beside the force of an actuator that obeys, at its foot."""

    stiffness: Array
    """(3, 3) [N/m]."""
    damping: Array
    """(3, 3) [N s/m]."""


def others(plant: Plant) -> tuple[Others, ...]:
    """Lateral membranes of every mount, and of passive ones the axial membrane too."""
    found = []
    for actuator, direction in zip(plant.actuators, plant.directions, strict=True):
        along = np.outer(direction, direction)
        across, axial = np.eye(3) - along, along * float(actuator.passive)
        found.append(
            Others(
                actuator.lateral_stiffness * across + actuator.membrane_stiffness * axial,
                actuator.lateral_damping * across + actuator.membrane_damping * axial,
            )
        )
    return tuple(found)


def shares(plant: Plant) -> Array:
    """Force of each active mount per wrench on the machine, N and N m about the mount plane's centre, that they bear
    together in the motions that they drive, (active, 6): (Jᵀ)⁺ where those are all six."""
    layout = plant.layout
    return np.asarray((layout.basis @ layout.fit[:, list(layout.active)]).T)


def carried(plant: Plant) -> Array:
    """Force of each active mount per strokes of all, beside its own membrane's, as they move the machine [N/m],
    (active, active)."""
    feet = [lever(position) for position in plant.positions]
    whole = np.sum([foot.T @ one.stiffness @ foot for foot, one in zip(feet, others(plant), strict=True)], axis=0)
    by = shares(plant)
    return np.asarray(by @ whole @ by.T)


def volts(plant: Plant) -> Array:
    """Command of each active valve per piston velocities [V s/m], (active, active)."""
    own = plant.obeying.actuators
    more = [a.piston_area / (a.flow_gain * a.valve_gain) / a.hydraulic_stiffness for a in own]
    return np.diag([Inverse.of(actuator).volts for actuator in own]) + np.array(more)[:, None] * carried(plant)


def carried_in(plant: Plant, strokes: Array) -> float:
    """Stiffness that each active mount carries beside its own membrane's in a pattern of ``strokes`` [N/m]."""
    return float(strokes @ carried(plant) @ strokes / (strokes @ strokes))


def creep(plant: Plant, strokes: Array | None = None) -> float:
    """Mean c of the isolators [rad/s], with what they carry in a pattern of ``strokes`` (active,)."""
    more = 0.0 if strokes is None else carried_in(plant, strokes)
    return float(np.mean([Inverse.of(actuator, more).creep for actuator in plant.obeying.actuators]))


def creeps_of(plant: Plant) -> tuple[float, ...]:
    """c of each active isolator with what it carries by itself [rad/s]."""
    more = np.diag(carried(plant)).tolist()
    return tuple(Inverse.of(one, by).creep for one, by in zip(plant.obeying.actuators, more, strict=True))


def valve_poles(actuator: Actuator) -> ComplexArray:
    """Roots of 1 + 2ζs/ω_v + s²/ω_v² [rad/s] (eq. 1)."""
    omega = actuator.valve_frequency
    return np.asarray(np.roots([1.0, 2.0 * actuator.valve_damping * omega, omega**2]), complex)


def instrument_poles(sensor: Instrument | None) -> tuple[ComplexArray, ComplexArray]:
    """Poles of an instrument's high-pass and of its low-pass [rad/s]; empty for an ideal one."""
    found: dict[str, list[complex]] = {"highpass": [], "lowpass": []}
    if sensor is not None:
        for kind, corner in sensor.filters:
            _, poles, _ = scipy.signal.butter(sensor.order, 2 * np.pi * corner, kind, analog=True, output="zpk")
            found[kind].extend(poles)
    return np.array(found["highpass"], complex), np.array(found["lowpass"], complex)


def lag(poles: ArrayLike) -> float:
    """Delay at low frequency of a low-pass with these poles [s]: Σ −1/p."""
    return float(np.sum(-1.0 / np.asarray(poles, complex)).real)


def lost(actuator: Actuator, late: float, recovery: float, period: float) -> Block:
    """Sampled block: displacement that a piston owes, as it is measured [m], over what its valve did not get [V].

    A law that subtracts it sees a machine without limits (internal-model anti-windup, Zheng, Kothare and Morari 1994):
    its integrals do not wind up. What was lost is made good over ``recovery`` [s], slowly beside the bands that are to
    be quiet, and not as the isolator by itself would, in 1/c (24 ms); `held` asks for the command that this takes.

    Args:
        actuator: isolator.
        late: delay from a command to its reading [s].
        recovery: time constant [s].
        period: sampling period [s].
    """
    inverse = Inverse.of(actuator)
    poles = np.concatenate([valve_poles(actuator), [-1.0 / recovery], np.full(2, -2.0 / late)])
    gain = actuator.valve_frequency**2 * (2.0 / late) ** 2 / inverse.volts
    return Block.filter([], poles, gain).held(period)


def held(actuator: Actuator, recovery: float, period: float) -> Block:
    """Sampled block: command that lets what was lost come back over ``recovery`` [s], over what was lost of it [V].

    The isolator answers with (s + c)⁻¹; to answer with (s + 1/recovery)⁻¹ it needs (c − 1/recovery)/(s + 1/recovery).
    """
    slow = 1.0 / recovery
    return Block.filter([], [-slow], Inverse.of(actuator).creep - slow).held(period)


def restoring(slow: ComplexArray, corner: float) -> tuple[ComplexArray, ComplexArray]:
    """Zeros and poles that move an instrument's high-pass down to ``corner`` [Hz]; it is not moved up."""
    if slow.size == 0:
        return slow, slow
    shift = min(1.0, 2 * np.pi * corner / float(np.abs(slow).max()))
    return slow, shift * slow
