"""What the viewer shows when it opens the recording."""

import math
from collections.abc import Iterable, Mapping
from typing import Final

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import ArrayLike

from ehamj.plant.machine import Machine
from ehamj.replay import attenuation, spectrogram
from ehamj.replay.marks import FAULT_LOG
from ehamj.replay.plots import NEGLIGIBLE, Plot
from ehamj.replay.recording import TIMELINE, entity
from ehamj.replay.spectrogram import Heat
from ehamj.result import Result

VELOCITIES: Final = ("vertical", "along_x", "along_y")
ROTATIONS: Final = ("roll", "pitch", "yaw")

SPEEDS: Final = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
WATCHABLE = 1.5
"""Highest frequency at which the eye follows a motion well [Hz]."""

WINDOW = 3.0
"""The rolling plot shows this much viewing time before and after the cursor [s]."""

EYE: Final = (0.86, -0.80, 0.25)
"""Direction from the machine to the eye."""

BACKGROUND: Final = (38, 44, 51)
CHART_BACKGROUND: Final = (13, 16, 17)


def playback_speed(frequency: float) -> float:
    """Simulated seconds per second of viewing that make motion of this frequency [Hz] watchable."""
    return next((speed for speed in SPEEDS if frequency * speed <= WATCHABLE), SPEEDS[-1])


def make_blueprint(
    results: Mapping[str, Result],
    compared: Mapping[str, Plot],
    isolators: Mapping[str, Mapping[str, Plot]],
    axes: Iterable[str],
    heats: Mapping[str, Heat],
    factor: float,
    speed: float,
) -> rrb.Blueprint:
    """Layout of the viewer.

    Args:
        results: what is shown, by label.
        compared: the plots of floor and machine.
        isolators: the isolators' plots of each result, by groups of mounts.
        axes: axes that have a chart of attenuation.
        heats: levels over time by axis.
        factor: exaggeration of the motions.
        speed: playback speed, simulated seconds per second.
    """
    columns = len(results) if len(results) <= 3 else math.ceil(math.sqrt(len(results)))
    away = 1.7 if len(results) == 3 else 1.12  # three in a row are narrower than high
    scenes = [
        scene_view(label, f"{label}: motion × {factor:g}", result.scenario.machine, EYE, away)
        for label, result in results.items()
    ]
    machines = rrb.Grid(*scenes, grid_columns=columns) if columns > 1 else scenes[0]
    velocities, rotations = (_moving([compared[name] for name in names]) for names in (VELOCITIES, ROTATIONS))
    first = velocities[0] if velocities else compared[VELOCITIES[0]]
    rolling = _plot(first, window=WINDOW * speed, legend=True, title="floor and machine")
    pages: list[rrb.View | rrb.Container] = [rrb.TextDocumentView(origin="/about", name="summary")]
    charts = [_chart(axis) for axis in axes]
    if charts:
        pages.append(rrb.Tabs(*charts, name="attenuation"))
    if heats:
        pages.append(rrb.Tabs(*(_heat(axis, heat) for axis, heat in heats.items()), name="levels over time"))
    pages += _page("velocity", velocities, "whole run") + _page("rotation", rotations, "whole run")
    for name, members in (("isolators", ("stroke", "pressure_1", "pressure_2")), ("valves", ("command", "spool"))):
        shown = [
            page
            for label, plots in isolators.items()
            for page in _page(label, [plots[member] for member in members if plots[member].peak > NEGLIGIBLE])
        ]
        if shown:
            pages.append(rrb.Tabs(*shown, name=name) if len(shown) > 1 else rrb.Vertical(*shown, name=name))
    left = rrb.Vertical(machines, rolling, row_shares=[3, 2])
    if any(result.summary.fault for result in results.values()):
        pages.append(rrb.TextLogView(origin=entity(FAULT_LOG), name="faults"))
    return laid_out(rrb.Horizontal(left, rrb.Tabs(*pages, active_tab=0), column_shares=[3, 2]), speed)


def laid_out(content: rrb.Container, speed: float, timeline: str = TIMELINE) -> rrb.Blueprint:
    """The blueprint of a window that shows this and plays it over and over; every panel is folded away."""
    panel = rrb.TimePanel(
        state="collapsed", timeline=timeline, playback_speed=speed, play_state="playing", loop_mode="all"
    )
    folded = (rrb.BlueprintPanel(state="collapsed"), rrb.SelectionPanel(state="collapsed"))
    return rrb.Blueprint(content, panel, *folded, auto_views=False, auto_layout=False)


def scene_view(
    label: str, title: str, machine: Machine, eye: ArrayLike, away: float, lower: float = 0.0
) -> rrb.Spatial3DView:
    """A scene with its machine in the middle.

    Args:
        label: of the scene.
        title: of the view.
        machine: what is seen.
        eye: direction from the machine to the eye.
        away: distance of the eye over the machine's diagonal.
        lower: how far below the usual point the eye looks [m].
    """
    size, towards = np.array(machine.size), np.asarray(eye)
    target = np.array([0.0, 0.0, 0.36 * size[2] - lower])
    position = target + away * math.hypot(*size) * towards / np.linalg.norm(towards)
    return rrb.Spatial3DView(
        origin=entity(label, "world"),
        name=title,
        background=rrb.Background(color=BACKGROUND),
        line_grid=False,
        eye_controls=rrb.EyeControls3D(kind="orbital", position=position, look_target=target, eye_up=[0, 0, 1]),
    )


def _plot(plot: Plot, window: float | None = None, legend: bool = False, title: str = "") -> rrb.TimeSeriesView:
    """A view of a plot; with a window it scrolls with the cursor, otherwise it shows the whole run."""
    axis = None
    if window is not None:
        ends = (rr.TimeRangeBoundary.cursor_relative(nanos=round(sign * window * 1e9)) for sign in (-1, 1))
        axis = rrb.TimeAxis(view_range=rr.TimeRange(*ends))
    return rrb.TimeSeriesView(
        origin="/",
        contents=[trace.path for trace in plot.traces],
        name=f"{plot.title}, {title}" if title else plot.title,
        axis_x=axis,
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend),
    )


def _chart(axis: str) -> rrb.Spatial2DView:
    left, right, above, below = attenuation.MARGINS
    return rrb.Spatial2DView(
        origin=entity(attenuation.ROOT, axis),
        name=attenuation.TITLES.get(axis, axis),
        background=rrb.Background(color=CHART_BACKGROUND),
        visual_bounds=rrb.VisualBounds2D(
            x_range=(-left, attenuation.WIDTH + right), y_range=(-above, attenuation.HEIGHT + below)
        ),
    )


def _heat(axis: str, heat: Heat) -> rrb.Spatial2DView:
    left, right, above, below = spectrogram.MARGINS
    return rrb.Spatial2DView(
        origin=entity(spectrogram.ROOT, axis),
        name=attenuation.TITLES.get(axis, axis),
        background=rrb.Background(color=spectrogram.PAPER),
        visual_bounds=rrb.VisualBounds2D(
            x_range=(-left, spectrogram.WIDTH + right), y_range=(-above, heat.tall + below)
        ),
    )


def _moving(plots: list[Plot]) -> list[Plot]:
    """Those of some plots of one unit in which more is to be seen than rounding."""
    least = max([NEGLIGIBLE, *(1e-5 * plot.peak for plot in plots)])
    return [plot for plot in plots if plot.peak > least]


def _page(name: str, plots: list[Plot], title: str = "") -> list[rrb.Vertical]:
    """A page of plots, or none; they share their colours, so that one legend does."""
    views = [_plot(plot, legend=index == 0, title=title) for index, plot in enumerate(plots)]
    return [rrb.Vertical(*views, name=name)] if views else []
