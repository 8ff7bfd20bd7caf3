"""One machine drawn, simulated on the multibody engine, logged with noise and bits, and identified."""

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

import ehamj
from draws.bound import bound
from draws.machines import BOUNDS, ISOLATOR, NOMINAL, OPTIONS, drawn
from ehamj.errors import InputError, SimulationFailed
from ehamj.plant.mounts import MOUNTS
from ehamj.rig.excitation import leak_down, valve_test
from ehamj.rig.logger import HEADROOM, Tap, logged
from ehamj.run.many import observe_many
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario


@dataclass(frozen=True)
class Kind:
    """What is drawn and looked for."""

    about: str
    keys: tuple[str, ...]
    options: bool = False
    """Whether valves may have options."""
    leak: bool = True
    """Whether it is measured how the oil leaks out, which alone tells K_C's split and air."""


KINDS: Final = {
    "values": Kind("all values of the machine and its isolators", tuple(NOMINAL)),
    "options": Kind(
        "values of the isolators, and which options their valves have",
        tuple(key for key in NOMINAL if key.startswith("actuators.")),
        True,
    ),
    "few": Kind("three values, in seconds", (f"{ISOLATOR}.flow_gain", "machine.mass", "machine.cg.0"), leak=False),
}
NOISE: Final = 0.01
"""RMS of the noise of a channel over its own RMS."""
BITS: Final = 16
RATE: Final = 2000.0
"""Of the logger [Hz]."""
STEP: Final = 1.25e-5
"""With which the machine is simulated: a hysteresis turns within a step, so that errors fall as its square [s]."""
SHAKER: Final = ((0.6, 0.4, 1.2), (1.0, 0.6, 0.5))
"""Place and direction of a force that moves the machine in all directions."""
ASIDE: Final = 2e-5
"""Stroke that its sensors show at none [m]."""
TANK: Final = {"supply.tank_pressure": 1e5}
"""Pressures are absolute: a tank has that of the air [Pa]."""
PRESSURES: Final = {f"chamber_pressure {mount} {k}": f"P{n}{k}" for n, mount in enumerate(MOUNTS) for k in (1, 2)}
MOTIONS: Final = {
    **{f"foot_acceleration {mount} z": f"A{n}z" for n, mount in enumerate(MOUNTS)},
    "foot_acceleration front-left x": "A0x",
    "foot_acceleration front-left y": "A0y",
    "foot_acceleration rear-right y": "A3y",
    **{f"stroke {mount}": f"S{n}" for n, mount in enumerate(MOUNTS)},
}
UNITS: Final = {"P": "bar", "A": "m/s^2", "S": "um"}
VALVES, LEAK = "valves", "leak-down"
LASTS, LEAKS, BEGIN = 0.5, 0.25, 0.02
"""Duration of the valve test, of the leak-down, and when the supply is lost in it [s]."""
VOLTS: Final = 0.6
"""RMS of each command."""


def believed(table: dict[str, Any] | None = None) -> Scenario:
    """The machine as everybody believes it to be, or with what ``table`` says."""
    plain = parse_scenario({"points": {}})
    scenario: Scenario = plain.varied({**TANK, **(table or {})})
    return scenario


def trial(kind: str, seed: int, number: int, folder: Path, settings: dict[str, Any] | None = None) -> dict[str, Any]:
    """What came of one machine, as plain data.

    Args:
        kind: of `KINDS`.
        seed: of all machines.
        number: of this one.
        folder: for the files of its tests, which is there.
        settings: of the identification, beside the usual ones.
    """
    began = time.process_time()
    machine = drawn(seed, number, KINDS[kind].keys, KINDS[kind].options)
    runs = measured(believed(machine.table), folder, (seed, number), KINDS[kind].leak)
    found = ehamj.identify({**file_of(kind, folder), **(settings or {})})
    own: dict[str, Any] = {"kind": kind, "seed": seed, "number": number, "notes": list(found.notes)}
    own["seconds"] = time.process_time() - began
    own["true"] = {key: machine.values[key] for key in KINDS[kind].keys}
    own["found"] = {key: [one.value, one.deviation, one.status] for key, one in found.values.items()}
    own["steps"], own["converged"] = found.told["steps"], found.told["converged"]
    if KINDS[kind].options:
        own["options"], own["justified"] = machine.options, list(found.choice.justified)
        own["words"] = [one.words for one in found.choice.verdicts.values()]
    else:
        own["bound"] = bound(runs, KINDS[kind].keys, {VALVES: [*PRESSURES, *MOTIONS], LEAK: [*PRESSURES]}, noise_of)
    return own


def tried(kind: str, seed: int, number: int) -> dict[str, Any]:
    """A trial; of one that is refused, why."""
    try:
        with tempfile.TemporaryDirectory(prefix="draws-") as folder:
            return trial(kind, seed, number, Path(folder))
    except (InputError, SimulationFailed) as error:
        return {"kind": kind, "seed": seed, "number": number, "failed": str(error)}


def measured(machine: Scenario, folder: Path, seed: tuple[int, int], leak: bool = True) -> dict[str, Scenario]:
    """Measure a machine on its rig, a file for each test; gives what was simulated."""
    played = folder / "played.csv"
    valves = valve_test(machine, played, rate=RATE, duration=LASTS, volts=VOLTS, shaker=SHAKER, seed=seed[1])
    runs = {VALVES: valves}
    if leak:
        runs[LEAK] = leak_down(machine, begin=BEGIN, duration=LEAKS, rate=RATE)
    given = [Tap(channel=f"valve_command {mount}", name=f"U{n}", bits=None) for n, mount in enumerate(MOUNTS)]
    given.append(Tap(channel="force 0", name="F", bits=None))
    fine = [run.model_copy(update={"timestep": STEP}) for run in runs.values()]
    seen = {VALVES: [*given, *taps(PRESSURES | MOTIONS)], LEAK: taps(PRESSURES)}
    for name, run in zip(runs, observe_many(fine, lambda run: run), strict=True):
        logged(run, seen[name], seed=seed[0] + 1000 * seed[1]).save(folder / f"{name}.csv")
    return runs


def noise_of(channel: str, samples: np.ndarray) -> float:
    """RMS of what the logger adds to a channel: noise, and the steps of its converter."""
    largest = float(np.abs(samples + channel.startswith("stroke") * ASIDE).max())
    return float(np.hypot(NOISE * samples.std(), HEADROOM * largest / 2.0 ** (BITS - 1) / np.sqrt(12.0)))


def taps(channels: dict[str, str]) -> list[Tap]:
    """Columns of a logger, all of one quality; where a stroke counts from, its sensor does not know."""
    return [
        Tap(channel=own, name=name, unit=UNITS[name[0]], noise=NOISE, bits=BITS, offset=name.startswith("S") * ASIDE)
        for own, name in channels.items()
    ]


def file_of(kind: str, folder: Path) -> dict[str, Any]:
    """What is asked, of files that `measured` wrote."""
    believed({}).save(folder / "believed.toml")
    given: dict[str, Any] = {f"U{n}": {"channel": f"valve_command {mount}"} for n, mount in enumerate(MOUNTS)}
    given["F"] = {"force": {"point": list(SHAKER[0]), "direction": list(SHAKER[1])}}
    pressures = {name: {"channel": channel} for channel, name in PRESSURES.items()}
    motions = {
        name: {"channel": channel, **({"offset": "free"} if name.startswith("S") else {})}
        for channel, name in MOTIONS.items()
    }
    usual: dict[str, Any] = {"kind": "record", "settle": 0.0, "rate": RATE}
    lost = {"fault": [{"kind": "supply-lost", "time": BEGIN}]}
    tests = [
        {**usual, "name": VALVES, "file": str(folder / f"{VALVES}.csv"), "measurement": given | pressures | motions},
        {**usual, "name": LEAK, "file": str(folder / f"{LEAK}.csv"), "measurement": pressures, "set": lost},
    ]
    if not KINDS[kind].leak:
        del tests[1]
    parameters = {key: {"bounds": BOUNDS[key]} if key in BOUNDS else {} for key in KINDS[kind].keys}
    asked: dict[str, Any] = {"choice": {"options": list(OPTIONS)}} if KINDS[kind].options else {}
    file = {"title": kind, "scenario": str(folder / "believed.toml"), "parameters": parameters, "test": tests}
    return {**file, "fit": {"starts": 1}, **asked}
