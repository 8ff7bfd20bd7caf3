"""A control law as a frozen discrete state space, with what makes it digital: rate, delay, range, resolution."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.channels import N_SIGNALS, channel_names, channel_row
from ehamj.errors import InputError
from ehamj.layout import MOUNTS
from ehamj.parameters import Plant

Array = NDArray[np.float64]

UNSTABLE = 1.0 + 1e-9
"""Spectral radius above which a law counts as unstable on its own; integrators are allowed."""

OUTPUTS = tuple(f"valve_command {mount}" for mount in MOUNTS)


@dataclass(frozen=True, eq=False)
class Controller:
    """x⁺ = A x + B u, y = C x + D u, every ``period``; u are measured channels in SI, y the four commands [V].

    The commands act ``delay`` [s] after the sample (default: one period), held until the next; they are limited to
    ±``voltage_limit`` and rounded to ``bits``.

    Raises:
        InputError: if sizes do not fit, an entry is not finite, a channel is unknown, or the law is unstable by itself.
    """

    A: Array = field(repr=False)
    B: Array = field(repr=False)
    C: Array = field(repr=False)
    D: Array = field(repr=False)
    inputs: tuple[str, ...]
    period: float = 1e-4
    delay: float | None = None
    voltage_limit: float = 10.0
    bits: int | None = 16

    def __post_init__(self) -> None:
        n, p = np.atleast_2d(self.A).shape[0], len(self.inputs)
        shapes = {"A": (n, n), "B": (n, p), "C": (len(MOUNTS), n), "D": (len(MOUNTS), p)}
        for name, shape in shapes.items():
            given = np.asarray(getattr(self, name))
            if np.iscomplexobj(given):
                raise InputError(f"controller.{name}: has complex entries; every entry must be a real number")
            matrix = np.array(given, float, order="C")
            if matrix.size == 0 and 0 in shape:
                matrix = np.zeros(shape)
            if matrix.shape != shape:
                raise InputError(
                    f"controller.{name}: has shape {matrix.shape}, it must be {shape} "
                    f"({n} states, {p} inputs, {len(MOUNTS)} valves)"
                )
            if not np.isfinite(matrix).all():
                at = tuple(int(k) for k in np.argwhere(~np.isfinite(matrix))[0])
                raise InputError(f"controller.{name}: entry {at} is {matrix[at]}; every entry must be finite")
            matrix.flags.writeable = False
            object.__setattr__(self, name, matrix)
        for name in self.inputs:
            if name not in channel_names():
                raise InputError(f"controller.inputs: {_unknown(name)}")
        _positive("period", self.period)
        _positive("voltage_limit", self.voltage_limit)
        if not (np.isfinite(self.latency) and self.latency >= 0.0):
            raise InputError(f"controller.delay = {self.delay}: must be zero or positive [s]")
        if self.bits is not None and not (isinstance(self.bits, int) and 2 <= self.bits <= 52):
            raise InputError(f"controller.bits = {self.bits}: must be a whole number from 2 to 52, or none")
        radius = float(np.abs(np.linalg.eigvals(self.A)).max()) if self.A.size else 0.0
        if radius > UNSTABLE:
            raise InputError(
                f"controller.A: unstable by itself, an eigenvalue has magnitude {radius:.9g}; it must be at most 1"
            )

    @classmethod
    def from_statespace(cls, system: Any, **settings: Any) -> Self:
        """A controller from a python-control ``StateSpace`` (or anything that ``control.ss`` takes) with ``dt``.

        Its input labels must be channel names (`ehamj.channels.channel_names`) unless ``inputs`` are given; its
        outputs are the valves in the order of the mounts, or labelled ``valve_command MOUNT`` in any order.

        Raises:
            InputError: as the class, and if ``dt`` is not a sampling period.
        """
        import control

        system = control.ss(system)
        if system.dt is None or system.dt is True or not system.dt > 0:
            raise InputError(f"controller: dt = {system.dt} is no sampling period; discretise the law first")
        labels = list(system.output_labels)
        if len(labels) != len(MOUNTS):
            raise InputError(f"controller: has {len(labels)} outputs, it must have {len(MOUNTS)}, one per valve")
        wrong = [label for label in labels if label.startswith("valve_command") and label not in OUTPUTS]
        if wrong:
            raise InputError(f"controller: output {wrong[0]!r} is no valve; the valves are {', '.join(OUTPUTS)}")
        order = [labels.index(name) for name in OUTPUTS] if set(labels) == set(OUTPUTS) else range(len(MOUNTS))
        inputs = tuple(settings.pop("inputs", system.input_labels))
        period = settings.pop("period", float(system.dt))
        if abs(period - float(system.dt)) > 1e-12:
            raise InputError(f"controller.period = {period:g} s differs from the law's dt = {system.dt:g} s")
        rows = list(order)
        return cls(system.A, system.B, system.C[rows], system.D[rows], inputs, period, **settings)

    @property
    def latency(self) -> float:
        """Time from a sample to its command [s]."""
        return self.period if self.delay is None else self.delay

    @property
    def states(self) -> int:
        """Number of states."""
        return int(self.A.shape[0])

    def sensing(self, plant: Plant) -> Array:
        """The inputs as rows over the vector of signals, (inputs, signals); see `ehamj.channels`."""
        return np.array([channel_row(name, plant) for name in self.inputs]).reshape(len(self.inputs), N_SIGNALS)

    def save(self, path: Path) -> None:
        """Write the law as JSON."""
        path.write_text(json.dumps(self.to_dict(), indent=1) + "\n", encoding="utf-8")

    def to_dict(self) -> dict[str, Any]:
        """The law as plain data, see `from_dict`."""
        matrices = {name: getattr(self, name).tolist() for name in "ABCD"}
        return {
            "inputs": list(self.inputs),
            "outputs": list(OUTPUTS),
            "period_s": self.period,
            "delay_s": self.delay,
            "voltage_limit_v": self.voltage_limit,
            "bits": self.bits,
            **matrices,
        }

    @classmethod
    def from_dict(cls, table: dict[str, Any]) -> Self:
        """The inverse of `to_dict`.

        Raises:
            InputError: if a key is missing or of the wrong type; and as the class.
        """
        needed = ("inputs", "period_s", *"ABCD")
        missing = [key for key in needed if key not in table]
        if missing:
            raise InputError(f"controller: {missing[0]} is missing; needed are {', '.join(needed)}")
        if table.get("outputs", list(OUTPUTS)) != list(OUTPUTS):
            raise InputError(f"controller.outputs = {table['outputs']}: must be {list(OUTPUTS)}")
        try:
            n, p = len(table["A"]), len(table["inputs"])
            A, B, C, D = (_matrix(table[name], rows, columns) for name, rows, columns in _sizes(n, p))
            return cls(
                A,
                B,
                C,
                D,
                inputs=tuple(table["inputs"]),
                period=float(table["period_s"]),
                delay=None if table.get("delay_s") is None else float(table["delay_s"]),
                voltage_limit=float(table.get("voltage_limit_v", 10.0)),
                bits=table.get("bits", 16),
            )
        except (TypeError, ValueError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"controller: not a law ({error})") from error

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a law written by `save`.

        Raises:
            InputError: if the file cannot be read, and as the class.
        """
        try:
            table = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise InputError(f"control.file = {str(path)!r}: cannot be read as a controller ({error})") from error
        if not isinstance(table, dict):
            raise InputError(f"control.file = {str(path)!r}: must hold one JSON object")
        return cls.from_dict(table)


def stack(laws: Sequence[Controller]) -> Controller:
    """Laws that run side by side and add up, as one; they must share rate, delay, range and resolution.

    Raises:
        InputError: if they do not.
    """
    first = laws[0]
    for law in laws[1:]:
        for name in ("period", "delay", "voltage_limit", "bits"):
            if getattr(law, name) != getattr(first, name):
                raise InputError(f"controller.{name}: {getattr(law, name)} beside {getattr(first, name)}")
    inputs = tuple(dict.fromkeys(name for law in laws for name in law.inputs))
    n = sum(law.states for law in laws)
    A, B = np.zeros((n, n)), np.zeros((n, len(inputs)))
    C, D = np.zeros((len(MOUNTS), n)), np.zeros((len(MOUNTS), len(inputs)))
    at = 0
    for law in laws:
        own = slice(at, at + law.states)
        columns = [inputs.index(name) for name in law.inputs]
        A[own, own], C[:, own] = law.A, law.C
        B[own, columns] = law.B
        D[:, columns] += law.D
        at += law.states
    return Controller(A, B, C, D, inputs, first.period, first.delay, first.voltage_limit, first.bits)


def _sizes(n: int, p: int) -> tuple[tuple[str, int, int], ...]:
    m = len(MOUNTS)
    return ("A", n, n), ("B", n, p), ("C", m, n), ("D", m, p)


def _matrix(values: ArrayLike, rows: int, columns: int) -> Array:
    matrix = np.array(values, float)
    return matrix.reshape(rows, columns) if matrix.size == 0 else matrix


def _positive(name: str, value: float) -> None:
    if not (value > 0.0 and np.isfinite(value)):
        raise InputError(f"controller.{name} = {value}: must be a positive number")


def _unknown(name: str) -> str:
    try:
        channel_row(name, None)  # type: ignore[arg-type]
    except ValueError as error:
        return str(error)
    return f"channel {name!r} is unknown"
