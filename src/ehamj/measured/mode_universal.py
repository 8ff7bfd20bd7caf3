"""Mode shapes in universal files: dataset 55, data at nodes, of normal and of complex modes."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.measured.modes import ModeTable
from ehamj.records.files import existing, reading
from ehamj.records.uff import opened

SHAPES: Final = 55
NORMAL, COMPLEX = 2, (3, 7)
"""Analysis types: normal modes, and complex ones."""
SIDES: Final = ("+X", "+Y", "+Z")
RESPONSES: Final = 58
"""Dataset of frequency responses."""
NEWER: Final = 2414
"""Dataset that shapes may stand in instead, which is not read."""


class _Shape(NamedTuple):
    frequency: float
    damping_ratio: float
    parts: dict[str, complex]
    """By node and direction."""


def datasets_of(path: Path) -> set[int]:
    """Numbers of the datasets that a universal file has; raises ValueError where it cannot be read."""
    existing(path)
    with opened(path) as file, reading(path, " as a universal file"):
        return {int(kind) for kind in file.get_set_types()}


def read_mode_universal(path: Path) -> ModeTable:
    """Modes of a universal file's datasets 55 (analysis types 2, 3 and 7), by node and direction, ``12:+Z``.

    A normal mode has its viscous damping ratio, else half of its hysteretic one; a complex mode's frequency and ratio
    are those of its eigenvalue [1/s]. What is zero in all modes was not measured: the format cannot say it otherwise.

    Raises:
        ValueError: where it cannot be read, holds no modes, or rotations.
    """
    existing(path)
    told = f"file = {path.name!r}"
    with opened(path) as file, reading(path, " as a universal file"):
        kinds = [int(kind) for kind in file.get_set_types()]
        sets = [file.read_sets(n) for n, kind in enumerate(kinds) if kind == SHAPES]
    shapes = [_shape(one, told) for one in sets if int(one["analysis_type"]) in (NORMAL, *COMPLEX)]
    if not shapes:
        newer = f"; of its modes in dataset {NEWER} export the older dataset 55" * (NEWER in kinds)
        raise ValueError(f"{told} holds no modes (dataset 55 of analysis type 2, 3 or 7) and no responses (58){newer}")
    names = list(dict.fromkeys(name for one in shapes for name in one.parts))
    values = np.array([[one.parts.get(name, 0.0) for name in names] for one in shapes], complex)
    kept = np.abs(values).max(axis=0) > 0.0
    if not kept.any():
        raise ValueError(f"{told}: all shapes are zero")
    nothing = np.full(len(shapes), np.nan)
    return ModeTable(
        tuple(name for name, one in zip(names, kept, strict=True) if one),
        np.array([one.frequency for one in shapes]),
        np.array([one.damping_ratio for one in shapes]),
        nothing,
        nothing.copy(),
        values[:, kept],
        nothing.copy(),
        all(int(one["data_type"]) == 2 for one in sets),
        f"mode shapes of the universal file {path.name}",
    )


def _shape(content: Mapping[str, Any], told: str) -> _Shape:
    number = int(content["mode_n"])
    if any(np.any(content[part]) for part in ("r4", "r5", "r6") if part in content):
        raise ValueError(f"{told}: the shape of mode {number} has rotations at nodes; export translations only")
    frequency, ratio = _normal(content) if int(content["analysis_type"]) == NORMAL else _complex(content)
    nodes = [str(int(node)) for node in content["node_nums"]]
    if len(set(nodes)) < len(nodes):
        twice = next(node for node in nodes if nodes.count(node) > 1)
        raise ValueError(f"{told}: the shape of mode {number} has node {twice} twice")
    columns: list[Array | ComplexArray] = [np.asarray(content[part]) for part in ("r1", "r2", "r3")]
    parts = {
        f"{node}:{side}": complex(value)
        for side, column in zip(SIDES, columns, strict=True)
        for node, value in zip(nodes, column, strict=True)
    }
    return _Shape(frequency, ratio, parts)


def _normal(content: Mapping[str, Any]) -> tuple[float, float]:
    """Frequency [Hz] and damping ratio, NaN where none is stated."""
    viscous, hysteretic = float(content["modal_damp_vis"]), float(content["modal_damp_his"])
    return float(content["freq"]), viscous or 0.5 * hysteretic or np.nan


def _complex(content: Mapping[str, Any]) -> tuple[float, float]:
    value = complex(content["eig"])
    return abs(value) / (2.0 * np.pi), -value.real / max(abs(value), 1e-300)
