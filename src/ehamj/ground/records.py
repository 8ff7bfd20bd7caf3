"""Ground motion from a record: seismic formats through ObsPy, and CSV whose header names the units."""

import re
import warnings
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.ground.motion import Motion, Slab, Start
from ehamj.ground.processing import (
    INTEGRATIONS,
    Axis,
    Channel,
    Quantity,
    Record,
    Response,
    Treatment,
    clipped_samples,
    displacement,
    held_frequencies,
)
from ehamj.signals import Array, Faded, Sampled, Signal

if TYPE_CHECKING:
    from obspy import Inventory, Stream, Trace

EXAMPLE = "example:BW.RJOB"
STANDARD_AXES: dict[str, Axis] = {"E": "x", "N": "y", "Z": "z", "x": "x", "y": "y", "z": "z"}
UNITS: dict[str, tuple[Quantity, float]] = {
    "m": ("displacement", 1.0),
    "mm": ("displacement", 1e-3),
    "um": ("displacement", 1e-6),
    "nm": ("displacement", 1e-9),
    "m/s": ("velocity", 1.0),
    "mm/s": ("velocity", 1e-3),
    "um/s": ("velocity", 1e-6),
    "nm/s": ("velocity", 1e-9),
    "m/s^2": ("acceleration", 1.0),
    "mm/s^2": ("acceleration", 1e-3),
    "um/s^2": ("acceleration", 1e-6),
    "g": ("acceleration", 9.80665),
}
"""Units of a CSV column: what it holds, and its SI value. µ is read as u, ² and ** 2 as ^2."""

TIME_UNITS = {"s": 1.0, "ms": 1e-3}
JITTER = 1e-3
"""How far a time may lie from a uniform grid, in steps."""

AxisChoice = dict[str, Axis] | None
QuantityChoice = Literal["auto", "displacement", "velocity", "acceleration"]
GapChoice = Literal["error", "interpolate"]


class RecordGround(Treatment):
    """A rigid slab that moves as a record says, in x, y and z."""

    kind: Literal["record"]
    file: str = Field(
        min_length=1,
        description="record, relative to the scenario's folder: *.csv, anything ObsPy reads (the name may hold "
        f"wildcards, for one file per component), or {EXAMPLE!r}, a real record that ObsPy carries",
    )
    quantity: QuantityChoice = Field(
        "auto",
        description="what the samples are (SI); auto: from the instrument's response or the units in the CSV header",
    )
    inventory: str | None = Field(
        None, description="file with the instrument's response (StationXML, dataless SEED, …)"
    )
    remove_response: bool = Field(True, description="turn counts into motion; false: samples are SI (seismic formats)")
    axes: AxisChoice = Field(
        None,
        description="axis of each component (E, EHE, BW.RJOB..EHE or CSV column), the others are left out; "
        "default: E, N, Z to x, y, z",
    )
    gaps: GapChoice = Field(
        "error", description="what to do about gaps: refuse the record, or fill with straight lines"
    )
    start: float = Field(0.0, ge=0, description="time in the record at which the simulation begins [s]")
    scale: float = Field(1.0, description="factor on the motion [-]")
    fade_in: float = Field(0.0, ge=0, description="time over which the simulation's motion fades in [s]; 0: as taper")

    @model_validator(mode="after")
    def _response_wanted(self) -> Self:
        if self.inventory is not None and not self.remove_response:
            raise ValueError(
                f"inventory = {self.inventory!r} is of no use with remove_response = false; leave one of them out"
            )
        return self

    def read(self, folder: Path) -> Record:
        """The raw record; ``folder`` is where relative names begin."""
        if self.file.lower().endswith(".csv"):
            if self.inventory is not None:
                raise ValueError(f"ground.inventory = {self.inventory!r}: a CSV record has units; leave inventory out")
            return read_csv(folder / self.file, self.axes, self.quantity, self.gaps)
        inventory = None if self.inventory is None else folder / self.inventory
        source = self.file if self.file == EXAMPLE else folder / self.file
        return read_seismic(source, self.axes, self.quantity, self.gaps, inventory, self.remove_response)

    def motion(self, start: Start) -> Motion:
        """Build the motion: at rest at time 0, then what the record says.

        Raises ValueError, naming the key, where the file or a setting does not allow it.
        """
        record = self.read(start.folder)
        self._check(record, start.duration)
        signals: dict[str, Signal] = {}
        notes = [*record.notes]
        for channel in record.channels:
            if np.ptp(channel.samples) == 0:
                notes.append(f"{channel.name} never changes: {channel.axis} is at rest")
                continue
            moved = displacement(channel, self, self.start, start.duration)
            scaled = Sampled(moved.rate, self.scale * moved.values, moved.start)
            signals[channel.axis] = Faded(scaled, self.fade_in or self.taper)
        usable = min(channel.usable for channel in record.channels)
        return Slab(start.positions, signals, (*notes, *self._notes(record)), usable)

    def _check(self, record: Record, duration: float) -> None:
        if self.start + duration > record.duration + 1e-9:
            raise ValueError(
                f"ground.start = {self.start:g} s and the duration, {duration:g} s, ask for "
                f"{self.start + duration:g} s, but the record {record.name} lasts {record.duration:g} s"
            )
        if self.pre_filter is not None and all(channel.response is None for channel in record.channels):
            raise ValueError(f"ground.pre_filter = {list(self.pre_filter)}: only allowed where a response is removed")

    def _notes(self, record: Record) -> list[str]:
        """Processing and limits of ``record`` in plain words."""
        steps = [] if self.detrend == "none" else [f"{self.detrend} trend subtracted (Hann weights)"]
        steps.append(f"faded in and out over {self.taper:g} s at the record's ends")
        if any(channel.response is not None for channel in record.channels):
            band = f"band {list(self.pre_filter)} Hz" if self.pre_filter else "falling from 0.8 to 1 times Nyquist"
            steps.append(f"instrument response removed (water level {self.water_level:g} dB, {band})")
        if self.highpass:
            steps.append(
                f"zero-phase high-pass at {self.highpass:g} Hz (within 0.1 % above {2.4 * self.highpass:g} Hz)"
            )
        times = sorted({INTEGRATIONS[channel.quantity] for channel in record.channels} - {0})
        if times:
            steps.append(f"integrated {' or '.join(('once', 'twice')[n - 1] for n in times)} (in the frequency domain)")
        steps.append(f"resampled to at least {self.rate:g} Hz")
        if self.scale != 1:
            steps.append(f"scaled by {self.scale:g}")
        notes = [f"record {record.name}, in this order: " + ", ".join(steps)]
        notes.append(
            f"the ground starts from rest: its motion fades in over the first {self.fade_in or self.taper:g} s"
        )
        return notes + self._limits(record)

    def _limits(self, record: Record) -> list[str]:
        notes = []
        if 0 < self.highpass * record.duration < 1:
            notes.append(f"record {record.name} resolves nothing below {1 / record.duration:.3g} Hz: it is too short")
        for rate in sorted({channel.rate for channel in record.channels}):
            channels = [channel for channel in record.channels if channel.rate == rate]
            end = channels[0].usable
            if channels[0].response is not None:
                end = min(end, self.band(channels[0])[2])
            whose = "" if len(channels) == len(record.channels) else f" in {', '.join(c.axis for c in channels)}"
            limit = f"record {record.name} ends at {end:g} Hz{whose} (sampled at {rate:g} Hz)"
            notes.append(f"{limit}: bands above {end:g} Hz are undecided")
        for channel in record.channels:
            count = clipped_samples(channel.samples)
            if count:
                notes.append(f"{channel.name} looks clipped: {count} samples stand at its extreme value")
            held = held_frequencies(channel, self)
            if held.size:
                notes.append(
                    f"{channel.name}: the response lies below the water level from {held[0]:.3g} to {held[-1]:.3g} Hz; "
                    "motion there is understated"
                )
        return notes


# --- components, axes and quantities ------------------------------------------------------------------------------


def choose_axes(components: dict[str, tuple[str, ...]], axes: AxisChoice) -> dict[str, Axis]:
    """Axis of each component that is used.

    ``components`` maps each component's full name to all names it answers to; ``axes`` maps names to axes, None for the
    standard ones. Raises ValueError for a component without axis, a name without component, and an axis taken twice.
    """
    known = STANDARD_AXES if axes is None else axes
    chosen: dict[str, Axis] = {}
    for component, names in components.items():
        axis = next((known[name] for name in names if name in known), None)
        if axis is not None:
            chosen[component] = axis
        elif axes is None:
            raise ValueError(
                f"ground.axes does not say which axis {component!r} is; name it, for instance "
                f'axes = {{ {names[-1] or component!r} = "x" }}; else {", ".join(STANDARD_AXES)} are known'
            )
    all_names = {name for names in components.values() for name in names}
    for name in axes or {}:
        if name not in all_names:
            raise ValueError(
                f"ground.axes names {name!r}, which the record does not hold; it holds {', '.join(components)}"
            )
    twice = [axis for axis, count in Counter(chosen.values()).items() if count > 1]
    if twice:
        both = ", ".join(component for component, axis in chosen.items() if axis == twice[0])
        raise ValueError(
            f"ground.axes: {both} are all {twice[0]}; each axis takes one component; choose with ground.axes"
        )
    if not chosen:
        raise ValueError(f"ground.axes = {axes} leaves no component; the record holds {', '.join(components)}")
    return chosen


def agreed_quantity(wanted: QuantityChoice, found: Quantity | None, name: str, remedy: str) -> Quantity:
    """What a channel holds: what the file says (``found``), or what the user says where the file is silent."""
    if found is None and wanted == "auto":
        raise ValueError(
            f"ground.quantity = 'auto', but the file does not say what {name} holds; set displacement, velocity or "
            f"acceleration (samples are then SI), or {remedy}"
        )
    if found is not None and wanted not in ("auto", found):
        raise ValueError(
            f"ground.quantity = {wanted!r}, but the file says that {name} is {found}; use 'auto' or {found!r}"
        )
    return found or wanted  # type: ignore[return-value]


# --- CSV ----------------------------------------------------------------------------------------------------------


class Column(NamedTuple):
    """A CSV column: its name and its unit as written, None where it has none."""

    name: str
    unit: str | None


def parse_header(line: str, delimiter: str = ",") -> list[Column]:
    """Columns of a header such as ``time [s], x [m/s], z [mm/s^2]``; raises ValueError at any other cell."""
    columns = []
    for cell in line.split(delimiter):
        match = re.fullmatch(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\])?\s*", cell)
        if match is None or not match[1]:
            raise ValueError(f"ground.file: CSV header cell {cell.strip()[:40]!r} is not of the form 'name [unit]'")
        columns.append(Column(match[1], None if match[2] is None else match[2].strip()))
    twice = [name for name, count in Counter(column.name for column in columns).items() if count > 1]
    if twice:
        raise ValueError(f"ground.file: the CSV header names {twice[0]!r} more than once")
    return columns


def parse_unit(column: Column) -> tuple[Quantity, float] | None:
    """What ``column`` holds and its unit's SI value, None where no unit is given; raises ValueError if unknown."""
    if column.unit is None:
        return None
    unit = re.sub(r"[µμ]", "u", column.unit.replace(" ", "").replace("²", "^2").replace("**2", "^2"))
    if unit not in UNITS:
        raise ValueError(
            f"ground.file: CSV column {column.name!r} has the unknown unit {column.unit!r}; "
            f"known are {', '.join(UNITS)}"
        )
    return UNITS[unit]


def read_csv(
    path: Path, axes: AxisChoice = None, quantity: QuantityChoice = "auto", gaps: GapChoice = "error"
) -> Record:
    """A CSV record.

    One header line (it may be a comment) names columns and units; then one row per sample. Either a column ``time`` [s]
    or [ms], uniform within 1e-3 of a step, or a comment ``# rate_hz = 1000``. Columns are parted by comma, semicolon or
    tab. Raises ValueError where the file breaks that.
    """
    columns, table, rate_hz = _csv_table(path)
    names = [column.name for column in columns]
    clocks = [index for index, name in enumerate(names) if name.lower() in ("time", "t")]
    if bool(clocks) == (rate_hz is not None):
        both = "neither" if rate_hz is None else "both"
        raise ValueError(f"ground.file = {path.name!r}: give a column 'time [s]' or a line '# rate_hz = …', not {both}")
    notes: list[str] = []
    if clocks:
        rate_hz, table, notes = _uniform(table, columns[clocks[0]], clocks[0], path, gaps)
    assert rate_hz is not None
    chosen = choose_axes({name: (name,) for i, name in enumerate(names) if i not in clocks}, axes)
    channels = []
    for name, axis in chosen.items():
        column = columns[names.index(name)]
        unit = parse_unit(column)
        holds = agreed_quantity(quantity, unit and unit[0], f"column {name!r}", "write the unit as 'x [m/s]'")
        channels.append(Channel(axis, name, rate_hz, holds, table[:, names.index(name)] * (unit[1] if unit else 1.0)))
    notes.insert(0, _summary(path.name, channels))
    return Record(path.name, tuple(channels), tuple(notes))


def _csv_table(path: Path) -> tuple[list[Column], Array, float | None]:
    """Columns, numbers (row, column) and the stated rate [Hz] of a CSV file."""
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise ValueError(f"ground.file = {path.name!r} cannot be read: {error.strerror} ({path})") from error
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")  # spreadsheets on Windows write µ and ² like this
    lines = text.splitlines()
    rate_hz, header, header_at = None, None, 0
    for number, line in enumerate(lines):
        stated = re.fullmatch(r"#\s*rate_hz\s*[=:]\s*(\S+)\s*", line)
        if stated:
            rate_hz = _positive_rate(stated[1])
        elif line.lstrip().startswith("#"):
            header, header_at = line.lstrip().lstrip("#"), number + 1
        elif line.strip():
            if not _is_number(re.split(r"[,;\t]", line)[0]):
                header, header_at = line, number + 1
            break
    if header is None:
        raise ValueError(
            f"ground.file = {path.name!r}: the first line must name columns and units, as in 'time [s], z [m/s]'"
        )
    delimiter = next((mark for mark in "\t;" if mark in header), ",")
    columns = parse_header(header, delimiter)
    rows = [(n, line) for n, line in enumerate(lines[header_at:], header_at + 1) if line.split("#")[0].strip()]
    try:
        table = np.loadtxt([line for _, line in rows], delimiter=delimiter, ndmin=2) if rows else np.empty((0, 0))
    except ValueError:
        table = np.empty((0, 0))
    if table.shape[1] != len(columns):
        raise ValueError(f"ground.file = {path.name!r}: " + _csv_fault(rows, len(columns), delimiter))
    return columns, table, rate_hz


def _positive_rate(text: str) -> float:
    rate = float(text) if _is_number(text) else 0.0
    if not 0.0 < rate < np.inf:
        raise ValueError(f"ground.file: rate_hz = {text} must be a positive number, in Hz")
    return rate


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _csv_fault(rows: Sequence[tuple[int, str]], width: int, delimiter: str) -> str:
    """What is wrong with the first bad row."""
    for number, line in rows:
        cells = line.split("#")[0].split(delimiter)
        if len(cells) != width:
            return f"line {number} has {len(cells)} cells where the header has {width}; the file may be truncated"
        for cell in cells:
            if not _is_number(cell):
                return f"line {number} holds {cell.strip()!r}, which is not a number"
    return "it holds no samples"


def _uniform(table: Array, clock: Column, at: int, path: Path, gaps: GapChoice) -> tuple[float, Array, list[str]]:
    """Rate [Hz], the table on a uniform grid of times, and remarks on gaps."""
    if clock.unit not in TIME_UNITS:
        raise ValueError(f"ground.file: CSV column {clock.name!r} has the unit {clock.unit!r}; known are s and ms")
    time = table[:, at] * TIME_UNITS[clock.unit]
    forward = np.diff(time)
    rising = (forward > 0) & np.isfinite(forward)
    if time.size < 2 or not rising.all():
        row = int(np.argmin(rising)) + 2 if time.size > 1 else 1
        raise ValueError(f"ground.file = {path.name!r}: time must rise from row to row; it does not at sample {row}")
    index = np.concatenate([[0.0], np.cumsum(np.maximum(1.0, np.round(forward / np.median(forward))))])
    step = (time[-1] - time[0]) / index[-1]
    worst = int(np.argmax(np.abs(time - time[0] - index * step)))
    jitter = abs(time[worst] - time[0] - index[worst] * step) / step
    if jitter > JITTER:
        raise ValueError(
            f"ground.file = {path.name!r}: sampling is not uniform: sample {worst + 1} is {jitter:.2g} steps "
            f"off its place, {JITTER:g} are allowed; resample it, or state '# rate_hz = …' instead of the times"
        )
    missing = int(index[-1]) + 1 - time.size
    if not missing:
        return 1.0 / step, table, []
    holes = int(np.sum(np.diff(index) > 1))
    note = _filled(path.name, holes, missing * step, time.size * step, gaps)
    grid = np.arange(int(index[-1]) + 1)
    filled = np.column_stack([np.interp(grid, index, column) for column in table.T])
    return 1.0 / step, filled, [note]


def _filled(name: str, holes: int, missing: float, recorded: float, gaps: GapChoice) -> str:
    """The remark on ``missing`` seconds in so many holes; raises ValueError where they may not be filled."""
    whole = f"{holes} gap{'s' if holes > 1 else ''}, {missing:.4g} s in total"
    if missing > recorded:
        raise ValueError(f"ground.file = {name!r} has {whole}, more than it holds ({recorded:.4g} s); cut it")
    if gaps == "error":
        raise ValueError(
            f'ground.file = {name!r} has {whole}; set ground.gaps = "interpolate" to fill with straight lines'
        )
    return f"record {name} has {whole}, filled with straight lines"


# --- seismic formats ----------------------------------------------------------------------------------------------


def read_seismic(
    source: Path | str,
    axes: AxisChoice = None,
    quantity: QuantityChoice = "auto",
    gaps: GapChoice = "error",
    inventory: Path | None = None,
    remove_response: bool = True,
) -> Record:
    """A record in any format ObsPy reads; ``source`` is a path, whose last part may hold wildcards, or ``EXAMPLE``.

    Counts stay counts: each channel carries the response that the processing divides by. Raises ValueError for a file
    that is missing, truncated or damaged, for gaps, overlaps, several stations, and a missing response.
    """
    label = str(source) if isinstance(source, str) else source.name
    stream, responses = _open(source, inventory)
    names: dict[str, tuple[str, ...]] = {
        trace.id: (trace.id, trace.stats.channel, trace.stats.channel[-1:]) for trace in stream
    }
    chosen = choose_axes(names, axes)
    stations = sorted({name.rsplit(".", 2)[0] for name in chosen})
    if len(stations) > 1:
        raise ValueError(
            f"ground.file = {label!r} holds several stations: {', '.join(stations)}; choose with ground.axes"
        )
    stream.traces = [trace for trace in stream if trace.id in chosen]
    notes = _join(stream, label, gaps)
    beginning = max(trace.stats.starttime for trace in stream)
    channels = []
    for trace in stream:
        found: Quantity | None = None
        response: Response | None = None
        if remove_response:
            found, response = _response(trace, responses)
        holds = agreed_quantity(quantity, found, trace.id, "let ground.remove_response find out")
        stats = trace.stats
        samples, time = np.asarray(trace.data, float), float(stats.starttime - beginning)
        channels.append(Channel(chosen[trace.id], trace.id, stats.sampling_rate, holds, samples, time, response))
        if not remove_response and stats.calib != 1:
            notes.append(
                f"{trace.id} states a calibration factor of {stats.calib:g}, which is not applied (ground.scale can)"
            )
    name = stations[0].strip(".") or label
    record = Record(name, tuple(channels), (_summary(label, channels), *_differences(channels), *notes))
    if record.duration <= 0:
        raise ValueError(f"ground.file = {label!r}: its channels have no time in common")
    return record


def _open(source: Path | str, inventory: Path | None) -> tuple["Stream", "Inventory | None"]:
    """The traces of all files and the responses."""
    import obspy

    if isinstance(source, str):
        return obspy.read(), obspy.read_inventory() if inventory is None else _open_inventory(inventory)
    paths = [source] if source.is_file() else sorted(source.parent.glob(source.name))
    if not paths:
        raise ValueError(f"ground.file = {source.name!r}: there is no such file in {source.parent}")
    stream = obspy.Stream()
    for path in paths:
        stream += _open_file(path)
    return stream, None if inventory is None else _open_inventory(inventory)


def _open_file(path: Path) -> "Stream":
    import obspy
    from obspy.io.mseed import InternalMSEEDWarning
    from obspy.io.mseed.util import get_record_information

    try:
        # ObsPy only warns of a record that breaks off or fails its checksum and leaves the rest out.
        with warnings.catch_warnings():
            warnings.simplefilter("error", InternalMSEEDWarning)
            stream = obspy.read(str(path))
        if stream[0].stats._format == "MSEED":
            # Some records that break off go without a warning, so see whether they fill the file.
            offset, size = 0, path.stat().st_size
            while size % 128 == 0 and offset < size:
                information = get_record_information(str(path), offset)
                offset += information["record_length"] * (
                    1 if information["excess_bytes"] else information["number_of_records"]
                )
            if size % 128 or offset > size:
                raise ValueError("its last record is truncated")
    except Exception as error:  # each of ObsPy's readers raises what it likes
        raise ValueError(
            f"ground.file = {path.name!r} cannot be read, neither by ObsPy nor as *.csv; it may be truncated "
            f"or damaged: {error}"
        ) from error
    for trace in stream:
        if trace.data.dtype.kind not in "iuf":
            raise ValueError(f"ground.file = {path.name!r}: channel {trace.id} holds text or the like, not samples")
    return stream


def _open_inventory(path: Path) -> "Inventory":
    import obspy

    if not path.is_file():
        raise ValueError(f"ground.inventory = {path.name!r}: there is no such file in {path.parent}")
    try:
        return obspy.read_inventory(str(path))
    except Exception as error:  # each of ObsPy's readers raises what it likes
        raise ValueError(f"ground.inventory = {path.name!r} cannot be read by ObsPy: {error}") from error


def _join(stream: "Stream", label: str, gaps: GapChoice) -> list[str]:
    """Make one trace per channel, in place; remarks on gaps that were filled."""
    try:
        stream.merge(method=-1)
        holes = stream.get_gaps()
        overlaps = [hole for hole in holes if hole[6] < 0]
        if overlaps:
            raise ValueError(f"traces of {'.'.join(overlaps[0][:4])} overlap by {-overlaps[0][6]:.4g} s")
        if not holes:
            return []
    except Exception as error:  # ObsPy raises Exception itself, such as for rates that differ within a channel
        raise ValueError(f"ground.file = {label!r}: {error}; each channel must be one trace") from error
    recorded = sum(trace.stats.npts * trace.stats.delta for trace in stream)
    note = _filled(label, len(holes), sum(hole[6] for hole in holes), recorded, gaps)
    stream.merge(method=1, fill_value="interpolate")
    return [note]


def _response(trace: "Trace", inventory: "Inventory | None") -> tuple[Quantity, Response]:
    """What the instrument senses, and its response in counts per SI unit of that."""
    if inventory is None and "response" not in trace.stats:
        raise ValueError(
            f"ground.inventory is missing, and the file has no response of {trace.id}; give a file with it, or set "
            "ground.remove_response = false and ground.quantity for samples in SI"
        )
    try:
        found = trace.stats.response if inventory is None else inventory.get_response(trace.id, trace.stats.starttime)
    except Exception as error:  # ObsPy raises Exception itself
        raise ValueError(f"ground.inventory has no response of {trace.id} at {trace.stats.starttime}") from error
    stated = (found.instrument_sensitivity, *found.response_stages)
    units = next((str(part.input_units) for part in stated if part is not None and part.input_units), "")
    per = re.sub(r"\*\*|\^|[()\s]", "", units.upper()).replace("SEC", "S").replace("S/S", "S2")
    kind = re.fullmatch(r"[NUMC]?M(|/S|/S2)", per)
    if kind is None:
        raise ValueError(f"ground.inventory: {trace.id} senses {units!r}; known are M, M/S and M/S**2")
    quantity: Quantity = {"": "displacement", "/S": "velocity", "/S2": "acceleration"}[kind[1]]  # type: ignore[assignment]
    output = {"displacement": "DISP", "velocity": "VEL", "acceleration": "ACC"}[quantity]

    def evaluate(frequency: Array) -> np.ndarray:
        try:
            return found.get_evalresp_response_for_frequencies(frequency, output=output)
        except Exception as error:  # evalresp raises what it likes
            raise ValueError(f"ground.inventory: the response of {trace.id} cannot be evaluated: {error}") from error

    return quantity, evaluate


def _summary(label: str, channels: Sequence[Channel]) -> str:
    parts = (f"{c.axis} from {c.name} ({c.quantity}, {c.end - c.time:g} s at {c.rate:g} Hz)" for c in channels)
    return f"record {label}: " + "; ".join(parts)


def _differences(channels: Sequence[Channel]) -> list[str]:
    """Remarks where channels differ in rate or span."""
    notes = []
    if len({channel.rate for channel in channels}) > 1:
        notes.append("sampling rates differ: " + ", ".join(f"{c.axis} {c.rate:g} Hz" for c in channels))
    late, early = (max(values) - min(values) for values in ([c.time for c in channels], [c.end for c in channels]))
    if max(late, early) * min(channel.rate for channel in channels) > 1.5:
        notes.append(f"channels begin up to {late:g} s and end up to {early:g} s apart; the common part is used")
    return notes
