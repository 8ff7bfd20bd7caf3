"""The rig of the identification that ships, which made its records: the truth about it is here and nowhere else.

``PYTHONPATH=src python tests/oracles/valve_sweep.py`` writes the records anew.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ehamj.arrays import Array
from ehamj.plant.mounts import MOUNTS
from ehamj.rig.logger import Logged, Tap, logged
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario_files import shipped_identifications

FILE = shipped_identifications()["valve-sweep"]
TRUE = {
    "actuators.isolator.flow_gain": 2.3e-6,
    "actuators.isolator.bulk_modulus": 1.15e9,
    "actuators.isolator.membrane_stiffness": 5.6e8,
    "machine.mass": 4650.0,
    "machine.inertia.0": 2450.0,
    "machine.inertia.1": 3300.0,
}
"""What the rig is, by the keys that the file asks for; the moment about the vertical axis no valve tells."""
SENSOR = 1.08
"""Gain of the stroke sensor at the front left."""
RATE = 1000.0
"""Of the logger [Hz]."""
LINES = (4.0, 7.0, 11.0, 17.0, 26.0, 40.0, 61.0, 92.0)
"""Frequencies of the first valve [Hz]; the others have theirs between."""
RECORDS = {"sweep": (1.5, 1), "again": (0.8, 2)}
"""Duration [s] and seed of each record."""


def named(mount: str) -> str:
    """FL for front-left."""
    return "".join(word[0].upper() for word in mount.split("-"))


def commands(duration: float, seed: int) -> Array:
    """What the generator puts out, in its steps, times first (n, 5) [s, V]."""
    random, time = np.random.default_rng(seed), np.arange(round(duration * RATE) + 1) / RATE
    ramp, step = np.minimum(1.0, time / 0.1), 10.0 / 2**15
    phases = random.uniform(0.0, 2.0 * np.pi, (len(MOUNTS), len(LINES)))
    sines = [
        sum(0.5 * np.sin(2.0 * np.pi * (line + 0.5 * k) * time + phase) for line, phase in zip(LINES, own, strict=True))
        for k, own in enumerate(phases)
    ]
    return np.column_stack([time, *(step * np.round(ramp * one / step) for one in sines)])


def record(name: str) -> Logged:
    """What the logger wrote: commands as put out, strokes and pressures with 1 % of noise, 16 bit."""
    duration, seed = RECORDS[name]
    with TemporaryDirectory() as folder:
        file = Path(folder) / "commands.csv"
        heads = ",".join(["time [s]", *(f"U {named(mount)} [V]" for mount in MOUNTS)])
        np.savetxt(file, commands(duration, seed), fmt="%.7g", delimiter=",", header=heads, comments="")
        signals = [
            {"kind": "recorded", "file": str(file), "component": f"U {named(mount)}", "mounts": [mount]}
            for mount in MOUNTS
        ]
        isolator = {key.rpartition(".")[2]: value for key, value in TRUE.items() if key.startswith("actuators")}
        inertia = [TRUE["machine.inertia.0"], TRUE["machine.inertia.1"], 4000.0]
        table = {
            "engine": "small-motion", "compare": [], "duration": duration, "record_rate": RATE,
            "actuators": {"isolator": isolator}, "machine": {"mass": TRUE["machine.mass"], "inertia": inertia},
            "control": {"kind": "open-loop", "signals": signals},
        }  # fmt: skip
        run = simulate(parse_scenario(table))
    taps = [Tap(channel=f"valve_command {mount}", name=f"U {named(mount)}", full_scale=10.0) for mount in MOUNTS]
    taps += [
        Tap(
            channel=f"stroke {mount}", name=f"S {named(mount)}", unit="mm", noise=0.01,
            gain=SENSOR if mount == "front-left" else 1.0,
        )
        for mount in MOUNTS
    ]  # fmt: skip
    taps += [
        Tap(channel=f"chamber_pressure {mount} 1", name=f"P {named(mount)}", unit="bar", noise=0.01)
        for mount in (MOUNTS[0], MOUNTS[3])
    ]
    return logged(run, taps, seed=seed)


def written(log: Logged) -> str:
    """The record as a table of text, in six digits."""
    heads = ",".join(["time [s]", *(f"{name} [{unit}]" for name, unit in zip(log.names, log.units, strict=True))])
    rows = np.column_stack([log.time, log.samples])
    return "\n".join([heads, *(",".join(f"{value:.6g}" for value in row) for row in rows), ""])


if __name__ == "__main__":
    for one in RECORDS:
        FILE.with_name(f"valve-sweep-{one}.csv").write_text(written(record(one)), encoding="utf-8")
