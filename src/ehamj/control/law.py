"""A control law as a frozen discrete state space, with what makes it digital: rate, delay, range, resolution.

Every law runs in the same way, native or in Python, alone or in a `ehamj.control.bank.ControllerBank`: at a sample
its outputs are computed and faded, act ``delay`` later, are held, and go limited and rounded to the valves. What fade
and range took from them (``applied − wanted``, the rounding left out, which is known noise) goes back into the states
through ``anti_windup``.
"""

import json
import reprlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.arrays import Array
from ehamj.belonging import RUN
from ehamj.control import blocks
from ehamj.control.channels import valve_commands
from ehamj.control.converter import Sampled, difference
from ehamj.control.learners import Learner
from ehamj.control.lines import Line, check_lines
from ehamj.control.spools import KnownSpool
from ehamj.control.tables import check_keys, flag_in, law_in, names_in, number_in
from ehamj.control.valves import KnownValve
from ehamj.control.windup import anti_windup_gain, limited_radius
from ehamj.errors import InputError
from ehamj.plant.mounts import MOUNTS

UNSTABLE = 1.0 + 1e-9
"""Spectral radius above which a law counts as unstable on its own; integrators are allowed."""

LARGEST_ENTRY: Final = 1e30
"""Magnitude of a matrix's entries beyond which products of them are lost."""

KEYS: Final = {
    "inputs": "inputs", "period": "period_s", "delay": "delay_s", "voltage_limit": "voltage_limit_v", "bits": "bits",
    "switch_on": "switch_on_s", "fade": "fade_s", "from_rest": "from_rest", "A": "A", "B": "B", "C": "C", "D": "D",
    "anti_windup": "anti_windup", "valves": "valves", "learners": "learners", "lines": "lines", "spools": "spools",
}  # fmt: skip
"""Keys of a law's file by what they hold; `NEEDED` must be there."""
NEEDED: Final = ("inputs", "period", *"ABCD")


@dataclass(frozen=True, eq=False)
class Controller(Sampled):
    """x⁺ = A x + B u + L (applied − wanted), y = C x + D u, every ``period``; u are measured channels in SI, y the
    commands [V], one per valve.

    The commands act ``delay`` [s] after the sample (default: one period; any multiple of the integration step), held
    until the next; then they go through the `Converter`, whose settings are the law's too. L is ``anti_windup``
    (states, valves), without: zero; ``with_anti_windup`` chooses one. With it the states follow while the law is
    switched off, so that it takes over without a jump.

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
    anti_windup: Array | None = field(default=None, repr=False, kw_only=True)
    lines: tuple[Line, ...] = field(default=(), kw_only=True)
    """Lines whose frequency it follows: pairs of its states turn with each, and take nothing in while commands fade or
    are limited."""

    def __post_init__(self) -> None:
        n, p, valves = len(np.atleast_1d(self.A)), len(self.inputs), len(self.mounts)
        shapes = {"A": (n, n), "B": (n, p), "C": (valves, n), "D": (valves, p)}
        shapes |= {} if self.anti_windup is None else {"anti_windup": (n, valves)}
        for name, shape in shapes.items():
            matrix = _real(name, getattr(self, name), shape)
            if matrix.shape != shape:
                raise InputError(
                    f"controller.{name}: has shape {matrix.shape}, it must be {shape} "
                    f"({n} states, {p} inputs, {valves} valves)"
                )
            object.__setattr__(self, name, matrix)
        super().__post_init__()
        check_lines(self.lines, self.A, self.period)
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
        outputs are the valves in the order of the mounts, or labelled ``valve_command MOUNT`` or ``MOUNT`` in any
        order. Strokes, displacements and pressures are read from where the machine stands with ``from_rest=True`` among
        the ``settings``, which laws in other tools' files have of themselves, and here none has.

        Raises:
            InputError: as the class, and if ``dt`` is not a sampling period.
        """
        import control

        system = control.ss(system)
        if system.dt is None or system.dt is True or not system.dt > 0:
            raise InputError(f"controller: dt = {system.dt} is no sampling period; discretise the law first")
        labels, valves = list(system.output_labels), valve_commands(settings.get("mounts", MOUNTS))
        if len(labels) != len(valves):
            raise InputError(f"controller: has {len(labels)} outputs, it must have {len(valves)}, one per valve")
        at = [_valve_of(label, valves) for label in labels]
        named = any(valve is not None for valve in at)
        if named and sorted(map(str, at)) != sorted(valves):
            wrong = next(label for k, label in enumerate(labels) if not at[k] or at[k] in at[:k])
            raise InputError(
                f"controller: output {wrong!r} beside those that name valves: all must, each once, of "
                f"{', '.join(valves)}; or none"
            )
        rows = [at.index(name) for name in valves] if named else list(range(len(valves)))
        inputs = tuple(settings.pop("inputs", system.input_labels))
        period = settings.pop("period", float(system.dt))
        if abs(period - float(system.dt)) > 1e-12:
            raise InputError(f"controller.period = {period:g} s differs from the law's dt = {system.dt:g} s")
        return cls(system.A, system.B, system.C[rows], system.D[rows], inputs, period, **settings)

    @property
    def states(self) -> int:
        """Number of states."""
        return int(self.A.shape[0])

    def with_anti_windup(self, time: float = 0.02) -> Self:
        """The law with an anti-windup matrix by dual LQ (`ehamj.control.windup.anti_windup_gain`).

        Args:
            time: how fast an integrator is taken back while its command is limited [s].

        Raises:
            InputError: if ``time`` is shorter than a period, or no stable choice exists.
        """
        return replace(self, anti_windup=anti_windup_gain(self.A, self.C, self.period, time))

    def scaled(self, factor: float) -> Self:
        """The law with all its gains multiplied, its anti-windup as fast as it was."""
        windup = None if self.anti_windup is None or factor == 0.0 else self.anti_windup / factor
        return replace(self, C=factor * self.C, D=factor * self.D, anti_windup=windup)

    def turned(self, end: Literal["low", "high"]) -> Self:
        """The law with all lines that it follows at the end of their ranges."""
        A, lines = self.A, []
        for line in self.lines:
            hertz = getattr(line, end)
            A = line.turned(A, self.period, hertz)
            lines.append(line._replace(frequency=hertz))
        return replace(self, A=A, lines=tuple(lines))

    def at(self, z: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """C (z − A)⁻¹ B + D from sample to sample, (z, valves, inputs)."""
        return blocks.response(z, self.A, self.B, self.C, self.D)

    def response(self, hertz: ArrayLike) -> NDArray[np.complex128]:
        """Command over measured channel at ``hertz`` [Hz], shape (frequency, valves, inputs), with delay and hold.

        The hold is its own component at the same frequency, e^(−jωT/2)·sinc(fT); images above half the rate are not in
        it.
        """
        f = np.atleast_1d(np.asarray(hertz, float))
        omega = 2.0 * np.pi * f
        hold = np.sinc(f * self.period) * np.exp(-1j * omega * (0.5 * self.period + self.latency))
        return np.asarray(hold[:, None, None] * self.at(np.exp(1j * omega * self.period)))

    def save(self, path: str | Path) -> None:
        """Write the law as JSON."""
        Path(path).write_text(json.dumps(self.to_dict(), indent=1) + "\n", encoding="utf-8")

    def to_dict(self) -> dict[str, Any]:
        """The law as plain data, see `from_dict`."""
        values = {key: getattr(self, name) for name, key in KEYS.items()}
        plain = {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in values.items()}
        lists = ("valves", "learners", "lines", "spools")
        known = {name: [one.to_dict() for one in getattr(self, name)] for name in lists}
        return plain | {"inputs": list(self.inputs), "outputs": list(self.outputs)} | known

    @classmethod
    def from_dict(cls, table: dict[str, Any]) -> Self:
        """The inverse of `to_dict`.

        Raises:
            InputError: if a key is missing or of the wrong type; and as the class.
        """
        missing = [KEYS[name] for name in NEEDED if KEYS[name] not in table]
        if missing:
            raise InputError(f"controller: {missing[0]} is missing; needed are {', '.join(KEYS[n] for n in NEEDED)}")
        check_keys("controller", table, (*KEYS.values(), "outputs", RUN))
        given = {name: table[key] for name, key in KEYS.items() if key in table}
        given["mounts"] = _mounts_of(table.get("outputs", list(valve_commands(MOUNTS))))
        try:
            given |= {name: list(given[name]) for name in "ABCD"}
            given["inputs"] = names_in(given["inputs"])
            given["from_rest"] = flag_in(given.get("from_rest", False))
            given["valves"] = tuple(map(KnownValve.from_dict, given.get("valves", ())))
            given["learners"] = tuple(map(Learner.from_dict, given.get("learners", ())))
            given["spools"] = tuple(map(KnownSpool.from_dict, given.get("spools", ())))
            given["lines"] = tuple(map(Line.from_dict, given.get("lines", ())))
            for name in ("period", "delay", "voltage_limit", "switch_on", "fade"):
                if given.get(name) is not None:
                    given[name] = number_in(given[name], f"controller.{KEYS[name]}")
            return cls(**given)
        except InputError:
            raise
        except (TypeError, ValueError) as error:
            raise InputError(f"controller: not a law ({error})") from error

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a law written by `save`.

        Raises:
            InputError: if the file cannot be read, and as the class.
        """
        return law_in(path, cls.from_dict)


def _real(name: str, given: Any, shape: tuple[int, int]) -> Array:
    """A matrix of a law, of its own and not to be written to; an empty one has the ``shape`` that is wanted."""
    plain = np.asarray(given)
    if np.iscomplexobj(plain):
        raise InputError(f"controller.{name}: has complex entries; every entry must be a real number")
    if plain.dtype.kind not in "fiu":
        raise InputError(f"controller.{name}: has entries that are no numbers; every entry must be a real number")
    matrix = np.array(given, float, order="C")
    if matrix.size == 0 and 0 in shape:
        matrix = np.zeros(shape)
    if matrix.shape == shape and not np.isfinite(matrix).all():
        at = tuple(int(k) for k in np.argwhere(~np.isfinite(matrix))[0])
        raise InputError(f"controller.{name}: entry {at} is {matrix[at]}; every entry must be finite")
    if matrix.size and np.abs(matrix).max() > LARGEST_ENTRY:
        raise InputError(f"controller.{name}: has entries beyond {LARGEST_ENTRY:g}; scale the law's states")
    matrix.flags.writeable = False
    return matrix


def silent(channels: Sequence[str], mounts: Sequence[str], period: float, delay: float | None = None) -> Controller:
    """A law that reads channels every ``period`` [s] and commands nothing: 0 V at every mount, ``delay`` [s] after each
    sample (None: a period)."""
    n, valves = len(channels), len(mounts)
    matrices = np.zeros((0, 0)), np.zeros((0, n)), np.zeros((valves, 0)), np.zeros((valves, n))
    return Controller(*matrices, tuple(channels), period, delay, mounts=tuple(mounts))


def stack(laws: Sequence[Controller]) -> Controller:
    """Laws that run side by side and add up, as one; they must share rate, delay, range and resolution.

    Raises:
        InputError: if they do not.
    """
    first, valves = laws[0], len(laws[0].mounts)
    if found := difference(laws, ("period", "delay")):
        name, ours, theirs = found
        raise InputError(f"controller.{name}: {theirs} beside {ours}")
    inputs = tuple(dict.fromkeys(name for law in laws for name in law.inputs))
    n = sum(law.states for law in laws)
    A, B = np.zeros((n, n)), np.zeros((n, len(inputs)))
    C, D = np.zeros((valves, n)), np.zeros((valves, len(inputs)))
    windup = None if all(law.anti_windup is None for law in laws) else np.zeros((n, valves))
    at, lines = 0, []
    for law in laws:
        lines += [line.moved(at) for line in law.lines]
        own = slice(at, at + law.states)
        if windup is not None and law.anti_windup is not None:
            windup[own] = law.anti_windup
        columns = [inputs.index(name) for name in law.inputs]
        A[own, own], C[:, own] = law.A, law.C
        B[own, columns] = law.B
        D[:, columns] += law.D
        at += law.states
    return replace(first, A=A, B=B, C=C, D=D, inputs=inputs, anti_windup=windup, lines=tuple(lines))


def _mounts_of(outputs: Any) -> tuple[str, ...]:
    """Mounts whose valves a law's outputs command."""
    names = outputs if isinstance(outputs, list) and all(isinstance(name, str) for name in outputs) else []
    mounts = tuple(name.removeprefix("valve_command ") for name in names)
    if set(mounts) == set(MOUNTS) and mounts != MOUNTS:
        raise InputError(f"controller.outputs = {outputs}: must be {list(valve_commands(MOUNTS))}, in this order")
    if not mounts or list(valve_commands(mounts)) != names or len(set(mounts)) < len(mounts):
        raise InputError(
            f"controller.outputs = {reprlib.repr(outputs)}: must be a list of 'valve_command MOUNT', each once, as "
            f"{', '.join(valve_commands(MOUNTS))}"
        )
    return mounts


def _valve_of(label: str, valves: Sequence[str]) -> str | None:
    """The valve that an output's label names, with or without ``valve_command``; '' for one that there is not."""
    name = f"valve_command {label.removeprefix('valve_command').strip()}"
    if name in valves:
        return name
    return "" if label.startswith("valve_command") else None
