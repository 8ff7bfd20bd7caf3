"""Modes identified from simulated measurements, as on a rig, beside the computed ones.

The nonlinear machine is excited with its valves held; what its feet do is identified without any model
(`ehamj.estimate.identification`), and a name goes to each mode found by its likeness to a computed one. Settings that a
test engineer takes from a first look (band, resolution, decay time) come from the computed modes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

import numpy as np

from ehamj.arrays import ComplexArray
from ehamj.errors import InputError, did_you_mean
from ehamj.estimate.identification import Stable, agreed
from ehamj.linear.eigen import mac
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import Mode, modes
from ehamj.linear.pairing import likely_pairs, likeness
from ehamj.linear.shapes import weights
from ehamj.linear.unstable import unstable_pole
from ehamj.mujoco.model import reduced
from ehamj.plant.axes import DOFS
from ehamj.plant.levers import lever
from ehamj.plant.machine import Machine
from ehamj.rig.feet import responses
from ehamj.rig.plan import Plan
from ehamj.rig.ringdown import ring_down
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario

Kind = Literal["ring-down", "random", "sweep", "hammer"]
KINDS: Final[tuple[Kind, ...]] = get_args(Kind)

NEAR: Final = 0.1
"""Relative distance in frequency at which a computed mode becomes unlikely to be the one that was found."""


@dataclass(frozen=True)
class Identified:
    """A mode found in signals.

    ``frequency`` is |λ|/2π [Hz], ``shape`` that of the mount plane's centre (6,) [m, rad], its largest part one.
    Spreads are standard deviations over model orders and records. ``computed`` is the mode that it is most like,
    ``likeness`` the MAC of both shapes; None: there is none.
    """

    name: str
    frequency: float
    damping_ratio: float
    shape: ComplexArray
    frequency_spread: float
    damping_spread: float
    computed: Mode | None
    likeness: float

    def to_dict(self) -> dict[str, Any]:
        """As plain data, the computed values beside it."""
        return {
            "name": self.name,
            "frequency_hz": self.frequency,
            "frequency_spread_hz": self.frequency_spread,
            "damping_ratio": self.damping_ratio,
            "damping_ratio_spread": self.damping_spread,
            "shape": {dof: [part.real, part.imag] for dof, part in zip(DOFS, self.shape.tolist(), strict=True)},
            "mac": self.likeness,
            "computed_frequency_hz": self.computed and self.computed.frequency,
            "computed_damping_ratio": self.computed and self.computed.damping_ratio,
        }


@dataclass(frozen=True)
class ModalTest:
    """What a test found, by frequency, how it was done, and the names of computed modes that it missed."""

    kind: Kind
    modes: tuple[Identified, ...]
    missed: tuple[str, ...]
    words: str

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        found = [mode.to_dict() for mode in self.modes]
        return {"kind": self.kind, "method": self.words, "modes": found, "missed": list(self.missed)}


def kind_of(name: str) -> Kind:
    """The kind of measurement of this name.

    Raises:
        InputError: if there is none.
    """
    for kind in KINDS:
        if kind == name:
            return kind
    raise InputError(f"measured = {name!r}: {did_you_mean(name, KINDS)}must be one of {', '.join(KINDS)}")


def check_test(kind: str, noise: float) -> None:
    """Raise InputError where there is no such kind of measurement, or no such noise."""
    kind_of(kind)
    if not 0.0 <= noise < 1.0:
        raise InputError(f"noise = {noise:g}: must be from 0 up to 1, as a share of the signal")


def modal_test(scenario: Scenario, kind: Kind, noise: float = 0.0, realisations: int | None = None) -> ModalTest:
    """Identify the machine's modes from a simulated measurement, valves held.

    Args:
        scenario: the machine; its ground, control and forces are replaced.
        kind: ``ring-down``: a jolt of the floor in all directions, then free decay. ``random``: periodic noise of the
            floor (a multisine of random phases), ``sweep``: an exponential sweep of the floor, one degree of freedom
            after the other; the feet's motion over the floor's is fitted. ``hammer``: blows on an upper corner of the
            machine in x, y and z, one after the other; the feet's velocity over the force is fitted.
        noise: RMS of white noise on every measured channel, over that channel's own RMS [-].
        realisations: records, which differ in noise and random phases; without, 3 where there is noise, else 1.

    Raises:
        InputError: if an argument is impossible, the machine is unstable, or its modes lie too far apart for one
            measurement.
    """
    check_test(kind, noise)
    if realisations is None:
        realisations = 3 if noise > 0.0 else 1
    if realisations < 1:
        raise InputError(f"realisations = {realisations}: must be at least 1")
    still = _still(scenario)
    model = linear_model(still.plant)
    if pole := unstable_pole(model):
        raise InputError(f"the machine is unstable with its valves held, {pole}: no test")
    computed = tuple(mode for mode in modes(model) if mode.machine_moves)
    if not computed:
        raise InputError("the machine has no oscillation: there is nothing to identify")
    plan = Plan.of(computed)
    if kind == "ring-down":
        fits, words = ring_down(still, plan, realisations, noise)
    else:
        fits, words = responses(still, kind, plan, realisations, noise)
    found = agreed(fits)
    named, missed = _named(still.machine, found, computed)
    return ModalTest(kind, named, missed, words)


def _still(scenario: Scenario) -> Scenario:
    """The machine alone, with its plates tied where their feet are rigid: the same equations."""
    bare = {"control": {"kind": "passive"}, "ground": {"kind": "rest"}, "compare": (), "force": (), "fault": ()}
    standing = tuple(slide.standing for slide in scenario.slide)
    return changed(scenario, bare | {"slide": standing, "plates": reduced(scenario.plant).plates})


def _named(
    machine: Machine, found: Sequence[Stable], computed: Sequence[Mode]
) -> tuple[tuple[Identified, ...], tuple[str, ...]]:
    """Each mode found under the name of the computed one that it is most like in shape and frequency."""
    shapes = np.array([mode.shape for mode in found]).T.reshape(len(DOFS), len(found))
    expected = np.array([mode.shape for mode in computed]).T
    to_cg = np.vstack([lever(machine.cg), np.eye(len(DOFS))[3:]])
    alike = mac(to_cg @ shapes, to_cg @ expected, weights(machine))
    hertz = np.array([abs(mode.pole) for mode in found]) / (2 * np.pi)
    pairs = likely_pairs(likeness(alike, hertz, np.array([mode.frequency for mode in computed]), NEAR))
    named = []
    for k, mode in enumerate(found):
        partner = computed[pairs[k]] if k in pairs else None
        shape = mode.shape / mode.shape[np.argmax(np.abs(mode.shape))]
        size = abs(mode.pole)
        named.append(
            Identified(
                partner.name if partner else f"unknown at {size / (2 * np.pi):.0f} Hz",
                size / (2 * np.pi),
                -mode.pole.real / size,
                shape,
                mode.frequency_spread,
                mode.damping_spread,
                partner,
                float(alike[k, pairs[k]]) if partner else 0.0,
            )
        )
    return tuple(named), tuple(mode.name for k, mode in enumerate(computed) if k not in pairs.values())
