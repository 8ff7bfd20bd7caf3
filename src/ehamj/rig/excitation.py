"""Tests of a machine on its rig, as scenarios: valves and a shaker driven with multisines, blows of a hammer, oil that
leaks out.

What tells which parameter: valve tests the valve, its flow gain, the oil's stiffness, K_C and the membranes; a shaker
or a hammer off the centre of gravity the masses that valves do not reach (yaw); and only a leak-down the share of K_C
over the edges, since it empties both chambers alike, which no spool does, and the air, since it ends at a low pressure.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.result import written_whole
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.settings import Vector3

TRIES: Final = 64
"""Draws of random phases, of which that of the lowest peak is taken."""
FADE: Final = 0.05
"""Time over which signals begin and end [s]."""


@dataclass(frozen=True)
class Shaker:
    """A force on the machine that a signal drives."""

    point: str | Vector3
    """A name in [points], ``cg``, or a place from the mount plane's centre [m]."""
    direction: Vector3
    samples: Array
    """[N], (n,)"""


def multisine(
    rate: float, duration: float, band: tuple[float, float], rms: float, seed: Sequence[int], lines: int = 60
) -> Array:
    """A sum of ``lines`` sines of one amplitude and random phases that fades in and out, of low peak, (n,).

    Args:
        rate: of its samples [Hz].
        duration: [s]; lines are multiples of its inverse.
        band: from the first to the last line [Hz], evenly in logarithm.
        rms: before it is faded, in the signal's unit.
        seed: of the phases.
        lines: at most; where the band has not as many, all of it.

    Raises:
        InputError: if the band has no line, or reaches beyond a third of the rate.
    """
    first, last = band
    if not 0.0 < first < last <= rate / 3.0:
        raise InputError(f"band = [{first:g}, {last:g}] Hz: must rise, to rate/3 = {rate / 3.0:g} Hz at most")
    numbers = np.unique(np.round(np.geomspace(first, last, lines) * duration))
    numbers = numbers[(numbers >= 1.0) & (numbers <= last * duration)].astype(int)
    size = round(rate * duration)
    spectra = np.zeros((TRIES, size // 2 + 1), complex)
    phases = np.random.default_rng(list(seed)).uniform(0.0, 2.0 * np.pi, (TRIES, numbers.size))
    spectra[:, numbers] = np.exp(1j * phases)
    drawn = np.fft.irfft(spectra, size, axis=1)
    best = drawn[np.argmin(np.abs(drawn).max(axis=1))]
    time = np.arange(size) / rate
    window = np.clip(np.minimum(time, time[-1] - time) / min(FADE, 0.25 * duration), 0.0, 1.0)
    return np.asarray(rms / np.std(best) * best * (3.0 - 2.0 * window) * window**2)


def driven(
    machine: Scenario, path: str | Path, rate: float, commands: Mapping[str, Array], shakers: Sequence[Shaker] = ()
) -> Scenario:
    """A machine whose valves and shakers play a file, which is written.

    Args:
        machine: whose control and forces are replaced.
        path: of the CSV file, to be made.
        rate: of its samples [Hz].
        commands: by mount [V], (n,).
        shakers: forces.

    Raises:
        InputError: if signals differ in length, or there are none.
        OSError: if the file cannot be written.
    """
    columns = {f"U {mount} [V]": samples for mount, samples in commands.items()}
    columns |= {f"F {number} [N]": shaker.samples for number, shaker in enumerate(shakers)}
    lengths = {samples.size for samples in columns.values()}
    if len(lengths) != 1:
        raise InputError(f"signals are of {sorted(lengths)} samples; there must be some, all of one length")
    (size,) = lengths
    path = Path(path)
    with written_whole(path) as unfinished:
        rows = np.column_stack([np.arange(size) / rate, *columns.values()])
        np.savetxt(unfinished, rows, "%.12g", ",", header=",".join(["time [s]", *columns]), comments="")
    name = str(path.absolute())
    signals = [{"kind": "recorded", "file": name, "component": f"U {mount}", "mounts": [mount]} for mount in commands]
    forces = [
        {"kind": "recorded", "file": name, "component": f"F {k}", "point": shaker.point, "direction": shaker.direction}
        for k, shaker in enumerate(shakers)
    ]
    control: dict[str, Any] = {"kind": "open-loop", "signals": signals} if signals else {"kind": "passive"}
    return changed(machine, {"control": control, "force": forces, "duration": (size - 1) / rate, "compare": ()})


def valve_test(
    machine: Scenario, path: str | Path, *, rate: float = 2000.0, duration: float = 1.0,
    band: tuple[float, float] = (2.0, 300.0), volts: float = 0.6, shaker: tuple[str | Vector3, Vector3] | None = None,
    newtons: float = 1000.0, seed: int = 0,
) -> Scenario:  # fmt: skip
    """All valves driven at once, each with a multisine of its own, and a shaker beside them where one is told.

    Args:
        machine: see `driven`.
        path: likewise.
        rate: of samples of the file, and rows of the run [Hz].
        duration: [s]
        band: of the multisines [Hz].
        volts: RMS of each command.
        shaker: point and direction of its force.
        newtons: RMS of that.
        seed: of the phases.

    Raises:
        InputError: as `multisine`, and if no mount obeys.
        OSError: if the file cannot be written.
    """
    mounts = machine.plant.obeying.mounts
    if not mounts:
        raise InputError("no mount obeys commands: there is no valve to test")

    def signal(rms: float, number: int) -> Array:
        return multisine(rate, duration, band, rms, (seed, number))

    commands = {mount: signal(volts, number) for number, mount in enumerate(mounts)}
    shakers = [] if shaker is None else [Shaker(*shaker, signal(newtons, len(mounts)))]
    return changed(driven(machine, path, rate, commands, shakers), {"record_rate": rate})


def hammer_test(
    machine: Scenario, point: str | Vector3, direction: Vector3, *, peak: float = 5000.0, pulse_time: float = 2e-3,
    blows: int = 1, interval: float = 1.0, rate: float = 4000.0,
) -> Scenario:  # fmt: skip
    """Blows on a point of the machine, its valves held.

    Args:
        machine: whose control and forces are replaced.
        point: a name in [points], ``cg``, or a place from the mount plane's centre [m].
        direction: of the force, any length.
        peak: [N]
        pulse_time: of a blow [s]; it excites up to 1.5 over it [Hz].
        blows: how many.
        interval: from one to the next [s].
        rate: rows of the run [Hz].
    """
    blow = {"kind": "hammer", "point": point, "direction": direction, "peak": peak, "pulse_time": pulse_time}
    blow |= {"begin": 0.02, "blows": blows, "interval": interval}
    duration = math.ceil(rate * blows * interval) / rate
    control = {"kind": "passive"}
    return changed(
        machine, {"control": control, "force": [blow], "duration": duration, "record_rate": rate, "compare": ()}
    )


def leak_down(machine: Scenario, *, begin: float = 0.02, duration: float = 0.4, rate: float = 2000.0) -> Scenario:
    """The supply is lost, and both chambers of each isolator empty through the valve's edges, its spool held.

    Args:
        machine: whose control, forces and faults are replaced.
        begin: time of the loss [s].
        duration: [s]
        rate: rows of the run [Hz].
    """
    lost = {"kind": "supply-lost", "time": begin}
    bare: dict[str, Any] = {"control": {"kind": "passive"}, "force": (), "compare": ()}
    return changed(machine, {**bare, "fault": [lost], "duration": duration, "record_rate": rate})
