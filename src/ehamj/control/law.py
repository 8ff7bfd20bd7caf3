"""A control law as a frozen discrete state space, with what makes it digital: rate, delay, range, resolution.

Every law runs in the same way, native or in Python, alone or in a `ehamj.control.bank.ControllerBank`: at a sample
its outputs are computed and faded, act ``delay`` later, are held, and go limited and rounded to the valves. What fade
and range took from them (``applied − wanted``, the rounding left out, which is known noise) goes back into the states
through ``anti_windup``.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.control.channels import N_SIGNALS, channel_names, channel_row
from ehamj.control.statespace import response
from ehamj.control.windup import anti_windup_gain, limited_radius
from ehamj.errors import InputError
from ehamj.plant.mounts import MOUNTS
from ehamj.plant.plant import Plant

Array = NDArray[np.float64]

UNSTABLE = 1.0 + 1e-9
"""Spectral radius above which a law counts as unstable on its own; integrators are allowed."""

OUTPUTS = tuple(f"valve_command {mount}" for mount in MOUNTS)

CONVERTER = ("voltage_limit", "bits", "switch_on", "fade", "from_rest")
"""What laws that run side by side must share: there is one converter per valve, and one reading per channel."""


@dataclass(frozen=True, eq=False)
class Controller:
    """x⁺ = A x + B u + L (applied − wanted), y = C x + D u, every ``period``; u are measured channels in SI, y the four
    commands [V].

    The commands act ``delay`` [s] after the sample (default: one period; any multiple of the integration step), held
    until the next; they are limited to ±``voltage_limit`` and rounded to ``bits``. Until ``switch_on`` [s] the valves
    get zero, and over the ``fade`` [s] that follows the share 3s² − 2s³ of the commands. L is ``anti_windup``
    (states, 4), without: zero; ``with_anti_windup`` chooses one. With it the states follow while the law is switched
    off, so that it takes over without a jump.

    Raises:
        InputError: if sizes do not fit, an entry is not finite, a channel is unknown, or the law is unstable by itself,
            or unstable while its commands are limited.
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
    anti_windup: Array | None = field(default=None, repr=False)
    switch_on: float = 0.0
    fade: float = 0.0
    from_rest: bool = False
    """Readings of displacements, strokes and pressures count from where the machine stands at the start; without,
    strokes and displacements count from unloaded membranes, and pressures are absolute."""

    def __post_init__(self) -> None:
        n, p = np.atleast_2d(self.A).shape[0], len(self.inputs)
        shapes = {"A": (n, n), "B": (n, p), "C": (len(MOUNTS), n), "D": (len(MOUNTS), p)}
        shapes |= {} if self.anti_windup is None else {"anti_windup": (n, len(MOUNTS))}
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
        check_clock(self.inputs, self.period, self.delay)
        check_converter(self.voltage_limit, self.bits, self.switch_on, self.fade)
        radius = float(np.abs(np.linalg.eigvals(self.A)).max()) if self.A.size else 0.0
        if radius > UNSTABLE:
            raise InputError(
                f"controller.A: unstable by itself, an eigenvalue has magnitude {radius:.9g}; it must be at most 1"
            )
        if self.anti_windup is not None and (radius := limited_radius(self.A, self.C, self.anti_windup)) > UNSTABLE:
            raise InputError(
                "controller.anti_windup: unstable while the commands are limited, an eigenvalue of A − anti_windup·C "
                f"has magnitude {radius:.9g}; it must be at most 1"
            )

    @classmethod
    def from_statespace(cls, system: Any, **settings: Any) -> Self:
        """A controller from a python-control ``StateSpace`` (or anything that ``control.ss`` takes) with ``dt``.

        Its input labels must be channel names (`ehamj.control.channels.channel_names`) unless ``inputs`` are given; its
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

    @property
    def parts(self) -> tuple["Controller", ...]:
        """The laws that run side by side: this one alone."""
        return (self,)

    def with_anti_windup(self, time: float = 0.02) -> Self:
        """The law with an anti-windup matrix by dual LQ (`ehamj.control.windup.anti_windup_gain`).

        Args:
            time: how fast an integrator is taken back while its command is limited [s].

        Raises:
            InputError: if ``time`` is shorter than a period, or no stable choice exists.
        """
        gain = anti_windup_gain(self.A, self.C, self.period, time)
        return replace(self, anti_windup=gain)

    def scaled(self, factor: float) -> Self:
        """The law with all its gains multiplied, its anti-windup as fast as it was."""
        windup = None if self.anti_windup is None or factor == 0.0 else self.anti_windup / factor
        return replace(self, C=factor * self.C, D=factor * self.D, anti_windup=windup)

    def response(self, hertz: ArrayLike) -> NDArray[np.complex128]:
        """Command over measured channel at ``hertz`` [Hz], shape (frequency, 4, inputs), with delay and hold.

        The hold is its own component at the same frequency, e^(−jωT/2)·sinc(fT); images above half the rate are not in
        it.
        """
        f = np.atleast_1d(np.asarray(hertz, float))
        omega = 2.0 * np.pi * f
        z = np.exp(1j * omega * self.period)
        plain = response(z, self.A, self.B, self.C, self.D)
        hold = np.sinc(f * self.period) * np.exp(-1j * omega * (0.5 * self.period + self.latency))
        return np.asarray(hold[:, None, None] * plain)

    def sensing(self, plant: Plant) -> Array:
        """The inputs as rows over the vector of signals, (inputs, signals); see `ehamj.control.channels`."""
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
            "switch_on_s": self.switch_on,
            "fade_s": self.fade,
            "from_rest": self.from_rest,
            **matrices,
            "anti_windup": None if self.anti_windup is None else self.anti_windup.tolist(),
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
            windup = table.get("anti_windup")
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
                anti_windup=None if windup is None else _matrix(windup, n, len(MOUNTS)),
                switch_on=float(table.get("switch_on_s", 0.0)),
                fade=float(table.get("fade_s", 0.0)),
                from_rest=bool(table.get("from_rest", False)),
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
        return cls.from_dict(read_table(path))


def read_table(path: Path) -> dict[str, Any]:
    """The JSON object in a file.

    Raises:
        InputError: if there is none.
    """
    try:
        table = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"control.file = {str(path)!r}: cannot be read as a controller ({error})") from error
    if not isinstance(table, dict):
        raise InputError(f"control.file = {str(path)!r}: must hold one JSON object")
    return table


def stack(laws: Sequence[Controller]) -> Controller:
    """Laws that run side by side and add up, as one; they must share rate, delay, range and resolution.

    Raises:
        InputError: if they do not.
    """
    first = laws[0]
    for law in laws[1:]:
        for name in ("period", "delay", *CONVERTER):
            if getattr(law, name) != getattr(first, name):
                raise InputError(f"controller.{name}: {getattr(law, name)} beside {getattr(first, name)}")
    inputs = tuple(dict.fromkeys(name for law in laws for name in law.inputs))
    n = sum(law.states for law in laws)
    A, B = np.zeros((n, n)), np.zeros((n, len(inputs)))
    C, D = np.zeros((len(MOUNTS), n)), np.zeros((len(MOUNTS), len(inputs)))
    windup = None if all(law.anti_windup is None for law in laws) else np.zeros((n, len(MOUNTS)))
    at = 0
    for law in laws:
        own = slice(at, at + law.states)
        if windup is not None and law.anti_windup is not None:
            windup[own] = law.anti_windup
        columns = [inputs.index(name) for name in law.inputs]
        A[own, own], C[:, own] = law.A, law.C
        B[own, columns] = law.B
        D[:, columns] += law.D
        at += law.states
    return replace(first, A=A, B=B, C=C, D=D, inputs=inputs, anti_windup=windup)


def _sizes(n: int, p: int) -> tuple[tuple[str, int, int], ...]:
    m = len(MOUNTS)
    return ("A", n, n), ("B", n, p), ("C", m, n), ("D", m, p)


def _matrix(values: ArrayLike, rows: int, columns: int) -> Array:
    matrix = np.array(values, float)
    return matrix.reshape(rows, columns) if matrix.size == 0 else matrix


def check_clock(inputs: Sequence[str], period: float, delay: float | None) -> None:
    """Refuse unknown channels, and a period or delay that is none."""
    for name in inputs:
        if name not in channel_names():
            raise InputError(f"controller.inputs: {unknown(name)}")
    positive("period", period)
    if delay is not None and not (np.isfinite(delay) and delay >= 0.0):
        raise InputError(f"controller.delay = {delay}: must be zero or positive [s]")


def check_converter(voltage_limit: float, bits: int | None, switch_on: float, fade: float) -> None:
    """Refuse a range, resolution or switch-on that is none."""
    positive("voltage_limit", voltage_limit)
    if bits is not None and not (isinstance(bits, int) and 2 <= bits <= 52):
        raise InputError(f"controller.bits = {bits}: must be a whole number from 2 to 52, or none")
    for name, value in (("switch_on", switch_on), ("fade", fade)):
        if not (np.isfinite(value) and value >= 0.0):
            raise InputError(f"controller.{name} = {value}: must be zero or positive [s]")


def positive(name: str, value: float) -> None:
    if not (value > 0.0 and np.isfinite(value)):
        raise InputError(f"controller.{name} = {value}: must be a positive number")


def unknown(name: str) -> str:
    """Why a channel name is refused, with what is near it."""
    try:
        channel_row(name, None)  # type: ignore[arg-type]
    except ValueError as error:
        return str(error)
    return f"channel {name!r} is unknown"
