"""What limits the isolation: contributions to the machine's vertical motion per third-octave band, and which binds.

Linear contributions come from the closed loop: what law, delay and valve leave of the floor's heave, and what each
class of instruments adds by its noise. Two more are estimates: rounding of the commands as white noise of Δ²/12, and
the turbulent flow, whose gain varies with load pressure as √(1 ∓ P_L/(P_s − P_t)). With P_L = K_L d/A_p at stroke d and
a command for ḋ + c d, the error of piston velocity is ε d (ḋ + c d), ε = K_L/(2 A_p (P_s − P_t)); of a stroke whose
slow part has the RMS σ, a band's part of it is εσ √(1 + (2c/ω)²) of the band's velocity, which the feedback reduces by
its sensitivity. The voltage is judged by the command's RMS: a Gaussian command exceeds the limit a for the share
erfc(a/(√2 σ)) of the time.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from scipy.special import erfc

from ehamj.arrays import Array, ComplexArray
from ehamj.control import LinearController
from ehamj.control.inverse import Inverse, instrument_poles, lag, valve_poles
from ehamj.control.sensors import class_of
from ehamj.estimate.bands import BAND_LOG_WIDTH, Band, bands
from ehamj.estimate.reading import band_rms
from ehamj.ground.broadband import BroadbandGround
from ehamj.linear.loop import Loop, feeds_back, opened
from ehamj.linear.machine import LinearModel
from ehamj.linear.response import ground_response, readings_of_ground, slab_pattern
from ehamj.plant.axes import AXES
from ehamj.scenario.model import Scenario

BANDS: Final = bands(0.5, 315.0)
"""From below the bands that criteria ask for: there the command grows as 1/f."""
PER_BAND: Final = 6
"""Frequencies at which a band is looked at."""
UNSTATED: Final = BroadbandGround(kind="broadband", level="VC-C")
"""Floor that is taken where the scenario's rests."""
FLOOR_TIME: Final = 20.0
FLOOR_RATE: Final = 1000.0
OUTPUT: Final = ("cg_velocity z",)


@dataclass(frozen=True)
class Budget:
    """RMS velocity of the machine's CG, vertical, per band [m/s], by what causes it; and of the floor.

    ``command`` is the RMS of one valve's command by the floor and by noise [V], ``limit`` its range [V].
    """

    bands: tuple[Band, ...]
    floor: Array
    contributions: Mapping[str, Array]
    command: Mapping[str, float]
    limit: float
    phases: Mapping[str, float]
    """Lags at the crossing of heave [deg], by cause, and the crossing [Hz]; empty without feedback."""

    @property
    def total(self) -> Array:
        """All contributions together [m/s]; they are taken as independent."""
        return np.asarray(np.sqrt(sum(part**2 for part in self.contributions.values())))

    @property
    def binding(self) -> tuple[str, ...]:
        """The largest contribution in each band."""
        names = list(self.contributions)
        return tuple(names[k] for k in np.argmax(np.array(list(self.contributions.values())), axis=0))

    @property
    def command_rms(self) -> float:
        """RMS of one valve's command by all causes [V]."""
        return float(np.sqrt(sum(part**2 for part in self.command.values())))

    @property
    def saturated(self) -> float:
        """Share of the time at which a Gaussian command of this RMS is beyond its range."""
        sigma = self.command_rms
        return float(erfc(self.limit / (np.sqrt(2.0) * sigma))) if sigma > 0 else 0.0

    def to_dict(self) -> dict[str, Any]:
        """As plain data, SI."""

        def per_band(values: Array) -> dict[str, float]:
            return {band.name: float(value) for band, value in zip(self.bands, values, strict=True)}

        return {
            "floor_m_s": per_band(self.floor),
            "machine_m_s": per_band(self.total),
            "contributions_m_s": {cause: per_band(part) for cause, part in self.contributions.items()},
            "binding": {band.name: cause for band, cause in zip(self.bands, self.binding, strict=True)},
            "command_rms_v": dict(self.command),
            "command_limit_v": self.limit,
            "saturated_share": self.saturated,
            "phase_at_crossing": dict(self.phases),
        }


def budget(scenario: Scenario, model: LinearModel, law: LinearController) -> Budget:
    """The budget of a law on a scenario's machine and floor.

    Args:
        scenario: its floor gives the levels (mean of the mounts, vertical; VC-C where it rests), its sensors the noise.
        model: the linearised machine.
        law: digital controller.
    """
    loop, floor = Loop.of(scenario, law), floor_levels(scenario)
    edges = np.array([band.edges for band in BANDS])
    f = np.concatenate([low * (high / low) ** ((np.arange(PER_BAND) + 0.5) / PER_BAND) for low, high in edges])
    widths = np.repeat((edges[:, 1] - edges[:, 0]) / PER_BAND, PER_BAND)

    cut = opened(model, loop, f)
    sensitivity = cut.sensitivity
    closed = sensitivity @ cut.law  # commands over what is added to the readings
    drive = model.response(f, OUTPUT, model.commands)
    heave = slab_pattern(model.plant, ("z",))
    answer = closed @ (readings_of_ground(model, loop, f) @ heave)  # commands over the floor's heave
    passed = (
        ground_response(model, f, ("cg_displacement z",)) @ heave + drive @ answer / (2j * np.pi * f)[:, None, None]
    )
    left = np.sqrt(_per_band(np.abs(passed[:, 0, 0]) ** 2)) * floor
    moved = (drive @ closed)[:, 0, :]
    contributions = {"law, delay and valve": left}
    density, classes = _densities(loop, f), [class_of(name.partition(" ")[0]) for name in law.inputs]
    for table in dict.fromkeys(classes):
        own = [k for k, one in enumerate(classes) if one == table]
        motion = np.sum(np.abs(moved[:, own]) ** 2 * density[:, own] ** 2, axis=1)
        if np.any(density[:, own]):
            contributions[f"noise of {table} sensors"] = np.sqrt(_per_band(motion * widths) * PER_BAND)
    shaken = np.sum(np.abs((drive @ sensitivity)[:, 0, :]) ** 2, axis=1)
    nyquist = 0.5 / min(part.period for part in law.parts)
    step = law.converter.resolution
    contributions["rounding of commands"] = np.sqrt(_per_band(shaken * step**2 / 12.0 / nyquist * widths) * PER_BAND)
    contributions["turbulent flow"] = _turbulence(scenario, floor, sensitivity)
    per_velocity = np.abs(answer[:, 0, 0]) / (2 * np.pi * f)
    of_floor = float(np.sqrt(np.sum(_per_band(per_velocity**2) * floor**2)))
    command = {"floor": of_floor, "noise": _noise_command(model, loop, nyquist)}
    phases = _phases(model, loop, scenario) if feeds_back(law) else {}
    return Budget(BANDS, floor, contributions, command, law.converter.voltage_limit, phases)


def floor_levels(scenario: Scenario) -> Array:
    """Third-octave velocity of the floor's heave (mean of the mounts) in `BANDS` [m/s]."""
    motion = scenario.motion()
    if motion.at_rest:
        centres = np.array([band.centre for band in BANDS])
        return np.asarray(np.sqrt(UNSTATED.spectrum(centres) * BAND_LOG_WIDTH * centres))
    time = np.arange(0.0, min(FLOOR_TIME, scenario.duration), 1.0 / FLOOR_RATE)
    heave = motion.sample(time).velocity[:, :, AXES.index("z")].mean(axis=1)
    # A rough level of a low band is worth more than none: most of the voltage goes there.
    return np.nan_to_num(band_rms(heave, FLOOR_RATE, BANDS, least_bins=1.0))


def _per_band(values: Array) -> Array:
    """Mean over the frequencies of each band."""
    return np.asarray(values.reshape(len(BANDS), PER_BAND).mean(axis=1))


def _densities(loop: Loop, f: Array) -> Array:
    """Noise density of each reading of the law, (f, reading)."""
    found = [loop.sensors.of(name) for name in loop.law.inputs]
    return np.array([np.zeros(f.size) if one is None else one.noise_density(f) for one in found]).T


def _turbulence(scenario: Scenario, floor: Array, sensitivity: ComplexArray) -> Array:
    """What varying flow gain leaves of a floor that the pistons follow: εσ √(1 + (2c/ω)²) of it, times sensitivity."""
    actuator, supply = scenario.plant.actuators[0], scenario.supply
    centres = np.array([band.centre for band in BANDS])
    stroke = float(np.sqrt(np.sum((floor / (2 * np.pi * centres)) ** 2)))
    pressure = actuator.membrane_stiffness * stroke / actuator.piston_area
    share = pressure / (2.0 * (supply.pressure - supply.tank_pressure))
    common = np.abs(sensitivity.mean(axis=2).sum(axis=1))  # sensitivity of heave
    creeping = np.hypot(1.0, 2.0 * Inverse.of(actuator).creep / (2 * np.pi * centres))
    return np.asarray(share * creeping * floor * np.sqrt(_per_band(common**2)))


def _noise_command(model: LinearModel, loop: Loop, nyquist: float) -> float:
    """RMS of the first valve's command by the instruments' noise, from 0.05 Hz to half the rate [V]."""
    f = np.geomspace(0.05, 0.99 * nyquist, 300)
    cut = opened(model, loop, f)
    closed = cut.sensitivity @ cut.law
    # The hold belongs to what acts on the machine; the command itself jumps from sample to sample without it.
    held = np.abs(np.sinc(0.5 * f / nyquist))
    noise = np.sum(np.abs(closed[:, 0]) ** 2 * _densities(loop, f) ** 2, axis=1)
    return float(np.sqrt(np.trapezoid(noise / held**2, f)))


def _phases(model: LinearModel, loop: Loop, scenario: Scenario) -> dict[str, float]:
    """Lags of heave's loop where it last crosses one [deg]."""
    f = np.geomspace(5.0, 400.0, 400)
    law, sensors = loop.law, loop.sensors
    heave = opened(model, loop, f).gain.sum(axis=2).mean(axis=1)
    above = np.flatnonzero((np.abs(heave[:-1]) >= 1.0) & (np.abs(heave[1:]) < 1.0))
    if not above.size:
        return {}
    at = float(f[above[0]])
    s = 2j * np.pi * at
    poles = valve_poles(scenario.plant.actuators[0])
    part = law.parts[0]
    foot = sensors.of("foot_velocity front-left z") if any(n.startswith("foot_velocity") for n in law.inputs) else None
    fast = instrument_poles(foot)[1]
    degrees = 360.0 * at
    plant = (model.response([at], ("foot_velocity front-left z",), model.commands)[0, 0]).sum() / s
    valve = float(np.degrees(np.angle(np.prod(poles) / np.prod(s - poles))))
    return {
        "crossing_hz": at,
        "phase_margin_deg": float(180.0 - abs(np.degrees(np.angle(heave[above[0]])))),
        "valve_deg": -valve,
        "delay_and_hold_deg": degrees * (part.latency + 0.5 * part.period),
        "instrument_deg": degrees * lag(fast),
        "oil_and_membrane_deg": float(-(np.degrees(np.angle(plant)) + 90.0) + valve),
    }
