"""Tables of text as loggers write them, made up from what they hold: `Written` is a way to write one."""

from dataclasses import dataclass, replace

import numpy as np

RATE = 500.0
"""Of every table, unless it is stated otherwise [Hz]."""

UNITS = {  # as written: quantity, SI value (by hand, from their definitions)
    "m": ("displacement", 1.0),
    "mm": ("displacement", 1e-3),
    "µm": ("displacement", 1e-6),
    "m/s": ("velocity", 1.0),
    "mm/s": ("velocity", 1e-3),
    "M/SEC": ("velocity", 1.0),
    "in/s": ("velocity", 0.0254),
    "m/s^2": ("acceleration", 1.0),
    "m/s²": ("acceleration", 1.0),
    "mm/s**2": ("acceleration", 1e-3),
    "m/s/s": ("acceleration", 1.0),
    "g": ("acceleration", 9.80665),
    "mg": ("acceleration", 9.80665e-3),
    "in/s^2": ("acceleration", 0.0254),
}

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0, "sec": 1.0, "h": 3600.0}

HEADERS = ("[]", "()", "{}", "quoted", "slash", "in", "unit row", "bracketed unit row", "unit comment", "comment")
CLOCKS = (
    *("time", "t", "Zeit", "Timestamp", "Elapsed time"),
    *("iso", "iso T", "iso zone", "german", "american", "of day", "date and time"),
    *("Sample rate,500", "# rate: 500 Hz", "rate_hz = 500", "Fs: 0.5 kHz", "dt = 0.002", "Sampling interval [ms]: 2"),
)
"""A column of times of that name, stamps, or a line that states the rate."""


@dataclass(frozen=True)
class Written:
    """A way to write a table."""

    delimiter: str = ","
    decimal: str = "."
    header: str = "[]"
    clock: str = "time"
    time_unit: str = "s"
    unit: str = "m/s^2"
    names: tuple[str, ...] = ("z",)
    quotes: bool = False
    preamble: tuple[str, ...] = ()
    footer: tuple[str, ...] = ()
    trailing: bool = False
    words: bool = False
    end: str = "\n"
    encoding: str = "utf-8"

    @property
    def possible(self) -> bool:
        """Whether the way contradicts nobody: itself, or what a person could tell."""
        blank = self.delimiter == " "
        return not (
            self.decimal == self.delimiter
            or (blank and self.header in ("in", "quoted"))
            or (blank and "unit row" in self.header and (self.words or not self._time_units(0)))
            or (blank and " " in self.clock and not self.stated)
            or (blank and self.clock in ("iso", "iso zone", "german", "american"))
            or (self.delimiter == "," and self.header == "quoted")
        )

    @property
    def stated(self) -> bool:
        """Whether a line states the rate, instead of times."""
        return any(mark in self.clock for mark in ",:=")

    def bytes(self, samples: np.ndarray, keep: np.ndarray | None = None) -> bytes:
        """The file with samples (column, row) at `RATE`; rows that ``keep`` leaves out are missing."""
        rows = np.arange(samples.shape[1]) if keep is None else np.flatnonzero(keep)
        columns = [[self.number(value, "%.9g") for value in column[rows]] for column in samples]
        head, times = self._times(rows / RATE)
        cells = [*times, *columns]
        labels, units = [*head, *self.names], [*self._time_units(len(head)), *[self.unit] * len(self.names)]
        if self.words:
            cells.insert(1, ["ok"] * rows.size)
            labels.insert(1, "note")
            units.insert(1, "")
        lines = [*self.preamble, *self._header(labels, units)]
        lines += [self._row(row) for row in zip(*cells, strict=True)]
        text = self.end.join([*lines, *self.footer]) + self.end
        return text.encode(self.encoding)

    def number(self, value: float, form: str) -> str:
        return (form % value).replace(".", self.decimal)

    def _row(self, cells: tuple[str, ...]) -> str:
        quoted = [f'"{cell}"' if self.quotes or (self.delimiter in cell and cell) else cell for cell in cells]
        return self.delimiter.join(quoted) + self.delimiter * self.trailing

    def _header(self, labels: list[str], units: list[str]) -> list[str]:
        form = {
            "[]": "%s [%s]",
            "()": "%s (%s)",
            "{}": "%s {%s}",
            "quoted": "%s, %s",
            "slash": "%s/%s",
            "in": "%s in %s",
        }
        pairs = list(zip(labels, units, strict=True))
        rate = [self.clock] if self.stated else []
        if self.header in form:
            cells = [form[self.header] % pair if pair[1] else pair[0] for pair in pairs]
            if self.header == "slash":
                cells = [
                    f"{name}/({unit})" if "/" in unit else f"{name}/{unit}" if unit else name for name, unit in pairs
                ]
            return [*rate, self._row(tuple(cells))]
        if self.header == "unit row":
            return [*rate, self._row(tuple(labels)), self._row(tuple(units))]
        if self.header == "bracketed unit row":
            return [*rate, self._row(tuple(labels)), self._row(tuple(f"[{unit}]" if unit else "" for unit in units))]
        if self.header == "unit comment":
            return [*rate, "# units: " + ", ".join(unit or "-" for unit in units), self._row(tuple(labels))]
        cells = [f"{name} [{unit}]" if unit else name for name, unit in pairs]
        return [*rate, "# " + self.delimiter.join(cells)]

    def _time_units(self, count: int) -> list[str]:
        return [self.time_unit] if self.clock in ("time", "t", "Zeit", "Timestamp", "Elapsed time") else [""] * count

    def _times(self, time: np.ndarray) -> tuple[list[str], list[list[str]]]:
        if self.stated:
            return [], []
        if self._time_units(0):
            digits = {"s": 6, "ms": 3, "us": 0, "µs": 1, "min": 9, "sec": 4, "h": 11}[self.time_unit]
            return [self.clock], [[self.number(t / TIME_UNITS[self.time_unit], f"%.{digits}f") for t in time]]
        stamps = np.datetime64("2026-01-05T08:00:00") + np.round(time * 1e6).astype("timedelta64[us]")
        iso = [str(stamp) for stamp in stamps]
        days, clocks = [s[:10] for s in iso], [s[11:].ljust(15, "0") if "." in s else s[11:] + ".000000" for s in iso]
        spelled = {
            "iso": [f"{d} {c}" for d, c in zip(days, clocks, strict=True)],
            "iso T": iso,
            "iso zone": [f"{s}+01:00" for s in iso],
            "german": [f"05.01.2026 {c.replace('.', self.decimal)}" for c in clocks],
            "american": [f"1/5/2026 {c} AM" for c in clocks],
            "of day": clocks,
        }
        if self.clock == "date and time":
            return ["Date", "Time"], [days, clocks]
        return ["Time stamp" if self.delimiter != " " else "Timestamp"], [spelled[self.clock]]


def sines(columns: int, size: int, amplitude: float = 1.0) -> np.ndarray:
    """Sines of 10 Hz (column, row), each with a phase of its own."""
    return amplitude * np.sin(20 * np.pi * np.arange(size) / RATE + np.arange(columns)[:, None] + 0.3)


FIELD = {  # the kinds of the field inputs
    "round-brackets.csv": Written(quotes=True, header="()", names=("Acceleration z",)),
    "decimal-comma.csv": Written(";", ","),
    "milli-g.csv": Written(unit="mg"),
    "inches.csv": Written(unit="in/s^2"),
    "latin1.csv": Written(unit="m/s²", encoding="latin-1"),
    "table.txt": Written(),
    "tabs.dat": Written("\t"),
    "unit-row.csv": Written(header="unit row", names=("Z",)),
    "preamble.csv": Written(preamble=("Logger 7", "Serial,0000", "Sample rate,500", ""), footer=("", "End of data")),
    "comment-units.csv": Written(header="unit comment", preamble=("# rate: 500 Hz",)),
    "milliseconds.csv": Written(time_unit="ms"),
    "trailing.csv": Written(trailing=True),
    "timestamps.csv": Written(clock="iso T"),
    "text-column.csv": Written(words=True),
    "utf16.asc": Written("\t", ",", encoding="utf-16"),
    "marked.prn": Written(" ", encoding="utf-8-sig"),
    "old-mac.tab": Written("\t", end="\r"),
    "logger.log": Written(";", end="\r\n", clock="date and time"),
}
assert replace(FIELD["trailing.csv"], trailing=False) == FIELD["table.txt"]
