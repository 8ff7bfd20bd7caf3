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
    spool: float, rate: float, target: float, frequency: float, damping: float, drive_limit: float, threshold: float
) -> float:
    """Acceleration of the spool [mA/s²]: ẍ = clip(ω_v²(c − x), ±a_max) − 2ζω_v ẋ.

    The solenoid's force saturates, the damping does not. ``frequency`` ω_v [rad/s], ``damping`` ζ, ``drive_limit``
    a_max [mA/s²]. Within ±``threshold`` [mA] of its target nothing drives the spool; beyond, the excess does. Unclipped
    and without threshold it is the paper's eq. 1.
    """
    error = target - spool
    error -= min(max(error, -threshold), threshold)
    drive = frequency * frequency * error
    drive = min(max(drive, -drive_limit), drive_limit)
    return drive - 2.0 * damping * frequency * rate


@kernel
def held_by_stop(spool: float, rate: float, acceleration: float, stroke: float) -> tuple[float, float]:
    """Rate and acceleration of a spool with end stops at ±``stroke`` [mA]: a stop takes no push and gives no bounce."""
    if abs(spool) < stroke:
        return rate, acceleration
    if spool * rate >= 0.0:
        rate = 0.0
        if spool * acceleration > 0.0:
            acceleration = 0.0
    return rate, acceleration


@kernel
def play(memory: float, spool: float, width: float) -> float:
    """Hysteresis: the metering edges follow the spool with a play of ``width`` [mA]; ``memory`` is where they stood.

    While the spool moves one way this is exact however far it moves; 0 wide, it is the spool itself.
    """
    return min(max(memory, spool - 0.5 * width), spool + 0.5 * width)


@kernel
def turbulence(ratio: float, laminar_ratio: float) -> float:
    """Orifice law φ(r) = r/(r² + ε²)^¼: √r, signed, with a smooth laminar end; ε = 0 is the plain signed root."""
    # The last term only keeps 0/0 away; it is far below the square of any pressure ratio.
    return ratio / math.sqrt(math.sqrt(ratio * ratio + laminar_ratio * laminar_ratio + 1e-300))


@kernel
def port_flow(
    opening: float,
    pressure: float,
    supply: float,
    tank: float,
    rated: float,
    gain: float,
    leakage: float,
    laminar_ratio: float,
) -> tuple[float, float]:
    """Flow into a port, and the part of it that the supply gives [m³/s].

    ``opening`` [mA] connects the port to the supply where positive and to the tank where negative; ``pressure``,
    ``supply``, ``tank`` [Pa]; ``gain`` K_Q [m³/s/mA] holds at the ``rated`` drop Δp₀ = (P_s − P_t)/2; ``leakage``
    g₀ [m³/s/Pa] is the laminar conductance of each of the port's two edges.
    """
    # One orifice serves both directions: the root is most of the cost of a step, and a branch would double it.
    drop = supply - pressure if opening > 0.0 else pressure - tank
    # 1/rated is shared by both ports of a valve.
    through = gain * opening * turbulence(drop * (1.0 / rated), laminar_ratio)
    drawn = leakage * (supply - pressure)
    drained = leakage * (pressure - tank)
    return through + drawn - drained, drawn + (through if opening > 0.0 else 0.0)


@kernel
def lapped_port_flow(
    feeding: float,
    draining: float,
    pressure: float,
    supply: float,
    tank: float,
    rated: float,
    gain: float,
    leakage: float,
    laminar_ratio: float,
) -> tuple[float, float]:
    """As `port_flow`, for edges that open on their own: ``feeding`` from the supply, ``draining`` to the tank [mA]."""
    drawn = gain * feeding * turbulence((supply - pressure) / rated, laminar_ratio) + leakage * (supply - pressure)
    drained = gain * draining * turbulence((pressure - tank) / rated, laminar_ratio) + leakage * (pressure - tank)
    return drawn - drained, drawn


@kernel
def curved_opening(opening: float, stroke: float, curve) -> float:  # type: ignore[no-untyped-def]
    """Opening that gives a linear valve the flow of a maker's curve [mA].

    ``curve`` holds shares of the full flow at equal shares of the ``stroke`` from 0 to 1; between them it is straight.
    """
    place = min(abs(opening) / stroke, 1.0) * (curve.size - 1)
    k = min(int(place), curve.size - 2)
    share = curve[k] + (place - k) * (curve[k + 1] - curve[k])
    return math.copysign(stroke * share, opening)
