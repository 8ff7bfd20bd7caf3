"""What the viewer shows when it opens the recording."""

import math
from collections.abc import Iterable, Mapping

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ehamj.replay import attenuation
from ehamj.replay.names import TIMELINE, entity
from ehamj.replay.plots import Series
from ehamj.result import Result

SPEEDS = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
WATCHABLE = 1.0
"""Frequency at which the eye follows a motion well [Hz]."""

WINDOW = 5.0
"""The rolling plot shows this much viewing time before and after the cursor [s]."""

EYE = np.array([0.86, -0.80, 0.34])
"""Direction from the machine to the eye."""


def playback_speed(frequency: float) -> float:
    """Simulated seconds per second of viewing that make motion of this frequency [Hz] watchable."""
    return next((speed for speed in SPEEDS if frequency * speed <= 1.5 * WATCHABLE), SPEEDS[-1])


def make_blueprint(
    results: Mapping[str, Result],
    series: Mapping[str, Mapping[str, Series]],
    axes: Iterable[str],
    factor: float,
    speed: float,
) -> rrb.Blueprint:
    """Layout of the viewer.

    Args:
        results: what is shown, by label.
        series: the plots of each result.
        axes: axes that have a chart of attenuation.
        factor: exaggeration of the motions.
        speed: playback speed, simulated seconds per second.
    """
    scenes = [_scene(label, result, factor) for label, result in results.items()]
    rolling = _plot("vertical velocity, floor and machine [µm/s]", series, ("ground_vertical", "cg_vertical"), WINDOW * speed)
    left = rrb.Vertical(
        rrb.Grid(*scenes, grid_columns=min(len(scenes), 3)) if len(scenes) > 1 else scenes[0], rolling, row_shares=[5, 3]
    )
    pages: list[rrb.View | rrb.Container] = [rrb.TextDocumentView(origin="/about", name="summary")]
    charts = [_chart(axis) for axis in axes]
    if charts:
        pages.append(rrb.Tabs(*charts, name="attenuation"))
    pages.append(_motion(series))
    pages += [_isolators(label, plots) for label, plots in series.items()]
    right = rrb.Tabs(*pages, active_tab=0)
    return rrb.Blueprint(
        rrb.Horizontal(left, right, column_shares=[5, 3]),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, playback_speed=speed, play_state="playing", loop_mode="all"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_views=False,
        auto_layout=False,
    )


def _scene(label: str, result: Result, factor: float) -> rrb.Spatial3DView:
    size = np.array(result.scenario.machine.size)
    target = np.array([0.0, 0.0, 0.36 * size[2]])
    distance = 1.12 * math.hypot(*size)
    return rrb.Spatial3DView(
        origin=entity(label, "world"),
        name=f"{label}: motion × {factor:g}",
        background=rrb.Background(kind="gradientdark"),
        line_grid=False,
        eye_controls=rrb.EyeControls3D(
            kind="orbital", position=target + distance * EYE / np.linalg.norm(EYE), look_target=target, eye_up=[0, 0, 1]
        ),
    )


def _plot(
    name: str, series: Mapping[str, Mapping[str, Series]], plots: tuple[str, ...], window: float | None = None
) -> rrb.TimeSeriesView:
    """A view over some plots of some results; with a window it scrolls, otherwise it shows the whole run."""
    contents = [entity(label, "plots", plot) for plot in plots for label in series if plot in series[label]]
    if window is None:
        return rrb.TimeSeriesView(origin="/", contents=contents, name=name)
    boundaries = [rr.TimeRangeBoundary.cursor_relative(nanos=round(sign * window * 1e9)) for sign in (-1, 1)]
    return rrb.TimeSeriesView(
        origin="/", contents=contents, name=name, axis_x=rrb.TimeAxis(view_range=rr.TimeRange(*boundaries))
    )


def _chart(axis: str) -> rrb.Spatial2DView:
    left, right, above, below = attenuation.MARGINS
    return rrb.Spatial2DView(
        origin=entity(attenuation.ROOT, axis),
        name=attenuation.TITLES.get(axis, axis),
        background=rrb.Background(color=(13, 16, 17)),
        visual_bounds=rrb.VisualBounds2D(
            x_range=(-left, attenuation.WIDTH + right), y_range=(-above, attenuation.HEIGHT + below)
        ),
    )


def _motion(series: Mapping[str, Mapping[str, Series]]) -> rrb.Vertical:
    return rrb.Vertical(
        _plot("vertical velocity, whole run [µm/s]", series, ("ground_vertical", "cg_vertical")),
        _plot("horizontal velocity [µm/s]", series, ("ground_horizontal", "cg_horizontal")),
        _plot("rotation of the machine [µrad]", series, ("rotation",)),
        name="motion",
    )


def _isolators(label: str, plots: Mapping[str, Series]) -> rrb.Vertical:
    """Strokes, commands, spools and pressures of one result; without what never moves."""
    names = {
        "stroke": "stroke, from equilibrium [µm]",
        "command": "valve command [V]",
        "spool": "spool, of its stroke [%]",
        "pressure": "chamber pressure, absolute [bar]",
    }
    views = [_plot(f"{label}: {title}", {label: plots}, (name,)) for name, title in names.items() if not plots[name].at_rest]
    return rrb.Vertical(*views, name=f"isolators: {label}")
