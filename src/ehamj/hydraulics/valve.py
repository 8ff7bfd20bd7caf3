"""The servo valve: spool dynamics and the flow over its four edges."""

import math

from ehamj.compiled import kernel


@kernel
def spool_target(voltage: float, valve_gain: float, voltage_limit: float) -> float:
    """Spool position that a command asks for, c = K_v·sat(v) [mA] (paper eq. 1, static part).

    ``voltage`` v [V], ``valve_gain`` K_v [mA/V], ``voltage_limit`` [V].
    """
    return valve_gain * min(max(voltage, -voltage_limit), voltage_limit)


@kernel
def spool_acceleration(
    spool: float, rate: float, target: float, frequency: float, damping: float, drive_limit: float
) -> float:
    """Acceleration of the spool [mA/s²]: ẍ = clip(ω_v²(c − x), ±a_max) − 2ζω_v ẋ.

    The solenoid's force saturates, the damping does not. ``frequency`` ω_v [rad/s], ``damping`` ζ,
    ``drive_limit`` a_max [mA/s²]. Unclipped it is the paper's eq. 1.
    """
    drive = frequency * frequency * (target - spool)
    drive = min(max(drive, -drive_limit), drive_limit)
    return drive - 2.0 * damping * frequency * rate


@kernel
def turbulence(ratio: float, laminar_ratio: float) -> float:
    """Orifice law φ(r) = r/(r² + ε²)^¼: √r, signed, with a smooth laminar end; ε = 0 is the plain signed root."""
    # The last term only keeps 0/0 away; it is far below the square of any pressure ratio.
    return ratio / math.sqrt(math.sqrt(ratio * ratio + laminar_ratio * laminar_ratio + 1e-300))


@kernel
def port_flow(
    opening: float, pressure: float, supply: float, tank: float, gain: float, leakage: float, laminar_ratio: float
) -> tuple[float, float]:
    """Flow into a port, and the part of it that the supply gives [m³/s].

    ``opening`` [mA] connects the port to the supply where positive and to the tank where negative; ``pressure``,
    ``supply``, ``tank`` [Pa]; ``gain`` K_Q [m³/s/mA] holds at the rated drop Δp₀ = (P_s − P_t)/2; ``leakage`` g₀
    [m³/s/Pa] is the laminar conductance of each of the port's two edges.
    """
    # One orifice serves both directions: the root is most of the cost of a step, and a branch would double it.
    drop = supply - pressure if opening > 0.0 else pressure - tank
    through = gain * opening * turbulence(2.0 * drop / (supply - tank), laminar_ratio)
    drawn = leakage * (supply - pressure)
    drained = leakage * (pressure - tank)
    return through + drawn - drained, drawn + (through if opening > 0.0 else 0.0)
