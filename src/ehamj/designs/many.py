"""What many designs do: linear models and modes of the passive machine as stacks of arrays.

    many = Designs.of(scenario, {"machine.cg.2": heights, "footprint.x": spans, "footprint.y": spans})
    table = modes_of(many)  # an xarray.Dataset over (height, span, mode)
    table.frequency.sel(mode="lower about y"), table.tipping_margin

Everything is in closed form about the static equilibrium under gravity (`ehamj.linear.elements`), so that 2,500
designs take a second. `ehamj.linear.machine.linear_model` differentiates the simulated model itself and gives the
same.
"""

from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from ehamj.arrays import Array, ComplexArray
from ehamj.designs.designs import Designs
from ehamj.labels import labelled
from ehamj.linear.elements import Elements, solve
from ehamj.linear.oil import Oil
from ehamj.linear.values import body_of
from ehamj.plant.axes import DOF_OF_JOINT, DOFS, JOINTS

RIGID_MODES: Final = ("lower about x", "lower about y", "yaw", "heave", "upper about x", "upper about y")
"""Modes of the machine on its mounts as maps label them: two pairs of sway and rocking, yaw and heave."""

_GROUPS: Final = (("y", "rx"), ("x", "ry"), ("rz",), ("z",), ("y", "rx"), ("x", "ry"))
"""Degrees of freedom that each of them moves in."""

OSCILLATES: Final = 1e-6
"""Im λ over |λ|, or 1/s, above which a pole is an oscillation: one at zero comes out as a pair of 1e-14/s."""


def modes_of(designs: Designs, hydraulics: bool = True) -> xr.Dataset:
    """Poles and modes of every design with its valves held, over the dimensions of the designs.

    Args:
        designs: what is computed.
        hydraulics: with the oil; without, the chambers are bypassed and only membranes carry the machine.

    Returns:
        ``frequency`` [Hz], ``damping_ratio`` and ``shape`` (joint dimensions ``mode``, ``dof``; the mount plane's
        centre, largest part one) of `RIGID_MODES`: of the pair in a plane the slower is ``lower``; NaN where a mode
        does not oscillate (overdamped, or tipping over). ``pole`` (…, ``pole_number``) [1/s]: all eigenvalues of
        motion and oil by magnitude; those of the valves, −ζω_v ± jω_v√(1 − ζ²), stand apart. ``growth_rate`` [1/s]:
        the largest real part; 0 within rounding where the mean pressures are neutral (no leakage over edges).
        ``tipping_margin`` [-]: 1 where nothing topples, 0 at the boundary: 1 minus the largest share of the membranes'
        stiffness that gravity takes. ``rest_stroke`` (…, ``mount``) [m]: stroke under gravity. NaN in ``frequency`` and
        ``pole`` also where a design has no rest inside its cylinders (``stands`` false).
    """
    elements, oil, strokes = assembled(designs)
    bad = without_rest(designs, oil) if hydraulics else np.zeros(designs.shape, bool)
    n = elements.mass.shape[-1]
    poles, vectors, chosen, picked = rigid_modes(elements, oil if hydraulics else None, bad)
    shape = np.take_along_axis(vectors[..., list(DOF_OF_JOINT), :], np.maximum(chosen, 0)[..., None, :], axis=-1)
    largest = np.take_along_axis(shape, np.argmax(np.abs(shape), axis=-2)[..., None, :], axis=-2)
    shape = np.where((chosen >= 0)[..., None, :], shape / largest, np.nan)
    size, margin = np.abs(picked), tipping_margin(elements)
    columns: dict[str, tuple[tuple[str, ...], Any, str, str]] = {
        "frequency": (("mode",), size / (2 * np.pi), "Hz", "natural frequency |λ|/2π"),
        "damping_ratio": (("mode",), -picked.real / size, "1", "damping ratio −Re λ/|λ|"),
        "shape": (
            ("mode", "dof"), np.moveaxis(shape, -1, -2), "1",
            "motion of the mount plane's centre (m, rad), largest part one",
        ),
        "pole": (("pole_number",), poles, "1/s", "eigenvalue λ"),
        "growth_rate": ((), poles.real.max(axis=-1), "1/s", "largest real part of a pole"),
        "tipping_margin": ((), margin, "1", "stiffness left by gravity, smallest share"),
        "rest_stroke": (("mount",), strokes, "m", "stroke at rest"),
        "stands": ((), (margin > 0.0) & ~bad, "1", "stands: no tipping, rest in its cylinders"),
    }  # fmt: skip
    variables = {
        name: labelled((*designs.dims, *own), values, units, text)
        for name, (own, values, units, text) in columns.items()
    }
    coords = designs.coords | {"mode": list(RIGID_MODES), "dof": list(DOFS), "mount": list(designs.mounts)}
    return xr.Dataset(variables, coords, {"hydraulics": int(hydraulics), "states": poles.shape[-1], "coordinates": n})


# --- assembly -----------------------------------------------------------------------------------------------------


def assembled(designs: Designs) -> tuple[Elements, Oil, Array]:
    """What the designs are made of, their oil, and their strokes at rest, (…, mount) [m]."""
    elements = Elements.at_rest(designs.values)
    return elements, Oil.of(designs.values, elements.stroke), elements.stroke


def without_rest(designs: Designs, oil: Oil) -> NDArray[np.bool_]:
    """Which designs have no rest inside their cylinders, (…)."""
    return np.broadcast_to(oil.empty, designs.shape)


def _motion(elements: Elements) -> Array:
    """State matrix (…, 2n, 2n) of the machine on membranes alone."""
    n = elements.mass.shape[-1]
    both = solve(elements.mass, np.concatenate([elements.stiffness, elements.damping], axis=-1))
    identity = np.broadcast_to(np.concatenate([np.zeros((n, n)), np.eye(n)], axis=-1), (*both.shape[:-2], n, 2 * n))
    return np.concatenate([identity, -both], axis=-2)


def _oil_motion(elements: Elements, oil: Oil) -> tuple[Array, Array]:
    """Rows of motion and of pressures over (motion, P1 of all mounts, P2 of all mounts)."""
    n, count = elements.mass.shape[-1], elements.plate.shape[-2]
    shape = elements.mass.shape[:-2]
    up = np.swapaxes(elements.plate, -1, -2)
    push = solve(elements.mass, np.concatenate([up * oil.areas[0][..., None, :], -up * oil.areas[1][..., None, :]], -1))
    motion = np.concatenate([_motion(elements), np.concatenate([np.zeros((*shape, n, 2 * count)), push], -2)], -1)
    pressures = np.zeros((*shape, 2 * count, 2 * n + 2 * count))
    mounts = np.arange(count)
    for chamber, sign in enumerate((1.0, -1.0)):
        rows, compliance = chamber * count + mounts, oil.compliances[chamber]
        swept = sign * oil.stretch * oil.areas[chamber] / compliance
        pressures[..., rows, n : 2 * n] = -swept[..., None] * elements.plate
        pressures[..., rows, 2 * n + rows] = -(2.0 * oil.edge + oil.cross) / compliance
        pressures[..., rows, 2 * n + (1 - chamber) * count + mounts] = oil.cross / compliance
    return motion, pressures


# --- modes --------------------------------------------------------------------------------------------------------


class RigidModes(NamedTuple):
    """Eigenvalues (…, pole) [1/s] by magnitude and their vectors (…, state, pole), of motion before pressures; which of
    them is which of `RIGID_MODES`, −1 none, and the eigenvalue of each of these, NaN of none, (…, 6)."""

    poles: ComplexArray
    vectors: ComplexArray
    chosen: NDArray[np.int64]
    picked: ComplexArray


def rigid_modes(elements: Elements, oil: Oil | None, bad: NDArray[np.bool_]) -> RigidModes:
    """Modes of machines with their valves held.

    Args:
        elements: what they are made of.
        oil: their oil; None where chambers are bypassed.
        bad: those (…,) that have no rest, of which everything is NaN.
    """
    matrix = _motion(elements) if oil is None else np.concatenate(_oil_motion(elements, oil), axis=-2)
    poles, vectors = np.linalg.eig(np.where(bad[..., None, None], 0.0, matrix))
    return modes_in(elements, oil, poles, vectors, bad)


def held_poles(elements: Elements, oil: Oil, bad: NDArray[np.bool_]) -> ComplexArray:
    """The eigenvalues alone, in no order, (…, pole) [1/s]; NaN where there is no rest."""
    matrix = np.concatenate(_oil_motion(elements, oil), axis=-2)
    poles = np.linalg.eigvals(np.where(bad[..., None, None], 0.0, matrix)).astype(complex)
    poles[bad] = np.nan
    return np.asarray(poles)


def modes_in(elements: Elements, oil: Oil | None, poles: Array, vectors: Array, bad: NDArray[np.bool_]) -> RigidModes:
    """The same of eigenvalues (…, pole) and vectors (…, state, pole), whose first states are the coordinates."""
    order = np.argsort(np.round(np.abs(poles), 9), axis=-1, kind="stable")
    own: ComplexArray = np.take_along_axis(poles.astype(complex), order, axis=-1)
    shapes: ComplexArray = np.take_along_axis(vectors.astype(complex), order[..., None, :], axis=-1)
    own[bad] = np.nan
    chosen = _label(elements, own, shapes, _plane_frequencies(elements, oil))
    picked = np.where(chosen >= 0, np.take_along_axis(own, np.maximum(chosen, 0), axis=-1), np.nan)
    return RigidModes(own, shapes, chosen, picked)


def tipping_margin(elements: Elements) -> Array:
    """1 − the largest eigenvalue of K⁻¹G: stiffness K of the membranes and feet, G what gravity takes of it.

    Of upright mounts in the mount plane heave and rocking (and plates) decide; sideways motion does not meet gravity.
    NaN where nothing carries.
    """
    sideways = [JOINTS.index(dof) for dof in ("x", "y", "rz")] if elements.values.flat.all() else []
    deciding = [k for k in range(elements.mass.shape[-1]) if k not in sideways]
    own, taken = (part[..., deciding, :][..., deciding] for part in (elements.stiffness, elements.toppling))
    ratio = solve(own + taken, taken)
    lost = np.asarray(~np.isfinite(ratio).all(axis=(-2, -1)))
    share = np.linalg.eigvals(np.where(lost[..., None, None], 0.0, ratio)).real.max(axis=-1)
    return np.asarray(np.where(lost, np.nan, 1.0 - share))


def _plane_frequencies(elements: Elements, oil: Oil | None) -> Array:
    """Geometric mean of the two undamped frequencies in the planes about x and y, (…, 2) [rad/s]; oil locked."""
    stiffness = elements.stiffness
    if oil is not None:
        locked = oil.stretch * sum(a**2 / c for a, c in zip(oil.areas, oil.compliances, strict=True))
        stiffness = stiffness + np.einsum("...in,...i,...im->...nm", elements.plate, locked, elements.plate)
    planes = []
    for dofs in _GROUPS[:2]:
        own = [JOINTS.index(dof) for dof in dofs]
        k, m = (np.linalg.det(matrix[..., own, :][..., own]) for matrix in (stiffness, elements.mass))
        planes.append(np.abs(k / m) ** 0.25)
    return np.stack(planes, axis=-1)


def _label(
    elements: Elements, poles: ComplexArray, vectors: ComplexArray, plane_frequencies: Array
) -> NDArray[np.int64]:
    """Which pole is which of `RIGID_MODES`, (…, 6); −1: none oscillates so.

    Names go to the six slowest oscillations by where the machine's kinetic energy is, so that the sum of the shares is
    greatest; within a plane by frequency. One that is left alone in its plane (the other tips over, or creeps) is the
    upper or the lower by the side of the mean undamped frequency that it is on.
    """
    at = elements.values.common
    n = elements.mass.shape[-1]
    moved = np.einsum("...on,...np->...op", elements.cg, vectors[..., :n, :])
    body = body_of(at)
    weighed = np.concatenate([body.mass[..., None, None] * moved[..., :3, :], body.tensor @ moved[..., 3:, :]], axis=-2)
    energy = np.real(moved.conj() * weighed)
    share = energy / np.maximum(energy.sum(axis=-2, keepdims=True), np.finfo(float).tiny)
    groups = np.stack([sum(share[..., DOFS.index(dof), :] for dof in dofs) for dofs in _GROUPS], axis=-2)
    chosen = np.full((*poles.shape[:-1], len(RIGID_MODES)), -1, np.int64)
    for design in np.ndindex(*poles.shape[:-1]):
        size, own = np.abs(poles[design]), chosen[design]
        candidates = np.flatnonzero(poles[design].imag > OSCILLATES * np.maximum(1.0, size))[: len(RIGID_MODES)]
        if candidates.size == 0:
            continue
        slots, picks = linear_sum_assignment(-groups[design][:, candidates])
        own[slots] = candidates[picks]
        for plane, (lower, upper) in enumerate(((0, 4), (1, 5))):
            pair = sorted(k for k in (own[lower], own[upper]) if k >= 0)
            if len(pair) == 1:
                pair = [-1, *pair] if size[pair[0]] > plane_frequencies[design][plane] else [*pair, -1]
            if pair:
                own[lower], own[upper] = pair
    return chosen
