"""Whether a machine stands on its mounts: the stiffness of its six rigid motions, gravity's share of it, and shims."""

from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.layout import SINGULAR
from ehamj.plant.levers import lever
from ehamj.plant.plant import Plant

UNHELD: Final = 1e-12
"""Share of the best-held motion, all springs alike and rotations as lengths, up to which nothing holds one: rounding of
feet in one line is its square."""

PURE: Final = 1e-6
"""Share of a motion beside one of the six that is left out of its name."""


def elastic_stiffness(plant: Plant) -> Array:
    """Stiffness (6, 6) of the membranes against motions x, y, z [m], rx, ry, rz [rad] of the mount plane's centre.

    Each mount adds K_L along its direction (a stiffness that a load which stays meets: `Actuator.static_stiffness`) and
    k_h across it, at its foot: docs/physics.md, statics.
    """
    return assembled(plant, [(a.static_stiffness, a.lateral_stiffness) for a in plant.actuators])


def assembled(plant: Plant, springs: Iterable[tuple[float, float]]) -> Array:
    """Σ Lᵀ (k_along ddᵀ + k_across (1 − ddᵀ)) L over the mounts (6, 6), of springs or dampers along and across each
    [N/m or N s/m], against motions x, y, z [m], rx, ry, rz [rad] of the mount plane's centre."""
    total = np.zeros((6, 6))
    for position, direction, (along, across) in zip(plant.positions, plant.directions, springs, strict=True):
        line, foot = np.outer(direction, direction), lever(position)
        total += foot.T @ (along * line + across * (np.eye(3) - line)) @ foot
    return total


def _plates(plant: Plant) -> Array:
    """What each plate weighs along its mount [N], towards the machine positive; the rest its guide carries."""
    return np.array(
        [-plant.gravity * a.plate_mass * d[2] for a, d in zip(plant.actuators, plant.directions, strict=True)]
    )


def weight(plant: Plant) -> Array:
    """Force [N] and moment [N m] of gravity about the mount plane's centre (6,): the machine, plates along mounts."""
    machine = lever(plant.machine.cg).T @ np.array([0.0, 0.0, -plant.machine.mass * plant.gravity])
    return np.asarray(machine + plant.layout.rows.T @ _plates(plant))


def rest(plant: Plant) -> Array:
    """Motion of the mount plane's centre (6,) [m, rad] from unloaded membranes to rest, to first order.

    Oil is taken to carry nothing; shims lift. Where nothing holds a motion there is none of it.
    """
    springs = np.array([actuator.static_stiffness for actuator in plant.actuators])
    lifted = plant.layout.rows.T @ (springs * np.array(plant.heights))
    return np.asarray(np.linalg.lstsq(elastic_stiffness(plant), weight(plant) + lifted)[0])


def gravity_stiffness(plant: Plant) -> Array:
    """What gravity adds to `elastic_stiffness` (6, 6): of each force F at r, F·r 1 − (F rᵀ + r Fᵀ)/2 on rotations.

    That is −m g h on rocking for the weight, and what the mounts carry counts where their feet are off the mount plane.
    """
    moved = rest(plant)
    forces = [plant.machine.mass * np.array([0.0, 0.0, -plant.gravity])]
    mounts = zip(plant.positions, plant.directions, plant.heights, plant.actuators, strict=True)
    for position, direction, height, actuator in mounts:
        along, foot = np.array(direction), lever(position) @ moved
        stroke = along @ foot
        push = -actuator.static_stiffness * (stroke - height) - actuator.plate_mass * plant.gravity * along[2]
        forces.append(push * along - actuator.lateral_stiffness * (foot - stroke * along))
    total = np.zeros((6, 6))
    for force, place in zip(forces, [plant.machine.cg, *plant.positions], strict=True):
        both = np.outer(force, place)
        total[3:, 3:] += np.eye(3) * np.trace(both) - 0.5 * (both + both.T)
    return total


def _loose(plant: Plant, matrix: Array, stiffness: Array, least: float) -> tuple[str, ...]:
    """Motions of which a symmetric matrix (6, 6) has no more than this share of its largest eigenvalue, in words.

    Rotations count as lengths at `Layout.span`; ``stiffness`` gives the value that is told.
    """
    scale = np.array([1.0, 1.0, 1.0, *[1.0 / plant.layout.span] * 3])
    values, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    space = vectors[:, values <= least * np.abs(values).max()]
    found = []
    for k in range(len(DOFS)):  # what is one of the six alone, first
        if space.size and float(space[k] @ space[k]) > 1.0 - PURE:
            alone = np.eye(6)[k]
            found.append(alone)
            space = np.linalg.svd(space - np.outer(alone, space[k]), full_matrices=False)[0][:, : space.shape[1] - 1]
    return tuple(_said(motion * scale, stiffness) for motion in (*found, *space.T))


def check_standing(plant: Plant, gravity: bool) -> None:
    """Refuse a machine that its mounts cannot hold: with ``gravity`` its weight counts too.

    What the layout leaves free is told from soft springs by springs that are all alike.

    Raises:
        ValueError: names the motions that nothing holds, and what would.
    """
    stiffness = elastic_stiffness(plant)
    alike = [(float(a.static_stiffness > 0.0), float(a.lateral_stiffness > 0.0)) for a in plant.actuators]
    loose = _loose(plant, assembled(plant, alike), stiffness, UNHELD)
    if loose:
        raise ValueError(
            f"mount: the machine cannot stand, since nothing holds {_listed(loose)}: it needs feet that do not lie in "
            "one line, and a membrane_stiffness along or a lateral_stiffness across the mounts that meets this motion"
        )
    if not gravity:
        return
    stiffness = stiffness + gravity_stiffness(plant)
    loose = _loose(plant, stiffness, stiffness, 0.0)
    if loose:
        raise ValueError(
            f"mount: the machine cannot stand, since gravity is stronger than what holds {_listed(loose)}: a lower "
            "machine.cg, mounts further apart or higher up, or stiffer membranes would hold it; may_fall = true "
            "simulates how it falls"
        )


def level_shims(plant: Plant, oil: ArrayLike, equal: bool) -> Array:
    """Shims (mount,) [m] in place of the plant's own that make the machine stand without tilt.

    Args:
        plant: the machine; its heights do not count.
        oil: force of the oil along each mount [N].
        equal: it then also stands where it was built, at unloaded membranes' height, and its mounts carry loads as
            equal as may be: the pseudo-inverse of Jᵀ, which is what equal membranes give. Without, the shims are as
            thin as may be, and it may stand lower.
    """
    rows, plates, oil = plant.layout.rows, _plates(plant), np.asarray(oil, float)
    membranes = np.array([actuator.membrane_stiffness for actuator in plant.actuators])
    if membranes.min() == 0.0:
        at = plant.mounts[int(np.argmin(membranes))]
        raise ValueError(f"at {at} membrane_stiffness = 0: a shim lifts nothing there")
    if equal:
        load = -weight(plant)
        carried, *_ = np.linalg.lstsq(rows.T, load, rcond=SINGULAR)
        if np.abs(rows.T @ carried - load).max() > 1e-6 * np.abs(load).max():
            raise ValueError("the mounts cannot carry the weight along their directions alone; level shims may do")
        feet = np.array([actuator.foot_stiffness for actuator in plant.actuators])
        return np.asarray((carried - oil) / membranes + (carried + plates) / feet)
    # Of what pushes a plate, K h + oil + its weight, a share goes through a foot that gives way; the machine answers
    # with C Jᵀ share (K h + …) + C w, of which rx and ry are to vanish. The others move as they like.
    share = np.array([actuator.foot_share for actuator in plant.actuators])
    tilts = np.linalg.inv(elastic_stiffness(plant) + gravity_stiffness(plant))[[DOFS.index("rx"), DOFS.index("ry")]]
    lifts, machine = tilts @ rows.T * share, weight(plant) - rows.T @ plates
    return np.asarray(-np.linalg.pinv(lifts * membranes) @ (lifts @ (oil + plates) + tilts @ machine))


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]


def _said(motion: Array, stiffness: Array) -> str:
    """A motion (6,) [m, rad] of the mount plane's centre in words, with its stiffness."""
    slide, turn = motion[:3], motion[3:]
    size = float(np.linalg.norm(turn))
    if size <= PURE * np.linalg.norm(slide):
        unit = slide / np.linalg.norm(slide)
        motion, words, of = motion / np.linalg.norm(slide), f"sliding along {_axis(unit)}", "N/m"
    else:
        unit, through = turn / size, np.cross(turn, slide) / size**2
        pitch = float(unit @ slide) / size
        motion, words, of = motion / size, f"turning about {_axis(unit)}", "N m/rad"
        if np.abs(through).max() > 1e-6:
            words += " through " + _triple(through) + " m"
        if abs(pitch) > 1e-6:
            words += f" and sliding {pitch:.3g} m along it per rad"
    value = float(motion @ stiffness @ motion)
    negligible = abs(value) <= UNHELD * np.abs(stiffness).max()
    return f"{words} ({0.0 if negligible else value:.3g} {of})"


def _axis(unit: Array) -> str:
    k = int(np.argmax(np.abs(unit)))
    return AXES[k] if abs(unit[k]) > 1.0 - PURE else _triple(unit * np.sign(unit[k]))


def _triple(values: Array) -> str:
    return "(" + ", ".join(f"{value + 0.0:.3g}" for value in np.where(np.abs(values) < 1e-9, 0.0, values)) + ")"
