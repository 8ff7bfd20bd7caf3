"""Unequal loads: the centre of gravity beside the middle of the mounts."""

from typing import Any, Final

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.arrays import Array
from ehamj.designs.designs import Designs
from ehamj.designs.floor import floor_response
from ehamj.designs.many import modes_of
from ehamj.labels import labelled, table
from ehamj.linear.machine import linear_model
from ehamj.plots import Figure, Line, map_chart
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress
from ehamj.studies.rest import static_forces
from ehamj.studies.study import Positive, Range, study
from ehamj.studies.variants import check_gravity, positions, resized, still


class UnequalSettings(Settings):
    """Offsets of the CG, as shares of half the mounts' distances in x and y."""

    reach: Positive = Field(1.1, description="largest offset, as a share of half the mounts' distance")
    points: int = Field(45, ge=2, description="offsets each way")
    frequency: Range = Field(
        (1.0, 100.0), description="range in which rotations by a heaving floor are looked for [Hz]"
    )
    confirmed: int = Field(
        20, ge=1, description="random offsets whose loads are computed by the simulator's own equilibrium"
    )


CARRIES: Final = 0.5
"""z of a mount's direction from which it is one that carries the machine [-]."""


def _middle(scenario: Scenario) -> tuple[Array, Array]:
    """Middle of the mounts, and half their distances, in x and y [m]."""
    places = positions(scenario)
    return places.mean(axis=0), 0.5 * np.ptp(places, axis=0)


def loads_map(scenario: Scenario, settings: UnequalSettings) -> xr.Dataset:
    """Over ``y`` and ``x`` of the CG [m]: load of each mount [N], turn by a heaving floor [rad/m], lowest mode [Hz]."""
    share = settings.reach * np.linspace(-1.0, 1.0, settings.points)
    x, y = (centre + half * share for centre, half in zip(*_middle(scenario), strict=True))
    found = _offsets(scenario, settings, xr.DataArray(x, dims="x"), xr.DataArray(y, dims="y"))
    return found.assign_coords(
        x=labelled(("x",), x, "m", "CG in x"),
        y=labelled(("y",), y, "m", "CG in y"),
        mount=list(scenario.plant.mounts),
    ).assign_attrs(title="unequal loads")


def _offsets(scenario: Scenario, settings: UnequalSettings, x: xr.DataArray, y: xr.DataArray) -> xr.Dataset:
    many = Designs.of(scenario, {"machine.cg.1": y, "machine.cg.0": x})
    modes = modes_of(many).reset_coords(drop=True)
    stiffness = xr.DataArray([-actuator.membrane_stiffness for actuator in scenario.plant.actuators], dims="mount")
    answer = floor_response(many, np.geomspace(*settings.frequency, 60), "z").reset_coords(drop=True)
    turns = xr.apply_ufunc(np.abs, answer.sel(output=["rx", "ry"]))
    largest = xr.apply_ufunc(np.sqrt, (turns**2).sum("output")).max("frequency")
    columns = {
        "load": (modes["rest_stroke"] * stiffness, "N", "load of a mount at rest"),
        "turn": (largest, "rad/m", "rotation over a heaving floor, largest at any frequency"),
        "lowest": (modes["frequency"].min("mode"), "Hz", "slowest mode"),
        "highest": (modes["frequency"].max("mode"), "Hz", "fastest mode"),
    }
    return xr.Dataset(
        {key: values.assign_attrs(units=unit, long_name=name) for key, (values, unit, name) in columns.items()}
    )


def confirmed_loads(scenario: Scenario, settings: UnequalSettings) -> xr.Dataset:
    """Random offsets: the mounts' loads in closed form, and those of the simulator's equilibrium [N]."""
    random = np.random.default_rng(scenario.seed)
    centre, half = _middle(scenario)
    at = centre + half * random.uniform(-0.9, 0.9, (settings.confirmed, 2))
    x, y = (xr.DataArray(values, dims="design") for values in at.T)
    sample, over = _offsets(scenario, settings, x, y), ("design", "mount")
    simulated = []
    for place in at.tolist():
        cg = (*place, scenario.machine.cg[2])
        forces = static_forces(linear_model(still(scenario, **resized(scenario, cg)).plant))
        simulated.append(forces["oil"] + forces["membrane"])
    return table(
        "random offsets, confirmed by the simulator",
        {
            "design": (np.arange(1, len(at) + 1), "1", "design"),
            "mount": (list(scenario.plant.mounts), "", "mount"),
        },
        x=(("design",), at[:, 0], "m", "CG in x"),
        y=(("design",), at[:, 1], "m", "CG in y"),
        load=(sample["load"].transpose(*over).values, "N", "load at rest, closed form"),
        simulated=(np.array(simulated), "N", "load at rest, simulator's equilibrium"),
    )


@study(
    "unequal-loads",
    UnequalSettings,
    "a centre of gravity beside the middle: loads of the mounts, heave that rocks",
    small={"points": 5, "confirmed": 1},
)
def unequal_loads(scenario: Scenario, settings: UnequalSettings, progress: Progress) -> Outcome:
    """A machine without gravity, or that has no linear model in closed form, is refused."""
    check_gravity(scenario, "loads the mounts")
    progress("offsets")
    offsets = loads_map(scenario, settings)
    progress("equilibria of random offsets")
    runs = confirmed_loads(scenario, settings)
    plant = scenario.plant
    weight = plant.total_mass * plant.gravity
    off = float(np.abs(runs["simulated"] - runs["load"]).max()) / weight
    carry = np.array(plant.directions)[:, 2] > CARRIES
    equal = weight / max(int(carry.sum()), 1)
    least = offsets["load"].isel(mount=np.flatnonzero(carry)).min("mount") / equal
    front = int(np.argmax(np.where(carry, np.array(plant.positions)[:, 0], -np.inf)))
    x, y = scenario.machine.cg[:2]
    tenth = 0.1 * float(_middle(scenario)[1][0])
    places = (xr.DataArray(values, dims="design") for values in ([x, x + tenth], [y, y]))
    own = _offsets(scenario, settings, *places).assign_coords(mount=list(plant.mounts))
    here, aside = own.isel(design=0), own.isel(design=1)
    shares = ", ".join(f"{name} {_kilo(here, name)}" for name in plant.mounts)
    low, high = settings.frequency
    return Outcome(
        title="Unequal loads",
        question="What does a centre of gravity beside the middle of the mounts do?",
        answers=(
            f"At rest this machine's mounts carry (kN): {shares}.",
            f"A CG {1e3 * tenth:.0f} mm further front changes the load of {plant.mounts[front]} to "
            f"{_kilo(aside, plant.mounts[front])} kN and makes a heaving floor turn the machine by up to "
            f"{float(aside['turn']):.2g} rad per m between {low:g} and {high:g} Hz; here it is "
            f"{float(here['turn']):.2g}.",
            f"{100 * float((least < 0).mean()):.0f} % of the offsets shown lift a foot: its membrane would have "
            "to pull.",
            f"{settings.confirmed} random offsets agree with the simulator's own equilibrium within {off:.1g} of "
            "the weight.",
        ),
        tables={"offsets": offsets, "confirmed": runs},
        drawings={
            "loads": Drawing(
                "Load of the least loaded mount over an equal share of the weight; red: a foot would lift off.",
                lambda: _chart(scenario, "Least loaded mount", ("load over an equal share [%]", 100 * least), -least),
            ),
            "turn": Drawing(
                "Largest rotation that a heaving floor causes, valves held: a CG beside the middle couples heave "
                "and rocking.",
                lambda: _chart(
                    scenario, "Heaving floor turns the machine", ("rotation over floor [rad/m]", offsets["turn"])
                ),
            ),
            "lowest": Drawing(
                "Natural frequency of the slowest mode.",
                lambda: _chart(scenario, "Slowest mode", ("frequency [Hz]", offsets["lowest"])),
            ),
        },
        notes=("Mounts as they are, at rest under gravity, valves held. Height of the CG, mass and inertia are kept.",),
        numbers={"largest_difference_over_weight": off},
    )


def _kilo(loads: xr.Dataset, mount: str) -> str:
    return f"{round(1e-3 * float(loads['load'].sel(mount=mount)), 1) + 0.0:.1f}"  # + 0: no "-0.0"


def _chart(
    scenario: Scenario, title: str, values: tuple[str, xr.DataArray], lifts: xr.DataArray | None = None
) -> Figure:
    at, cg = positions(scenario), scenario.machine.cg
    name, found = values
    boundary: Any = None if lifts is None else ("a foot lifts off", lifts.transpose("y", "x").values)
    return map_chart(
        title,
        ("CG in x [m], front to the right", found["x"].values),
        ("CG in y [m], left is up", found["y"].values),
        (name, found.transpose("y", "x").values),
        boundary=boundary,
        points=[
            Line("this machine", [cg[0]], [cg[1]], color=1, marker="o"),
            Line("mounts", at[:, 0], at[:, 1], color=7, marker="s"),
        ],
    )
