"""Unequal loads: the centre of gravity beside the middle of the mounts."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.designs.designs import Designs
from ehamj.designs.many import floor_response, modes_of
from ehamj.errors import InputError
from ehamj.linear.machine import linear_model
from ehamj.plant.mounts import MOUNTS
from ehamj.plots.charts import Line, map_chart
from ehamj.scenario.model import Scenario
from ehamj.studies.failed import static_forces
from ehamj.studies.outcome import Drawing, Outcome, Progress, labelled, silent
from ehamj.studies.variants import positions, resized, still

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


@dataclass(frozen=True)
class UnequalStudy:
    """Offsets of the CG, as shares of half the mounts' distances in x and y.

    Raises:
        InputError: if the reach is not positive, or there is no gravity.
    """

    scenario: Scenario
    reach: float = 1.1
    points: int = 45
    frequency: tuple[float, float] = (1.0, 100.0)
    """Range in which rotations by a heaving floor are looked for [Hz]."""
    confirmed: int = 20
    """Random offsets whose loads are computed by the simulator's own equilibrium."""

    def __post_init__(self) -> None:
        if self.scenario.gravity == 0.0:
            raise InputError(
                "gravity = 0 m/s²: must be positive for this study, since nothing loads the mounts without it"
            )
        if not 0.0 < self.reach < np.inf:
            raise InputError(f"reach = {self.reach!r}: must be positive and finite")


def loads_map(study: UnequalStudy) -> xr.Dataset:
    """Over ``y`` and ``x`` of the CG [m]: load of each mount [N], turn by a heaving floor [rad/m], lowest mode [Hz]."""
    half = 0.5 * np.ptp(positions(study.scenario), axis=0)
    centre = positions(study.scenario).mean(axis=0)
    x, y = (c + study.reach * h * np.linspace(-1.0, 1.0, study.points) for c, h in zip(centre, half, strict=True))
    found = _offsets(study, xr.DataArray(y, dims="y"), xr.DataArray(x, dims="x"))
    return found.assign_coords(
        x=labelled(("x",), x, "m", "CG in x"), y=labelled(("y",), y, "m", "CG in y"), mount=list(MOUNTS)
    ).assign_attrs(title="unequal loads")


def _offsets(study: UnequalStudy, y: xr.DataArray, x: xr.DataArray) -> xr.Dataset:
    many = Designs.of(study.scenario, {"machine.cg.1": y, "machine.cg.0": x})
    modes = modes_of(many).reset_coords(drop=True)
    stiffness = [-actuator.membrane_stiffness for actuator in study.scenario.plant.actuators]
    hertz = np.geomspace(*study.frequency, 60)
    answer = floor_response(many, hertz, "z").reset_coords(drop=True).sel(output=["rx", "ry"])
    turns = xr.apply_ufunc(np.abs, answer)
    largest = xr.apply_ufunc(np.sqrt, (turns**2).sum("output")).max("frequency")
    about = "rotation over a heaving floor, largest at any frequency"
    return xr.Dataset(
        {
            "load": (modes["rest_stroke"] * xr.DataArray(stiffness, dims="mount")).assign_attrs(
                units="N", long_name="load of a mount at rest"
            ),
            "turn": largest.assign_attrs(units="rad/m", long_name=about),
            "lowest": modes["frequency"].min("mode").assign_attrs(units="Hz", long_name="slowest mode"),
            "highest": modes["frequency"].max("mode").assign_attrs(units="Hz", long_name="fastest mode"),
        }
    )


def confirmed_loads(study: UnequalStudy) -> xr.Dataset:
    """Random offsets: the mounts' loads in closed form, and those of the simulator's equilibrium [N]."""
    random = np.random.default_rng(study.scenario.seed)
    half, centre = 0.5 * np.ptp(positions(study.scenario), axis=0), positions(study.scenario).mean(axis=0)
    at = centre + half * random.uniform(-0.9, 0.9, (study.confirmed, 2))
    sample = _offsets(study, xr.DataArray(at[:, 1], dims="design"), xr.DataArray(at[:, 0], dims="design"))
    simulated = []
    for x, y in at:
        cg = (x, y, study.scenario.machine.cg[2])
        forces = static_forces(linear_model(still(study.scenario, **resized(study.scenario, cg)).plant))
        simulated.append(forces["oil"] + forces["membrane"])
    over = ("design", "mount")
    return xr.Dataset(
        {
            "x": labelled(("design",), at[:, 0], "m", "CG in x"),
            "y": labelled(("design",), at[:, 1], "m", "CG in y"),
            "load": labelled(over, sample["load"].transpose(*over).values, "N", "load at rest, closed form"),
            "simulated": labelled(over, np.array(simulated), "N", "load at rest, simulator's equilibrium"),
        },
        {
            "design": labelled(("design",), np.arange(1, len(at) + 1), "1", "design"),
            "mount": labelled(("mount",), list(MOUNTS), "", "mount"),
        },
        {"title": "random offsets, confirmed by the simulator"},
    )


def unequal_loads(study: UnequalStudy, progress: Progress = silent) -> Outcome:
    """Run the study.

    Raises:
        InputError: if the machine has no linear model in closed form.
    """
    progress("offsets")
    table = loads_map(study)
    progress("equilibria of random offsets")
    runs = confirmed_loads(study)
    plant = study.scenario.plant
    weight = plant.total_mass * plant.gravity
    off = float(np.abs(runs["simulated"] - runs["load"]).max()) / weight
    least = table["load"].min("mount") / (0.25 * weight)
    x, y = plant.machine.cg[:2]
    here = table.sel(x=x, y=y, method="nearest")
    shares = ", ".join(
        f"{name} {1e-3 * float(load):.1f}" for name, load in zip(MOUNTS, here["load"].values, strict=True)
    )
    tenth = 0.1 * 0.5 * np.ptp(positions(study.scenario)[:, 0])
    aside = table.sel(x=x + tenth, y=y, method="nearest")
    return Outcome(
        title="Unequal loads",
        question="What does a centre of gravity beside the middle of the mounts do?",
        answers=(
            f"At rest this machine's mounts carry (kN): {shares}.",
            f"A CG {1e3 * tenth:.0f} mm further front changes the front mounts' load to "
            f"{1e-3 * float(aside['load'][0]):.1f} kN "
            f"and makes a heaving floor turn the machine by up to {float(aside['turn']):.2g} rad per m between "
            f"{study.frequency[0]:g} and {study.frequency[1]:g} Hz; here it is {float(here['turn']):.2g}.",
            f"{100 * float((least < 0).mean()):.0f} % of the offsets shown lift a foot: its membrane would have "
            "to pull.",
            f"{study.confirmed} random offsets agree with the simulator's own equilibrium within {off:.1g} of "
            "the weight.",
        ),
        tables={"offsets": table, "confirmed": runs},
        drawings={
            "loads": Drawing(
                "Load of the least loaded mount over a quarter of the weight; red: a foot would lift off.",
                lambda: _chart(study, table, "Least loaded mount", "load over a quarter [%]", 100 * least, -least),
            ),
            "turn": Drawing(
                "Largest rotation that a heaving floor causes, valves held: a CG beside the middle couples heave "
                "and rocking.",
                lambda: _chart(
                    study, table, "Heaving floor turns the machine", "rotation over floor [rad/m]", table["turn"]
                ),
            ),
            "lowest": Drawing(
                "Natural frequency of the slowest mode.",
                lambda: _chart(study, table, "Slowest mode", "frequency [Hz]", table["lowest"]),
            ),
        },
        notes=("Mounts as they are, at rest under gravity, valves held. Height of the CG, mass and inertia are kept.",),
        numbers={"largest_difference_over_weight": off},
    )


def _chart(
    study: UnequalStudy,
    table: xr.Dataset,
    title: str,
    name: str,
    values: xr.DataArray,
    boundary: xr.DataArray | None = None,
) -> "Figure":
    at, cg = positions(study.scenario), study.scenario.machine.cg
    return map_chart(
        title,
        ("CG in x [m], front to the right", table["x"].values),
        ("CG in y [m], left is up", table["y"].values),
        (name, values.transpose("y", "x").values),
        boundary=None if boundary is None else ("a foot lifts off", boundary.transpose("y", "x").values),
        points=[
            Line("this machine", [cg[0]], [cg[1]], color=1, marker="o"),
            Line("mounts", at[:, 0], at[:, 1], color=7, marker="s"),
        ],
    )
