"""The modes of a machine as an animated recording: its variants beside each other."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ehamj.errors import InputError
from ehamj.linear.modes import Mode
from ehamj.linear.shapes import in_phase
from ehamj.plant.machine import Machine
from ehamj.replay.modes import Swing, write_mode_replay
from ehamj.scenario.model import Scenario


def swing(machine: Machine, mode: Mode) -> Swing:
    """A mode as it is drawn: turned in phase so that most of it is largest at once, at the beginning."""
    part, _ = in_phase(machine, mode.shape)
    phase = np.vdot(mode.shape, part.astype(complex))
    axis = None if mode.centre is None else (mode.centre.point, mode.centre.direction)
    return Swing(mode.name, mode.frequency, mode.damping_ratio, mode.shape * phase / abs(phase), axis)


def _swings(machine: Machine, modes: Sequence[Mode]) -> list[Swing]:
    """Those modes in which the machine moves; where two have one name, the later ones are numbered."""
    found: list[Swing] = []
    for mode in modes:
        if mode.machine_moves:
            one = swing(machine, mode)
            same = sum(other.name.split(" (")[0] == one.name for other in found)
            found.append(replace(one, name=f"{one.name} ({same + 1})") if same else one)
    return found


def replay_modes(path: Path, scenario: Scenario, variants: Mapping[str, Sequence[Mode]]) -> None:
    """Write the recording of those modes in which the machine itself moves.

    Args:
        path: file to write, ``*.rrd``.
        scenario: the machine.
        variants: its modes by variant, such as ``valves held``; variants without a swinging machine are left out.

    Raises:
        InputError: if the machine swings in none of them, or the file cannot be written.
    """
    found = {label: _swings(scenario.machine, modes) for label, modes in variants.items()}
    shown = {label: swings for label, swings in found.items() if swings}
    if not shown:
        raise InputError("modes: the machine does not swing (all its motions are overdamped, or it tips over)")
    try:
        write_mode_replay(path, scenario.name, scenario.plant, shown)
    except OSError as error:
        raise InputError(f"--replay {str(path)!r}: cannot be written ({error.strerror or error})") from error
