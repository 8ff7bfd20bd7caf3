"""Names that a person uses: of a mode by what moves in it and where its energy is, of a state by what it belongs to."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.optimize import linear_sum_assignment

from ehamj.arrays import ComplexArray
from ehamj.linear.shapes import at_cg, kinetic_of
from ehamj.plant.axes import DOFS
from ehamj.plant.machine import Machine
from ehamj.plant.plant import Plant

SAME: Final = 1e-9
"""Share of the largest stroke in a pattern below which a mount has no part in it."""

MAINLY: Final = 0.9
"""Share of a pattern in the valves' motion from which they are named by it."""

PATTERNS: Final = {
    "heave": "in heave", "roll": "about x", "pitch": "about y", "surge": "along x", "sway": "along y", "yaw": "about z",
}  # fmt: skip
"""How valves, or plates, move together that drive a motion of the machine; in others they are ``in warp``."""

MOTIONS: Final = ("heave", "yaw", *(f"{what} about {axis}" for what in ("sway-rocking", "rocking") for axis in "xy"))
"""Names of the machine's own modes."""


def group_of(state: str) -> str:
    """What a state belongs to: motion, valve, pressure (of chambers and supply) or controller."""
    first = state.split(" ")[0]
    if first in ("displacement", "velocity"):
        return "motion"
    if first == "controller":
        return "controller"
    return "pressure" if "pressure" in first or first == "line_flow" else "valve"


def pattern_name(kind: str, motion: ComplexArray, plant: Plant) -> str:
    """What all valves or plates do together, (mount,): one alone, one of `PATTERNS`, or in warp; else no more."""
    size = float(np.sum(np.abs(motion) ** 2))
    if size == 0.0:
        return f"{kind}s"
    alone = np.abs(motion) ** 2 / size
    if alone.max() >= MAINLY:
        return f"{kind} {plant.mounts[int(np.argmax(alone))]}"
    basis = plant.central.pattern_basis
    signs = np.sign(np.where(np.abs(basis) > SAME * np.abs(basis).max(axis=0), basis, 0.0))
    shares = np.abs(signs.T @ motion) ** 2 / (np.sum(signs**2, axis=0) * size)
    best = int(np.argmax(shares))
    names = [PATTERNS.get(name, f"in {name}") for name in plant.central.patterns]
    return f"{kind}s {names[best]}" if shares[best] >= MAINLY else f"{kind}s"


def energy_shares(machine: Machine, shape: ComplexArray) -> dict[str, float]:
    """Share of the machine's kinetic energy per degree of freedom, translations at the centre of gravity."""
    energy = kinetic_of(machine, at_cg(machine, shape))
    return dict(zip(DOFS, (energy / energy.sum()).tolist(), strict=True))


def motion_name(machine: Machine, shape: ComplexArray) -> str:
    """Heave, yaw, sway-rocking about y, rocking about x, …: by where the kinetic energy is."""
    share = energy_shares(machine, shape)
    if share["z"] > 0.5:
        return "heave"
    if share["rz"] > 0.5:
        return "yaw"
    return _plane_name("y" if share["x"] + share["ry"] >= share["y"] + share["rx"] else "x", share)


def _plane_name(about: str, share: dict[str, float]) -> str:
    sway, turn = (share["x"], share["ry"]) if about == "y" else (share["y"], share["rx"])
    return f"{'sway-rocking' if sway > turn else 'rocking'} about {about}"


def named_together(machine: Machine, names: Sequence[str], shapes: Sequence[ComplexArray]) -> list[str]:
    """Names by frequency, those of the machine's own modes given together: one is heave, one yaw, where there are six.

    Names go by where the kinetic energy is, so that the sum of the shares is greatest. Of two alike the slower is the
    lower; of more, they are numbered by frequency.
    """
    found = list(names)
    moving = [k for k, name in enumerate(names) if name in MOTIONS]
    shares = [energy_shares(machine, shapes[k]) for k in moving]
    slots = (("z",), ("rz",), ("x", "ry"), ("x", "ry"), ("y", "rx"), ("y", "rx"))
    worth = np.array([[-sum(share[dof] for dof in slot) for slot in slots] for share in shares]).reshape(-1, len(slots))
    for row, slot in zip(*linear_sum_assignment(worth), strict=True):
        name = ("heave", "yaw")[slot] if slot < 2 else _plane_name("y" if slot < 4 else "x", shares[row])
        found[moving[row]] = name
    return [_distinct(found, k) for k in range(len(found))]


def _distinct(names: Sequence[str], k: int) -> str:
    alike = [j for j, name in enumerate(names) if name == names[k]]
    place = alike.index(k)
    if len(alike) == 1:
        return names[k]
    return f"{('lower', 'upper')[place]} {names[k]}" if len(alike) == 2 else f"{names[k]} {place + 1}"
