"""Time histories: which channels are shown, in which units and colours, and how a long run is thinned."""

from dataclasses import dataclass

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from ehamj.layout import MOUNTS
from ehamj.replay.names import GROUND_COLOR, MOUNT_COLORS, Array, Color, entity, nanoseconds, time_column
from ehamj.result import Result

MOST_ROWS = 200_000
"""Rows of a plot above which the envelope is drawn in place of every sample."""


@dataclass(frozen=True)
class Series:
    """The lines of one plot of one result: names with units, colours, values (n, line)."""

    names: tuple[str, ...]
    colors: tuple[Color, ...]
    values: Array
    width: float = 1.0

    @property
    def at_rest(self) -> bool:
        """Whether nothing happens on any line."""
        return not np.any(self.values)


def series_of(result: Result, label: str, color: Color) -> dict[str, Series]:
    """What is plotted of a result, by plot.

    Motions and strokes count from the equilibrium, which is the first row. Velocities are in µm/s, rotations in µrad,
    strokes in µm, spools in % of their stroke, commands in V, pressures (absolute) in bar.
    """
    data = {str(name): variable.values for name, variable in result.dataset.data_vars.items()}
    ground, cg = 1e6 * data["ground_velocity"].mean(axis=1), 1e6 * data["cg_velocity"]
    rotation, stroke = (1e6 * (data[name] - data[name][:1]) for name in ("machine_displacement", "stroke"))
    full = np.array([actuator.spool_stroke for actuator in result.scenario.plant.actuators])
    pressure = 1e-5 * data["chamber_pressure"].reshape(len(cg), -1)
    light, dark = _tint(color, 1.35), _tint(color, 0.75)
    chambers = [f"{mount} chamber {chamber} [bar]" for mount in MOUNTS for chamber in (1, 2)]
    shades = tuple(_tint(mount, shade) for mount in MOUNT_COLORS for shade in (1.0, 0.6))
    return {
        "ground_vertical": Series(("ground z [µm/s]",), (GROUND_COLOR,), ground[:, 2:]),
        "cg_vertical": Series((f"{label}: CG z [µm/s]",), (color,), cg[:, 2:], 1.5),
        "ground_horizontal": Series(
            ("ground x [µm/s]", "ground y [µm/s]"), (_tint(GROUND_COLOR, 1.3), _tint(GROUND_COLOR, 0.7)), ground[:, :2]
        ),
        "cg_horizontal": Series((f"{label}: CG x [µm/s]", f"{label}: CG y [µm/s]"), (light, dark), cg[:, :2], 1.5),
        "rotation": Series((f"{label}: rx [µrad]", f"{label}: ry [µrad]"), (light, dark), rotation[:, 3:5], 1.5),
        "stroke": Series(tuple(f"{mount} [µm]" for mount in MOUNTS), MOUNT_COLORS, stroke),
        "command": Series(tuple(f"{mount} [V]" for mount in MOUNTS), MOUNT_COLORS, data["valve_command"]),
        "spool": Series(tuple(f"{mount} [%]" for mount in MOUNTS), MOUNT_COLORS, 100.0 * data["spool"] / full),
        "pressure": Series(tuple(chambers), shades, pressure),
    }


def log_series(recording: rr.RecordingStream, label: str, time: Array, series: dict[str, Series]) -> None:
    """Log a result's plots, one entity each with a vector per row.

    Args:
        recording: where to.
        label: the result's name, first part of every path.
        time: time of each row [s].
        series: the plots, from `series_of`.
    """
    stamps = nanoseconds(time)
    for name, lines in series.items():
        path = entity(label, "plots", name)
        # Zoomed out, several rows share a pixel: the default draws their average, which hides peaks.
        style = rr.SeriesLines(
            names=lines.names, colors=lines.colors, widths=[lines.width] * len(lines.names), aggregation_policy="minmax"
        )
        recording.log(path, style, static=True, strict=True)
        if not len(stamps):
            continue
        kept, values = thinned(stamps, lines.values)
        # Rounded to single precision, which no eye can tell apart, the file compresses to four fifths.
        rounded = values.astype(np.float32).astype(np.float64)
        columns = rr.Scalars.columns(scalars=rounded.ravel()).partition([values.shape[1]] * len(values))
        recording.send_columns(path, [time_column(kept)], columns, strict=True)


def thinned(stamps: NDArray[np.int64], values: Array) -> tuple[NDArray[np.int64], Array]:
    """At most `MOST_ROWS` rows that keep every peak: lowest and highest value of each line per block of rows."""
    size = -(-2 * len(values) // MOST_ROWS)
    if len(values) <= MOST_ROWS:
        return stamps, values
    starts = np.arange(0, len(values), size)
    middles = np.minimum(starts + size // 2, len(values) - 1)
    low, high = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    order = np.column_stack([stamps[starts], stamps[middles]]).ravel()
    pairs = np.stack([low, high], axis=1).reshape(-1, values.shape[1])
    kept = np.concatenate([[True], np.diff(order) > 0])  # a last block of one row has one stamp
    return order[kept], pairs[kept]


def _tint(color: Color, factor: float) -> Color:
    red, green, blue = (min(255, round(factor * part)) for part in color)
    return red, green, blue
