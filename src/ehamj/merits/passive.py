"""Merits of the passive machine, its valves held: modes, what it stands on, how much of a floor it lets through."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.designs.many import RIGID_MODES, RigidModes, modes_in, rigid_modes, tipping_margin
from ehamj.designs.responses import passive_answers
from ehamj.designs.stack import Stack
from ehamj.judge.levels import BANDS
from ehamj.linear.elements import coordinates
from ehamj.linear.machine import linear_model
from ehamj.linear.names import group_of
from ehamj.linear.response import machine_channels, rigid_floor
from ehamj.linear.values import Values
from ehamj.merits.merit import SOURCES, Failed, Machine, Merit
from ehamj.merits.stacked import LinearSource, Row, Stacked, attenuations, hertz_of
from ehamj.plant.axes import AXES
from ehamj.scenario.model import Scenario

NO_REST: Final = "no rest in its cylinders: a chamber would have no room left, or nothing carries the machine"

MODES: Final = {name.replace(" ", "-"): number for number, name in enumerate(RIGID_MODES)}
"""Names of modes in merits, and their numbers."""


class PassiveSource(LinearSource):
    """Merits of the machine with its valves held.

    In closed form (`ehamj.designs.many`), modes by eigenvalues, the transmissibility at `PER_BAND` frequencies in each
    third-octave band from 1 to 315 Hz, and at the modes too for its peak, which so holds to 0.1 dB. Machines that have
    none (valves that are not linear about their centre, a dynamic supply) are differentiated one at a time
    (`ehamj.linear.machine`), with the same merits: modes are named by the same rule, and the rest and static stiffness
    are those of the springs.
    """

    def merits(self, machine: Machine) -> Mapping[str, Merit]:
        return _merits()

    def together(self, stacked: Stacked, names: Sequence[str]) -> list[Row]:
        stack = Stack.of(stacked.designs.values)
        modes = rigid_modes(stack.elements, stack.rest, stack.empty) if _asked(names, *_OF_MODES) else None
        hertz = _frequencies(len(stack.mass), modes)
        answers = passive_answers(stack, hertz[: stacked.count]) if _asked(names, "attenuation", "peak") else None
        return _rows(stack, modes, answers, names, stacked.count)

    def alone(self, machine: Machine, scenario: Scenario, names: Sequence[str]) -> Row:
        plant, model = scenario.plant, linear_model(scenario.plant)
        stack = Stack.of(Values.of(plant))
        # Held spools are moved by nothing else: the rest by itself has all other poles.
        held = [k for k, name in enumerate(model.states) if group_of(name) != "valve"]
        moving = [f"{what} {name}" for what in ("displacement", "velocity") for name in coordinates(plant)]
        states = [[model.states[k] for k in held].index(name) for name in moving]
        poles, vectors = np.linalg.eig(model.A[np.ix_(held, held)])
        modes = modes_in(stack.elements, stack.rest, poles[None], vectors[None, states], stack.empty)
        answers = None
        if _asked(names, "attenuation", "peak"):
            hertz = _frequencies(1, modes)[0]
            outputs = machine_channels()[: len(AXES)]
            answers = np.einsum("faa->fa", rigid_floor(model, hertz, None, outputs, AXES).response)[None]
        return _rows(stack, modes, answers, names, 1)[0]


_OF_MODES: Final = ("frequency", "damping_ratio", "growth_rate", "peak")


def _asked(names: Sequence[str], *kinds: str) -> bool:
    return any(name.split(".")[1] in kinds for name in names)


def _frequencies(designs: int, modes: RigidModes | None) -> Array:
    """Frequencies of the bands, and those of each design's modes, (design, f) [Hz]."""
    bands = np.broadcast_to(hertz_of(BANDS), (designs, len(hertz_of(BANDS))))
    if modes is None:
        return np.array(bands)
    return np.concatenate([bands, np.nan_to_num(np.abs(modes.picked) / (2 * np.pi), nan=1.0)], axis=1)


def _rows(
    stack: Stack, modes: RigidModes | None, answers: ComplexArray | None, names: Sequence[str], count: int
) -> list[Row]:
    """Merits by name of the first designs of a stack."""
    found: dict[str, Array] = {"tipping_margin": np.broadcast_to(tipping_margin(stack.elements), len(stack.mass))}
    found["rest_stroke"] = np.broadcast_to(np.abs(stack.elements.stroke).max(axis=-1), len(stack.mass))
    found |= {f"static_stiffness.{axis}": 1.0 / one for axis, one in zip(AXES, stack.compliance.T, strict=True)}
    if modes is not None:
        size = np.abs(modes.picked)
        found["growth_rate"] = modes.poles.real.max(axis=-1)
        for name, number in MODES.items():
            found[f"frequency.{name}"] = size[:, number] / (2 * np.pi)
            found[f"damping_ratio.{name}"] = -modes.picked[:, number].real / size[:, number]
    if answers is not None:
        squares = np.abs(answers) ** 2
        levels = attenuations(squares[:, : len(hertz_of(BANDS))])
        for k, axis in enumerate(AXES):
            found[f"peak.{axis}"] = 10.0 * np.log10(squares[..., k].max(axis=1))
            found |= {f"attenuation.{axis}.{band.name}": levels[:, b, k] for b, band in enumerate(BANDS)}
    columns = {name: found[name.partition(".")[2]] for name in names}
    return [
        Failed(NO_REST) if stack.empty[k] else {name: float(column[k]) for name, column in columns.items()}
        for k in range(count)
    ]


@cache
def _merits() -> Mapping[str, Merit]:
    found = [
        *(
            Merit(f"passive.frequency.{mode}", "Hz", f"natural frequency of {RIGID_MODES[k]}")
            for mode, k in MODES.items()
        ),
        *(
            Merit(f"passive.damping_ratio.{mode}", "1", f"damping ratio of {RIGID_MODES[k]}")
            for mode, k in MODES.items()
        ),
        Merit("passive.growth_rate", "1/s", "largest real part of a pole; positive: it tips over"),
        Merit("passive.tipping_margin", "1", "stiffness left by gravity, smallest share; 0 or less: it tips over"),
        Merit("passive.rest_stroke", "m", "largest stroke under gravity"),
    ]
    for axis in AXES:
        text = f"stiffness against a constant force along {axis} at the centre of gravity"
        found.append(Merit(f"passive.static_stiffness.{axis}", "N/m", text))
        text = f"largest motion along {axis} of the centre of gravity over that of the floor, as one slab"
        found.append(Merit(f"passive.peak.{axis}", "dB", text))
        for band in BANDS:
            text = f"floor over centre of gravity along {axis} in the third-octave band at {band.name} Hz, as one slab"
            found.append(Merit(f"passive.attenuation.{axis}.{band.name}", "dB", text))
    return {one.name: one for one in found}


SOURCES.add("passive", PassiveSource())
