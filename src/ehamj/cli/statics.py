"""The command that shows what each mount carries."""

from typing import Annotated

import numpy as np
import typer

from ehamj.arrays import Array
from ehamj.cli.frame import Command, Json, ScenarioName, Set, app
from ehamj.cli.printing import print_json, print_table, say
from ehamj.pages.words import NEGLIGIBLE, number
from ehamj.plant.axes import DOFS
from ehamj.plant.layout import MOTION_NAMES
from ehamj.scenario.load import load_scenario
from ehamj.views.statics import GOALS, StaticLoads, static_loads

ROUNDING = 1e-6
"""Share of the weight below which a load is none."""

Goal = Annotated[
    str | None,
    typer.Option(
        metavar="GOAL", help=f"Also the shims that level it: {'; '.join(f'{k}: {v}' for k, v in GOALS.items())}."
    ),
]


@app.command(cls=Command)
def statics(
    scenario: ScenarioName = "recorded", overrides: Set = None, shims: Goal = None, as_json: Json = False
) -> None:
    """What each mount carries at rest, how the machine stands, what is actuated, and the shims that level it.

    Forces are those on valves centred and ground at zero: along a mount's direction by membrane and oil, across it by
    its lateral membrane and the guide of its plate. Shims are `mount.height` of the scenario.
    """
    loads = static_loads(load_scenario(scenario, overrides or ()))
    heights = None if shims is None else loads.shims(shims)
    if as_json:
        print_json(loads.to_dict() | ({} if heights is None else {"shims": _by_mount(loads, heights)}))
        return
    _print(loads, heights, shims)


def _by_mount(loads: StaticLoads, heights: Array) -> dict[str, float]:
    return dict(zip(loads.plant.mounts, heights.tolist(), strict=True))


def _shown(value: float) -> str:
    """To four digits; what is rounding is nothing."""
    return number(0.0 if abs(value) < NEGLIGIBLE else float(value), 4)


def _print(loads: StaticLoads, heights: Array | None, goal: str | None) -> None:
    plant, across = loads.plant, np.linalg.norm(loads.across + loads.guided, axis=1)
    upward = loads.along * np.array(plant.directions)[:, 2] + (loads.across + loads.guided)[:, 2]
    columns: dict[str, Array] = {
        "along [N]": loads.along,
        "share %": 100.0 * upward / loads.weight if loads.weight else 0.0 * upward,
        "across [N]": np.where(across < ROUNDING * loads.weight, 0.0, across),
        "stroke [µm]": 1e6 * loads.stroke,
        "shim [µm]": 1e6 * np.array(plant.heights),
    }
    if heights is not None:
        columns[f"{goal}\n[µm]"] = 1e6 * heights
    rows = [[name, *(_shown(column[k]) for column in columns.values())] for k, name in enumerate(plant.mounts)]
    print_table(f"machine and plates weigh {number(loads.weight, 5)} N; at rest", ["mount", *columns], rows)
    least = ROUNDING * np.abs(loads.displacement).max()
    moved = [
        f"{dof} {_shown(1e6 * value)} {'µrad' if dof[0] == 'r' else 'µm'}"
        for dof, value in zip(DOFS, loads.displacement, strict=True)
        if abs(value) > least
    ]
    say(f"stands at {', '.join(moved) or 'its place'}; tilt {_shown(1e6 * loads.tilt)} µrad")
    layout = plant.layout
    idle = [motion for motion in MOTION_NAMES.values() if motion not in layout.motions]
    said = f"actuated: {', '.join(layout.motions) or 'none'}; not: {', '.join(idle) or 'none'}"
    stress = f"; forces that move nothing: {', '.join(layout.stress_names)}" if layout.stress_names else ""
    say(said + stress)
