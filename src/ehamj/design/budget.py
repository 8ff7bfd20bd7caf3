"""What limits the isolation: contributions to the machine's motion per third-octave band, and which binds.

What law, delay and valve leave of the floor, what the machine does beyond its linear model and what forces on it do are
motions over time, which the closed loop makes of the scenario's own floor (`ehamj.design.prediction`); their levels are
taken as those of a run are. To them come, as powers, what each class of instruments adds by its noise and by rounding
its readings, and the commands' rounding, steps Δ being white noise of Δ²/12. The voltage is judged by the command's
RMS: a Gaussian command exceeds the limit a for the share erfc(a/(√2 σ)) of the time.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from scipy.special import erfc

from ehamj.arrays import Array
from ehamj.control import LinearController
from ehamj.control.channels import MountChannels
from ehamj.control.inverse import instrument_poles, lag, valve_poles
from ehamj.control.sensors import class_of
from ehamj.design.prediction import OUTPUTS, predicted
from ehamj.estimate.bands import Band
from ehamj.estimate.counted import settled
from ehamj.findings import finite
from ehamj.ground.broadband import BroadbandGround
from ehamj.ground.motion import Start
from ehamj.judge.attenuation import attenuation_of
from ehamj.judge.levels import BANDS, SLAB, ByBand, floor_as_whole, rms_in_bands
from ehamj.linear.loop import Loop, feeds_back, opened
from ehamj.linear.machine import LinearModel
from ehamj.scenario.model import Scenario

PER_BAND: Final = 6
"""Frequencies at which a band is looked at."""
UNSTATED: Final = BroadbandGround(kind="broadband", level="VC-C")
"""Floor that is taken where the scenario's rests."""
FLOOR_TIME: Final = 20.0
"""How long it moves [s]."""
FOLDED: Final = "motion faster than half the recording rate"
"""That rows show as if it were slow."""

Attenuations = Mapping[str, Mapping[str, ByBand]]
"""Of each machine by name as `Budget.attenuation`."""


@dataclass(frozen=True)
class Budget:
    """RMS velocities of floor and machine per third-octave band, (bands, `SLAB`) [m/s, rad/s], NaN where undecided.

    ``contributions`` are those of the machine by what causes them. ``command`` is the RMS by floor
    and by noise of the command of the valve that needs most [V], ``limit`` its range [V].
    """

    floor: Array
    moved: Array
    """The machine, all causes but the `noises` together."""
    contributions: Mapping[str, Array]
    noises: tuple[str, ...]
    """Contributions that are independent of the floor."""
    attenuation: Mapping[str, ByBand]
    """As the judge of a run takes it: of each of `SLAB`, band → dB, None where undecided."""
    command: Mapping[str, float]
    limit: float
    phases: Mapping[str, float]
    """Lags at the crossing of heave [deg], by cause, and the crossing [Hz]; empty without feedback."""
    notes: tuple[str, ...] = ()
    """What the prediction does not hold for, in words."""
    bands: tuple[Band, ...] = BANDS

    @property
    def total(self) -> Array:
        """All contributions together."""
        return with_noises(self.moved, [self.contributions[name] for name in self.noises])

    def binding(self, motion: str = "z") -> tuple[str | None, ...]:
        """The largest contribution to a motion in each band; None where it is undecided."""
        names, at = list(self.contributions), SLAB.index(motion)
        levels = np.array([self.contributions[name][:, at] for name in names])
        decided = self.attenuation[motion]
        return tuple(
            None if decided[band.name] is None else names[int(np.nanargmax(levels[:, k]))]
            for k, band in enumerate(self.bands)
        )

    @property
    def command_rms(self) -> float:
        """RMS of the command of the valve that needs most, by all causes [V]."""
        return float(np.sqrt(sum(part**2 for part in self.command.values())))

    @property
    def saturated(self) -> float:
        """Share of the time at which a Gaussian command of this RMS is beyond its range."""
        sigma = self.command_rms
        return float(erfc(self.limit / (np.sqrt(2.0) * sigma))) if sigma > 0 else 0.0

    def to_dict(self) -> dict[str, Any]:
        """As plain data, SI; null where undecided."""

        def per_band(values: Array) -> dict[str, dict[str, float | None]]:
            names = [band.name for band in self.bands]
            return {
                motion: dict(zip(names, map(finite, column), strict=True))
                for motion, column in zip(SLAB, values.T, strict=True)
            }

        return {
            "attenuation_db": {motion: dict(found) for motion, found in self.attenuation.items()},
            "floor": per_band(self.floor),
            "machine": per_band(self.total),
            "contributions": {cause: per_band(part) for cause, part in self.contributions.items()},
            "binding": {band.name: cause for band, cause in zip(self.bands, self.binding(), strict=True)},
            "command_rms_v": dict(self.command),
            "command_limit_v": self.limit,
            "saturated_share": self.saturated,
            "phase_at_crossing": dict(self.phases),
        }


def with_noises(moved: Array, noises: list[Array]) -> Array:
    """Levels of a motion to which independent ones are added."""
    return np.asarray(np.sqrt(moved**2 + sum(part**2 for part in noises)))


def budget(scenario: Scenario, model: LinearModel, law: LinearController) -> Budget:
    """The budget of a law on a scenario's machine and floor.

    Args:
        scenario: its floor moves each mount (VC-C, vertical, where it rests), its sensors make the noise.
        model: the linearised machine.
        law: digital controller.
    """
    loop = Loop.of(scenario, law)
    motion, duration, notes = scenario.motion(), scenario.duration, []
    if motion.at_rest:
        plant, duration = scenario.plant, max(scenario.duration, FLOOR_TIME)
        motion = UNSTATED.motion(Start(plant.mounts, np.array(plant.positions), duration, scenario.seed))
        notes.append("The scenario's floor rests: the prediction is for a floor that heaves as VC-C allows.")
    on = law.converter.switch_on + law.converter.fade
    if on > settled(duration):
        notes.append(
            f"The controller takes over at {on:g} s; the prediction is for a machine that it controls throughout."
        )
    known = tuple(b for b in BANDS if motion.usable_from <= b.edges[0] and b.edges[1] <= motion.usable_to)
    seen, rate = predicted(scenario, model, law, motion, duration), scenario.record_rate
    floor = floor_as_whole(seen.floor, scenario.plant)
    contributions = {name: _levels(part, rate, known) for name, part in seen.causes.items()}
    moved = _levels(np.asarray(sum(seen.causes.values())), rate, known)
    noises = _noises(model, loop, rate)
    command = seen.command[int(settled(duration) / duration * len(seen.command)) :]
    spread = command.var(axis=0)
    most = int(np.argmax(spread))
    levels = _levels(floor, rate, known)
    total = with_noises(moved, list(noises.values()))
    return Budget(
        floor=levels,
        moved=moved,
        contributions=contributions | noises,
        noises=tuple(noises),
        attenuation=attenuation_of(levels, total, _levels(seen.floor, rate, known), BANDS, scenario.plant),
        command={"floor": float(np.sqrt(spread[most])), "noise": _noise_command(model, loop, most)},
        limit=law.converter.voltage_limit,
        phases=_phases(model, loop, scenario) if feeds_back(law) else {},
        notes=tuple(notes),
    )


def _levels(motion: Array, rate: float, known: tuple[Band, ...]) -> Array:
    """Levels of a motion (rows, …) in all bands, NaN where undecided."""
    found = np.full((len(BANDS), *motion.shape[1:]), np.nan)
    found[[BANDS.index(band) for band in known]] = rms_in_bands(motion, rate, known)
    return found


def _noises(model: LinearModel, loop: Loop, rate: float) -> dict[str, Array]:
    """Levels of the machine's motion by instruments and converter, by cause, as rows at a ``rate`` [Hz] show them."""
    edges = np.array([band.edges for band in BANDS])
    f = np.concatenate([low * (high / low) ** ((np.arange(PER_BAND) + 0.5) / PER_BAND) for low, high in edges])
    widths = np.repeat((edges[:, 1] - edges[:, 0]) / PER_BAND, PER_BAND)[:, None]
    found = {
        name: np.asarray(np.sqrt((power * widths).reshape(len(BANDS), PER_BAND, -1).sum(axis=1)))
        for name, power in _noise_powers(model, loop, f).items()
    }
    # Rows that come too seldom show what is faster as if it were slow.
    nyquist = 0.5 / min(part.period for part in loop.law.parts)
    others = [abs(k * rate + sign * f) for k in range(1, int(nyquist / rate) + 2) for sign in (-1, 1)]
    folded = np.zeros((f.size, len(OUTPUTS)))
    for other in others:
        within = other < 0.99 * nyquist
        if within.any():
            folded[within] += sum(_noise_powers(model, loop, other[within]).values())
    if np.any(folded):
        found[FOLDED] = np.asarray(np.sqrt((folded * widths).reshape(len(BANDS), PER_BAND, -1).sum(axis=1)))
    return found


def _noise_powers(model: LinearModel, loop: Loop, f: Array) -> dict[str, Array]:
    """Power densities of `OUTPUTS` at frequencies (f,) [Hz] by instruments and converter, (f, output) by cause.

    What the linearisation of valves reads moves their gain alone, which is of second order and left out.
    """
    law, cut, found = loop.law, opened(model, loop, f), {}
    drive = model.response(f, OUTPUTS, model.commands) @ cut.sensitivity
    moved = np.abs(drive @ cut.law) ** 2  # per reading
    nyquist = 0.5 / min(part.period for part in law.parts)
    densities, classes = _densities(loop, f), [class_of(name.partition(" ")[0]) for name in law.inputs]
    for table in dict.fromkeys(classes):
        own = [k for k, one in enumerate(classes) if one == table]
        if np.any(densities[:, own]):
            found[f"noise of {table} sensors"] = np.einsum("fok,fk->fo", moved[:, :, own], densities[:, own] ** 2)
    steps = np.array([0.0 if (one := loop.sensors.of(name)) is None else one.resolution for name in law.inputs])
    if np.any(steps):
        found["rounding of readings"] = moved @ (steps**2 / 12.0 / nyquist)
    step = law.converter.resolution
    found["rounding of commands"] = np.sum(np.abs(drive) ** 2, axis=2) * step**2 / 12.0 / nyquist
    return found


def _densities(loop: Loop, f: Array) -> Array:
    """Noise density of each reading of the law, (f, reading)."""
    found = [loop.sensors.of(name) for name in loop.law.inputs]
    return np.array([np.zeros(f.size) if one is None else one.noise_density(f) for one in found]).reshape(-1, f.size).T


def _noise_command(model: LinearModel, loop: Loop, valve: int) -> float:
    """RMS of one valve's command by the instruments' noise, from 0.05 Hz to half the rate [V]."""
    nyquist = 0.5 / min(part.period for part in loop.law.parts)
    f = np.geomspace(0.05, 0.99 * nyquist, 300)
    cut = opened(model, loop, f)
    closed = cut.sensitivity @ cut.law
    # The hold belongs to what acts on the machine; the command itself jumps from sample to sample without it.
    held = np.abs(np.sinc(0.5 * f / nyquist))
    noise = np.sum(np.abs(closed[:, valve]) ** 2 * _densities(loop, f) ** 2, axis=1)
    return float(np.sqrt(np.trapezoid(noise / held**2, f)))


def _phases(model: LinearModel, loop: Loop, scenario: Scenario) -> dict[str, float]:
    """Lags of heave's loop where it last crosses one [deg]."""
    f = np.geomspace(5.0, 400.0, 400)
    law, sensors = loop.law, loop.sensors
    layout, at_mounts = model.plant.obeying.central, MountChannels.of(model.plant)
    if "heave" not in layout.motions:
        return {}
    column, own = layout.motions.index("heave"), np.flatnonzero(model.plant.layout.active)
    fit, spread = layout.fit[column], layout.spread[:, column]
    heave = fit @ opened(model, loop, f).gain[:, own[:, None], own] @ spread
    above = np.flatnonzero((np.abs(heave[:-1]) >= 1.0) & (np.abs(heave[1:]) < 1.0))
    if not above.size:
        return {}
    at = float(f[above[0]])
    s = 2j * np.pi * at
    poles = valve_poles(scenario.plant.obeying.actuators[0])
    part = law.parts[0]
    foot = sensors.of(at_mounts.feet[0]) if any(n.startswith("foot_velocity") for n in law.inputs) else None
    fast = instrument_poles(foot)[1]
    degrees = 360.0 * at
    plant = fit @ model.response([at], at_mounts.feet, [model.commands[k] for k in own])[0] @ spread / s
    valve = float(np.degrees(np.angle(np.prod(poles) / np.prod(s - poles))))
    return {
        "crossing_hz": at,
        "phase_margin_deg": float(180.0 - abs(np.degrees(np.angle(heave[above[0]])))),
        "valve_deg": -valve,
        "delay_and_hold_deg": degrees * (part.latency + 0.5 * part.period),
        "instrument_deg": degrees * lag(fast),
        "oil_and_membrane_deg": float(-(np.degrees(np.angle(plant)) + 90.0) + valve),
    }
