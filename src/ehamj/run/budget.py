"""What a run would need, before it begins: memory, disk, steps and time; what cannot be had is refused by its keys."""

import math
import tempfile
from pathlib import Path
from typing import Final

import numpy as np
import psutil

from ehamj import columns, growing
from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator, hydraulic_stiffness
from ehamj.plain.needs import gib
from ehamj.plant.plant import Plant
from ehamj.scenario.model import Scenario

CHANNELS: Final = (160, 45)
"""Numbers of a row, about: whatever the machine has with a law of a hundred states, and more per mount."""
PLACES: Final = (9, 6)
"""Numbers of a row per point and per relative motion."""
BLOCKS: Final = 4
"""Blocks of rows that a run holds whose rows go to a file: what was stepped, its channels and what they are made of."""
JUDGED: Final = 200
"""What judging such a run holds per row [byte]: one channel, its spectra in three orders of differences, what is behind
a filter, and the times. Measured on ten million rows: 170."""
STEP_SECONDS: Final = {"mujoco": 6e-6, "small-motion": 1e-6}
"""Time that a step takes, about, by engine [s]."""
LONGEST: Final = 30 * 86_400.0
"""Beyond which a run was hardly meant [s]."""
FLOOR: Final = 2e-8
"""Step below which whatever asks for it was hardly meant [s]."""


def row_bytes(scenario: Scenario) -> int:
    """Size of a row of a result, about."""
    places = PLACES[0] * len(scenario.points) + PLACES[1] * len(scenario.relative)
    return 8 * (CHANNELS[0] + CHANNELS[1] * len(scenario.plant.mounts) + places)


def size_of(scenario: Scenario) -> float:
    """Of all rows of a run [byte], about."""
    return scenario.duration * scenario.record_rate * row_bytes(scenario)


def streams(*together: Scenario) -> bool:
    """Whether rows of runs that step together are too many for memory, and go to a file of each."""
    return sum(map(size_of, together)) > growing.IN_MEMORY


def check_rows(scenario: Scenario, together: int = 1, folder: Path | None = None, shown: bool = False) -> None:
    """Refuse a run whose rows do not fit.

    Args:
        scenario: that is to run.
        together: how many such runs are held at once.
        folder: where they are to be written, if they are; those that are too many for memory are anyway.
        shown: whether a page or a recording is made of them, which takes all in memory.

    Raises:
        InputError: which names what they need, what is free, and the keys.
    """
    rows = scenario.duration * scenario.record_rate * together
    in_file = streams(scenario)
    memory = together * size_of(scenario) * growing.COPIES
    if in_file and not shown:
        memory = together * BLOCKS * columns.ROWS * row_bytes(scenario) + rows * JUDGED
    free = psutil.virtual_memory().available
    if memory > free:
        beside = ", or leave out what shows all of it (--no-report --no-replay)" if in_file and shown else ""
        raise InputError(
            f"{_asked(scenario, together)}: {rows:.3g} rows need about {gib(memory)} of memory and {gib(free)} are "
            f"free; lower record_rate or duration{beside}"
        )
    if folder is not None or in_file:
        check_disk(scenario, together, folder)


def check_disk(scenario: Scenario, together: int = 1, folder: Path | None = None) -> None:
    """Refuse runs whose rows do not fit on disk; arguments as of `check_rows`, by default what is temporary.

    Raises:
        InputError: which names what they need, what is free, and the keys.
    """
    rows, size = scenario.duration * scenario.record_rate * together, together * size_of(scenario)
    other = "let TMPDIR name a folder with more room" if folder is None else "name another --out"
    folder = folder or Path(tempfile.gettempdir())
    above = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    if size > (free := psutil.disk_usage(str(above)).free):
        raise InputError(
            f"{_asked(scenario, together)}: {rows:.3g} rows need about {gib(size)} on disk and {gib(free)} are free "
            f"in {str(above)!r}; lower record_rate or duration, or {other}"
        )


def _asked(scenario: Scenario, together: int) -> str:
    """What asks for so many rows."""
    what = f"duration = {scenario.duration:g} s at record_rate = {scenario.record_rate:g} Hz"
    return what + (f", {together} runs together" if together > 1 else "")


def check_steps(scenario: Scenario, timestep: float) -> None:
    """Refuse a run of more steps than anybody waits for.

    Raises:
        InputError: which names the step, how many there are, and what asks for them.
    """
    steps = scenario.duration / timestep
    seconds = steps * STEP_SECONDS[scenario.engine]
    if seconds <= LONGEST and timestep >= FLOOR:
        return
    if scenario.timestep != "auto":
        why = f"timestep = {timestep:g} s"
    elif (longest := scenario.load().longest_step) < 1.01 * timestep:
        number, force = min(enumerate(scenario.force), key=lambda one: one[1].longest_step)
        why = f"force.{number} ({force.kind}), which is so short or fast, asks for steps of {longest:.3g} s"
    else:
        why = fastest_part(scenario.plant)
    allowed = [f"the step must be at least {FLOOR:g} s"] if timestep < FLOOR else []
    allowed += [f"the run must take at most {LONGEST / 3600.0:g} h"] if seconds > LONGEST else []
    raise InputError(
        f"{why}: a step of {timestep:.3g} s is {steps:.3g} steps in duration = {scenario.duration:g} s, about "
        f"{seconds / 3600.0:.3g} h; {' and '.join(allowed)}"
    )


def fastest_part(plant: Plant) -> str:
    """What of a machine's isolators is fastest, by the keys that make it so, and how fast."""
    found = [one for actuator in plant.actuators for one in _rates(actuator)]
    stiff = sum(_stiffness(actuator) for actuator in plant.actuators)
    damped = sum(actuator.membrane_damping for actuator in plant.actuators)
    arm = max(float(np.square(place).sum()) for place in plant.positions)
    moved = min(plant.machine.mass, float(np.linalg.eigvalsh(plant.machine.tensor).min()) / arm)
    found.append((math.sqrt(stiff / moved), "machine.mass, machine.inertia and the isolators' stiffness"))
    found.append((damped / moved, "machine.mass, machine.inertia and membrane_damping"))
    rate, keys = max(found)
    return f"the fastest part, from {keys}, has {rate:.3g} rad/s"


def _rates(own: Actuator) -> list[tuple[float, str]]:
    """Rates of an isolator's parts by themselves [rad/s], and the keys that they come from."""
    mass = own.plate_mass or math.inf  # a tied plate is part of the machine
    foot = 0.0 if math.isinf(own.foot_stiffness) else own.foot_stiffness
    leak = 4.0 * own.bulk_modulus / own.chamber_volume
    return [
        (own.valve_frequency, "valve_frequency"),
        (math.sqrt((_stiffness(own) + foot) / mass), "bulk_modulus, membrane_stiffness, foot_stiffness"),
        (math.sqrt(own.lateral_stiffness / mass), "lateral_stiffness"),
        (own.membrane_damping / mass, "membrane_damping"),
        (own.lateral_damping / mass, "lateral_damping"),
        (leak * own.flow_pressure, "flow_pressure and bulk_modulus"),
    ]


def _stiffness(own: Actuator) -> float:
    """Of oil and membrane together [N/m]."""
    oil: float = hydraulic_stiffness(own.bulk_modulus, own.piston_area, own.chamber_volume)
    return oil + own.membrane_stiffness
