"""SAC pole-zero files, as SAC defines them and as networks annotate them.

SAC (*SAC Users Manual*, TRANSFER, "polezero"): lines ``ZEROS n``, ``POLES n`` and ``CONSTANT c``, in any order; roots
in rad/s follow, zeros at the origin need not; a missing group is empty, a missing constant is one. The input is
displacement in metres unless a comment ``* INPUT UNIT`` says otherwise. Comments name channel and epoch.
"""

import re
from dataclasses import dataclass, field
from datetime import datetime

import numpy as np

from ehamj.arrays import ComplexArray
from ehamj.records.epochs import Epoch
from ehamj.records.instrument import Instrument
from ehamj.records.units import motion_unit
from ehamj.signals import Array

MOST_ROOTS = 1000
CODES = ("NETWORK", "STATION", "LOCATION", "CHANNEL")
_COMMENT = re.compile(r"\*\s*([A-Za-z][A-Za-z0-9 ]*?)\s*(?:\([^)]*\))?\s*:\s*(.*?)\s*")
_GROUP = re.compile(r"(ZEROS|POLES|CONSTANT)\s+(\S+)", re.IGNORECASE)


@dataclass
class PoleZeros:
    """One response of a file: what its comments say, roots [rad/s] and constant [counts per unit]."""

    comments: dict[str, str] = field(default_factory=dict)
    roots: dict[str, list[complex]] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    constant: float | None = None

    @property
    def codes(self) -> tuple[str, str, str, str] | None:
        """Network, station, location, channel; None where the file does not say."""
        if not any(self.comments.get(code) for code in CODES[1:]):
            return None
        network, station, location, channel = (self.comments.get(code, "").strip("-") for code in CODES)
        return network, station, location, channel

    @property
    def epoch(self) -> Epoch:
        """When the response holds."""
        return Epoch(self.title, _moment(self.comments.get("START")), _moment(self.comments.get("END")))

    @property
    def title(self) -> str:
        """Channel and epoch, for messages."""
        name = "a response without name" if self.codes is None else ".".join(self.codes)
        return f"{name} ({self.comments.get('START') or '…'} to {self.comments.get('END') or '…'})"

    def instrument(self, name: str) -> Instrument:
        """The instrument; raises ValueError where the file is not whole."""
        zeros, poles = (np.array(self.roots.get(group, []), complex) for group in ("ZEROS", "POLES"))
        for group, found in (("ZEROS", zeros), ("POLES", poles)):
            announced = self.counts.get(group, 0)
            if found.size > announced or (group == "POLES" and found.size < announced):
                raise ValueError(
                    f"ground.inventory: {group} of {name}: {announced} are announced, {found.size} follow; correct it"
                )
        zeros = np.concatenate([zeros, np.zeros(self.counts.get("ZEROS", 0) - zeros.size)])
        stated = self.comments.get("INPUT UNIT", "")
        try:
            quantity, size = motion_unit(stated) if stated else ("displacement", 1.0)
        except ValueError as error:
            raise ValueError(f"ground.inventory: {name} senses {stated!r}: {error}") from None
        constant = 1.0 if self.constant is None else self.constant
        output = self.comments.get("OUTPUT UNIT", "COUNTS")
        if "COUNT" not in output.upper():
            raise ValueError(f"ground.inventory: the response of {name} ends in {output!r}, not in counts")

        def stages(frequency: Array) -> ComplexArray:
            s = 2j * np.pi * np.asarray(frequency, float)
            # Root by root, so that neither product overflows on its own.
            value = np.full(len(s), constant / size, complex)
            for k in range(max(zeros.size, poles.size)):
                value *= s - zeros[k] if k < zeros.size else 1.0
                value /= s - poles[k] if k < poles.size else 1.0
            return value

        notes = () if stated else (f"{name}: pole-zero file without input unit: displacement in m, as SAC has it",)
        overall = [_leading(self.comments.get(key)) for key in ("SENSITIVITY", "A0")]
        whole = None if None in overall else float(np.prod([abs(one) for one in overall if one is not None])) / size
        unit = (stated or "m", size)
        return Instrument(
            quantity, stages, abs(constant) / size, whole, unit, " (CONSTANT against A0·SENSITIVITY)", notes
        )


def looks_like_poles(data: bytes) -> bool:
    """Whether a file is one of poles and zeros: text with their two headings."""
    head = data[: 2**16].decode("latin-1")
    return "\0" not in head and all(re.search(rf"^\s*{word}\s+\d", head, re.I | re.M) for word in ("ZEROS", "POLES"))


def read_poles(data: bytes) -> list[PoleZeros]:
    """The responses of a file; a comment after a constant, or a second group of a kind, begins the next.

    Raises:
        ValueError: naming the line, where it makes no sense.
    """
    found, now, group = [], PoleZeros(), ""
    for number, raw in enumerate(data.decode("utf-8", errors="replace").splitlines(), start=1):
        line = raw.strip()
        heading = _GROUP.fullmatch(line)
        kind = heading[1].upper() if heading else ""
        begun = now.constant is not None or kind in now.counts
        if begun and (line.startswith("*") or heading):
            found.append(now)
            now = PoleZeros()
        try:
            if line.startswith("*"):
                comment = _COMMENT.fullmatch(line)
                if comment:
                    now.comments[comment[1].upper()] = comment[2]
            elif heading and kind == "CONSTANT":
                now.constant, group = _finite(heading[2]), ""
            elif heading:
                group, now.counts[kind] = kind, int(heading[2])
                if not 0 <= now.counts[kind] <= MOST_ROOTS:
                    raise ValueError(f"from 0 to {MOST_ROOTS} roots are allowed")
            elif line:
                parts = [_finite(part) for part in line.split()]
                if not group or len(parts) != 2:
                    raise ValueError("a root is two numbers, after ZEROS or POLES")
                now.roots.setdefault(group, []).append(complex(*parts))
        except ValueError as error:
            raise ValueError(f"line {number} of poles and zeros, {line[:40]!r}: {error}") from None
    if now.counts or now.constant is not None:
        found.append(now)
    return found


def _finite(text: str) -> float:
    value = float(text)
    if not np.isfinite(value):
        raise ValueError(f"{text!r} is not finite")
    return value


def _leading(text: str | None) -> float | None:
    """The number that a comment begins with, if it is a finite one."""
    match = re.match(r"[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?", text or "")
    value = float(match[0]) if match else 0.0
    return value if value and np.isfinite(value) else None


def _moment(text: str | None) -> datetime | None:
    """A time of a comment, None where there is none that can be read: open on that side."""
    try:
        return datetime.fromisoformat((text or "").strip().rstrip("Z"))
    except ValueError:
        return None
