"""What isolators in any direction can do together: motions that they drive, and forces that move nothing."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array
from ehamj.plant.axes import DOFS
from ehamj.plant.levers import lever

MOTION_NAMES: Final = {"x": "surge", "y": "sway", "z": "heave", "rx": "roll", "ry": "pitch", "rz": "yaw"}
"""Names of the machine's six rigid motions, by degree of freedom."""

SINGULAR: Final = 1e-9
"""Singular values below this share of the largest count as zero; positions are known to 1e-12 of the machine."""


@dataclass(frozen=True)
class Layout:
    """Isolators at ``positions`` [m] (mount, 3) that act along the unit vectors ``directions`` (mount, 3).

    ``active`` says which of them obey commands; the others stand beside. Of everything that has one entry per mount
    those of passive mounts are zero.
    """

    positions: Array
    directions: Array
    active: tuple[bool, ...]

    @cached_property
    def rows(self) -> Array:
        """J: stroke of each mount [m] per motion of the mount plane's centre, x, y, z [m], rx, ry, rz [rad],
        (mount, 6): d·(u + θ × r)."""
        return np.array([d @ lever(r) for r, d in zip(self.positions, self.directions, strict=True)]).reshape(-1, 6)

    @cached_property
    def driven(self) -> Array:
        """`rows` of the active mounts, zero for the others."""
        return np.where(np.array(self.active)[:, None], self.rows, 0.0)

    def raised(self, height: float) -> "Layout":
        """The same mounts as seen from a point so far above the origin [m]."""
        return Layout(self.positions.reshape(-1, 3) - [0.0, 0.0, height], self.directions, self.active)

    @cached_property
    def span(self) -> float:
        """Root mean square of the active feet's distances from the origin (of all, where none is active) [m], which
        makes angles lengths; 1 where all stand in it."""
        feet = self.positions[list(self.active)] if any(self.active) else self.positions
        return float(np.sqrt((feet**2).sum(axis=1).mean())) or 1.0

    @cached_property
    def _reached(self) -> Array:
        """Projector on the motions that active mounts drive, in x, y, z and rotations times `span`, (6, 6)."""
        scaled = self.driven / [1.0, 1.0, 1.0, self.span, self.span, self.span]
        _, sizes, right = np.linalg.svd(scaled)
        rank = int((sizes > SINGULAR * max(sizes[0], SINGULAR)).sum())
        return np.asarray(right[:rank].T @ right[:rank])

    @property
    def rank(self) -> int:
        """How many of the machine's six motions are actuated: the rank of J of the active mounts."""
        return round(float(np.trace(self._reached)))

    def share(self, dof: str) -> float:
        """How much of a motion along one of the six degrees of freedom active mounts drive: 1 all, 0 nothing of it."""
        k = DOFS.index(dof)
        return float(self._reached[k, k])

    @cached_property
    def _named(self) -> dict[str, Array]:
        """A motion of the machine (6,) for each that is actuated, in the order heave, roll, pitch, surge, sway, yaw.

        Where isolators are skew the motions that they drive are none of the six alone: then each is named for what it
        mostly is.
        """
        reached, scale = self._reached, np.array([1.0, 1.0, 1.0, self.span, self.span, self.span])
        order = [DOFS.index(dof) for dof in ("z", "rx", "ry", "x", "y", "rz")]
        found: dict[str, Array] = {}
        left = reached.copy()
        for sure in (True, False):
            while len(found) < self.rank:
                shares = np.diag(left)[order]
                best = next((k for k, share in zip(order, shares, strict=True) if share > 1.0 - 1e-9), None)
                if best is None:
                    if sure:
                        break
                    best = order[int(np.argmax(shares.round(9)))]
                motion = left[:, best] / left[best, best]
                if sure:
                    motion = np.eye(6)[best]
                left = left - np.outer(left[:, best], left[best]) / left[best, best]
                found[MOTION_NAMES[DOFS[best]]] = motion * scale[best] / scale
        return {MOTION_NAMES[DOFS[k]]: found[MOTION_NAMES[DOFS[k]]] for k in order if MOTION_NAMES[DOFS[k]] in found}

    @property
    def motions(self) -> tuple[str, ...]:
        """Names of the motions that are actuated: heave, roll, pitch of upright isolators."""
        return tuple(self._named)

    @cached_property
    def basis(self) -> Array:
        """Motion of the mount plane's centre [m, rad] per each of `motions`, (6, motion)."""
        return np.column_stack(list(self._named.values())) if self._named else np.zeros((6, 0))

    @cached_property
    def spread(self) -> Array:
        """Stroke of each mount per motion, (mount, motion): 1, y, −x of upright ones."""
        return self.driven @ self.basis

    @cached_property
    def fit(self) -> Array:
        """Motions that fit the strokes best, (motion, mount): the pseudo-inverse of `spread`."""
        return np.asarray(np.linalg.pinv(self.spread))

    @cached_property
    def stresses(self) -> Array:
        """Forces of the active mounts that move nothing, (mount, pattern): null space of Jᵀ, each of length √n.

        Parallel mounts first balance among themselves (+ − − + of four upright ones on a rectangle), then groups
        against each other.
        """
        active, patterns = np.flatnonzero(self.active), np.zeros((len(self.active), 0))
        for members in (*self._parallel, active):
            null = _null_space(self.rows[members].T)
            padded = np.zeros((len(self.active), null.shape[1]))
            padded[members] = null
            known, _ = np.linalg.qr(patterns)
            fresh = padded - known @ (known.T @ padded)
            kept, sizes, _ = np.linalg.svd(fresh, full_matrices=False)
            patterns = np.column_stack([patterns, kept[:, sizes > 1e-6]])
        patterns[~np.array(self.active)] = 0.0  # to the last bit
        signs = [np.sign(column[np.argmax(np.abs(column) > 1e-9)]) for column in patterns.T]
        return patterns * np.array(signs) * np.sqrt(active.size)

    @property
    def _parallel(self) -> list[Array]:
        """Active mounts that act along the same line, by groups of two and more."""
        groups: list[list[int]] = []
        for k in np.flatnonzero(self.active):
            for group in groups:
                if abs(self.directions[group[0]] @ self.directions[k]) > 1.0 - 1e-9:
                    group.append(int(k))
                    break
            else:
                groups.append([int(k)])
        return [np.array(group) for group in groups if len(group) > 1]

    @property
    def stress_names(self) -> tuple[str, ...]:
        """Names of `stresses`: warp, where there is one; else numbered."""
        n = self.stresses.shape[1]
        return ("warp",) if n == 1 else tuple(f"warp {k + 1}" for k in range(n))

    @property
    def patterns(self) -> tuple[str, ...]:
        """Everything that the active mounts can do together: `motions`, then `stress_names`."""
        return (*self.motions, *self.stress_names)

    @cached_property
    def pattern_basis(self) -> Array:
        """Strokes or forces of the mounts per each of `patterns`, (mount, pattern)."""
        return np.column_stack([self.spread, self.stresses])


def _null_space(matrix: ArrayLike) -> Array:
    """Orthonormal columns x of matrix·x = 0."""
    matrix = np.asarray(matrix, float)
    _, sizes, right = np.linalg.svd(matrix)
    rank = int((sizes > SINGULAR * max(sizes.max(initial=0.0), SINGULAR)).sum())
    return np.asarray(right[rank:].T)
