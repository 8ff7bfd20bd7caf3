"""Soft passive mounts as the baseline: how well they isolate, and when a tall machine tips over on them.

Gravity works against the mounts: a tilt φ about the mount plane moves the centre of gravity sideways by h φ, and the
weight turns the machine with m g h φ. The mounts turn it back with Σ k y² φ. What stands must have Σ k y² > m g h, with
the static stiffness k: oil or gas that can leak around the piston holds nothing in the long run.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np
import xarray as xr
from pydantic import Field
from scipy.optimize import brentq

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.interruption import pool_of
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import ACTUATOR_PRESETS
from ehamj.labels import table
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.response import rigid_floor
from ehamj.mujoco import hydraulics
from ehamj.plant.axes import AXES
from ehamj.plant.mounts import UPRIGHT
from ehamj.plant.plant import Plant
from ehamj.plots import Figure, Line, lines_chart
from ehamj.run.simulate import observed
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress, curves, decibel, silent
from ehamj.studies.rest import modes_table
from ehamj.studies.study import Positive, among, study
from ehamj.studies.variants import check_gravity, positions, preset, resized, still, with_every_actuator

MOUNTS_COMPARED = ("elastic-mount", "pneumatic-mount")
AXES_OF_TIPPING = ("about x", "about y")
NUDGE = 1e-6
"""Peak rate of the floor's tilt that starts the nonlinear run [rad/s]: it then moves by nanoradians and rests."""

MARGIN = 5e-3
"""Off the boundary by this much, nonlinear runs are made."""


class SoftMountSettings(Settings):
    """On which mounts the machine is put, and where it is looked for when it tips."""

    presets: tuple[Annotated[str, among(ACTUATOR_PRESETS)], ...] = Field(
        MOUNTS_COMPARED, min_length=1, description="presets of the mounts"
    )
    widths: tuple[Positive, ...] = Field(
        (0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5),
        description="factors on the mounts' places for which the tipping boundary is computed",
    )
    simulated: tuple[Positive, ...] = Field(
        (0.5, 1.0), description="factors for which it is found by nonlinear simulation, too"
    )
    duration: float = Field(60.0, gt=0, description="simulated time of each run [s]")


def tipping_height(plant: Plant) -> tuple[float, float]:
    """CG height above the mount plane at which the machine tips, about x and about y [m]; the lower one decides.

    Closed form Σ k y²/(m g) and Σ k x²/(m g), about the mounts' elastic centre; for a layout that is not symmetric,
    the two principal values of Σ k r rᵀ.
    """
    k = np.array([actuator.static_stiffness for actuator in plant.actuators])
    r = np.array(plant.positions)[:, :2]
    centred = r - k @ r / k.sum()
    restoring = np.einsum("m,mi,mj->ij", k, centred, centred)
    values, vectors = np.linalg.eigh(restoring)
    about_x = int(np.argmax(np.abs(vectors[1])))
    weight = plant.machine.mass * plant.gravity
    return float(values[about_x] / weight), float(values[1 - about_x] / weight)


def _check_flat(plant: Plant) -> None:
    """Refuse mounts of which `tipping_height` knows nothing."""
    for name, position, direction in zip(plant.mounts, plant.positions, plant.directions, strict=True):
        if position[2] != 0.0 or direction[2] < 1.0 - UPRIGHT:
            raise InputError(
                f"mount {name}: position = {list(position)} m, direction = {[round(part, 4) for part in direction]}: "
                "this study needs upright mounts in the mount plane (z = 0), whose tipping height has a closed form; "
                "the study 'rocking' gives the tipping margin of any layout"
            )


def tall(scenario: Scenario, actuator: Actuator, height: float, width: float = 1.0) -> Scenario:
    """The bare machine on these mounts, its CG at ``height`` [m] and its mounts' places multiplied by ``width``.

    The CG stands over the middle of the mounts: one beside it has no upright rest near the boundary, it leans (`lean`).
    """
    places = width * positions(scenario)
    sized = resized(scenario, (*places.mean(axis=0), height), places)
    placed = still(scenario, **sized)
    return still(placed, plates="tied", **with_every_actuator(placed, actuator))


def lean(scenario: Scenario, actuator: Actuator) -> float:
    """Largest tilt at rest of the machine as it is on these mounts [rad], small angles; infinite where it tips over.

    A CG beside the middle by e turns it with m g e, against Σ k y² − m g h.
    """
    machine = scenario.machine
    offset = np.abs(np.array(machine.cg[:2]) - positions(scenario).mean(axis=0))[::-1]  # about x, about y
    heights = np.array(tipping_height(tall(scenario, actuator, machine.cg[2]).plant))
    if heights.min() <= machine.cg[2]:
        return float("inf")
    return float((offset / (heights - machine.cg[2])).max())


def growth(scenario: Scenario) -> float:
    """Largest real part of the machine's eigenvalues that is not rounding [1/s]; positive: it tips over."""
    values = np.linalg.eigvals(linear_model(scenario.plant).A)
    clear = values.real[np.abs(values) > 1e-9 * np.abs(values).max()]
    return float(clear.max())


def falls(scenario: Scenario, about: str, duration: float = 60.0) -> bool:
    """Whether the machine falls over in a nonlinear run that a tilt of the floor starts and then leaves to itself.

    It does if its tilt at the end is well beyond the largest of the first half; a machine that stands swings back.
    """
    dof = "rx" if about == "about x" else "ry"
    nudge = {"kind": "shock", "dof": dof, "velocity": NUDGE, "pulse_time": 0.05, "return_time": 0.2, "begin": 0.01}
    values = {"ground": nudge, "duration": duration, "record_rate": 200.0, "fault": (), "may_fall": True}
    run = observed(changed(scenario, values))
    tilt = np.abs(run.dataset["machine_displacement"].sel(dof=dof).values)
    return bool(tilt[-tilt.size // 10 :].max() > 1.5 * tilt[: tilt.size // 2].max())


def boundary(scenario: Scenario, actuator: Actuator, width: float) -> float:
    """CG height at which the machine tips [m] by the eigenvalues of the linear model, to 1e-5 of itself."""
    closed = min(tipping_height(tall(scenario, actuator, 1.0, width).plant))
    rate = lambda height: growth(tall(scenario, actuator, height, width))  # noqa: E731
    return float(brentq(rate, 0.9 * closed, 1.1 * closed, xtol=1e-5 * closed))


@study(
    "soft-mounts",
    SoftMountSettings,
    "elastic and pneumatic mounts as the baseline, and when the machine tips over on them",
    small={"presets": ("pneumatic-mount",), "widths": (1.0,), "simulated": (1.0,), "duration": 2.0},
)
def soft_mounts(scenario: Scenario, settings: SoftMountSettings, progress: Progress) -> Outcome:
    """A machine without gravity, or that cannot stand on its mounts at all, is refused."""
    check_gravity(scenario, "tips")
    _check_flat(scenario.plant)
    tipping = tipping_table(scenario, settings, progress)
    progress("transmissibility and modes")
    systems = compared_systems(scenario, settings.presets)
    gains = transmissibility_table(systems)
    height = tipping["eigenvalue"].sel(width=1.0)
    return Outcome(
        title="Soft passive mounts",
        question="How well do passive mounts isolate this machine, and when does it tip over on them?",
        answers=_answers(scenario, len(settings.simulated), tipping),
        tables={
            "tipping": tipping,
            "transmissibility": gains,
            "modes": modes_table({name: model for name, (model, _) in systems.items()}),
        },
        drawings={
            "tipping": Drawing(
                "CG height at which the machine tips, over half the distance of the mounts (the narrower direction). "
                f"Squares: nonlinear runs of {settings.duration:g} s; filled ones fell over.",
                lambda: _tipping_chart(tipping, scenario.machine.cg[2]),
            ),
            "heave": Drawing(
                "How much of a heaving floor reaches the centre of gravity; below 0 dB the machine is quieter.",
                lambda: _gain_chart(gains.sel(axis="z"), "Floor to machine, vertical"),
            ),
            "sway": Drawing(
                "The same along x. Upright isolators reach sway only through its rocking part.",
                lambda: _gain_chart(gains.sel(axis="x"), "Floor to machine, along x"),
            ),
        },
        notes=NOTES,
        numbers={
            "tipping_height_m": {name: float(height.sel(mounts=name)) for name in tipping["mounts"].values.tolist()}
        },
    )


NOTES = (
    "Transmissibility is that of the linear model: a floor that drives valves to their "
    "limits is isolated less (`ehamj run`).",
    "The presets elastic-mount (a spring of 5 Hz under 4 t) and pneumatic-mount (an air spring with damping "
    "chamber, 2 Hz) are assumed, typical values; levelling valves are not modelled.",
    "Static stiffness is the membrane's: oil or gas leaks around the piston and holds no load that stays.",
    "The boundary is that of a CG over the middle of the mounts; beside it the machine leans. "
    "Mass and inertia about the CG are kept while its height changes; height counts from the mount plane.",
)


def tipping_table(scenario: Scenario, settings: SoftMountSettings, progress: Progress = silent) -> xr.Dataset:
    """CG height at which the machine tips [m], over ``mounts`` and ``width``: closed form, eigenvalues, and runs.

    The runs stand 0.5 % below the eigenvalue's height and fall 0.5 % above; ``stands`` and ``falls`` are the heights at
    which they did, NaN where none was made or the run did otherwise.
    """
    actuators = [preset(name) for name in settings.presets]
    widths = sorted({*settings.widths, *settings.simulated, 1.0})
    shape = (len(actuators), len(widths))
    closed, eigen, stands, fell = (np.full(shape, np.nan) for _ in range(4))
    about = np.full(shape, "", dtype=object)
    for i, j in np.ndindex(*shape):
        progress(f"tipping boundary, {i * len(widths) + j + 1} of {about.size}")
        both = tipping_height(tall(scenario, actuators[i], 1.0, widths[j]).plant)
        closed[i, j], about[i, j] = min(both), AXES_OF_TIPPING[int(np.argmin(both))]
        eigen[i, j] = boundary(scenario, actuators[i], widths[j])

    def run(case: tuple[int, int, int]) -> None:
        progress(f"nonlinear run {runs.index(case) + 1} of {len(runs)}")
        i, j, side = case
        height = (1.0 + side * MARGIN) * eigen[i, j]
        down = falls(tall(scenario, actuators[i], height, widths[j]), about[i, j], settings.duration)
        if down == (side > 0):
            (fell if down else stands)[i, j] = height

    runs = [(i, j, side) for i, j in np.ndindex(*shape) if widths[j] in settings.simulated for side in (-1, 1)]
    with hydraulics(), pool_of() as pool:
        list(pool.map(run, runs))
    half = 0.5 * np.ptp(positions(scenario), axis=0).min()
    return table(
        "CG height at which the machine tips over",
        {"mounts": (list(settings.presets), "", "mounts"), "width": (widths, "1", "factor on the mounts' places")},
        half_distance=(("width",), half * np.array(widths), "m", "half distance of the mounts"),
        about=(about.astype(str), "", "direction in which it tips first"),
        closed_form=(closed, "m", "CG height, closed form Σ k y²/(m g)"),
        eigenvalue=(eigen, "m", "CG height, from eigenvalues"),
        stands=(stands, "m", "CG height at which a run stood"),
        falls=(fell, "m", "CG height at which a run fell over"),
    )


Systems = Mapping[str, tuple[LinearModel, Loop | None]]


def compared_systems(scenario: Scenario, presets: Sequence[str] = MOUNTS_COMPARED) -> Systems:
    """The machine on each kind of soft mount and on its own actuators: valves held, and under its control if any."""
    passive, law = still(scenario), scenario.controller()
    own, loop = linear_under(scenario.plant, law), Loop.of(scenario, law)
    found: dict[str, tuple[LinearModel, Loop | None]] = {
        name: (linear_model(still(passive, **with_every_actuator(passive, preset(name))).plant), None)
        for name in presets
    }
    found["its own, valves held"] = (own, None)
    if loop is not None:
        found["its own, controlled"] = (own, loop)
    return found


def transmissibility_table(systems: Systems, hertz: Array | None = None) -> xr.Dataset:
    """CG motion over that of a rigid floor along x, y and z [-], over ``system``, ``axis`` and ``frequency``."""
    f = np.geomspace(0.3, 300.0, 301) if hertz is None else hertz

    def gain(model: LinearModel, loop: Loop | None, axis: str) -> Array:
        return np.abs(rigid_floor(model, f, loop, (f"cg_displacement {axis}",), (axis,)).response[:, 0, 0])

    return table(
        "floor to machine",
        {
            "system": (list(systems), "", "mounts"),
            "axis": (list(AXES), "", "axis"),
            "frequency": (f, "Hz", "frequency"),
        },
        gain=(np.array([[gain(*one, axis) for axis in AXES] for one in systems.values()]), "1", "CG over floor"),
    )


def _answers(scenario: Scenario, simulated: int, tipping: xr.Dataset) -> tuple[str, ...]:
    height = scenario.machine.cg[2]
    one = tipping.sel(width=1.0)
    found = []
    for name in tipping["mounts"].values.tolist():
        limit, about = float(one["eigenvalue"].sel(mounts=name)), str(one["about"].sel(mounts=name).values)
        tilt = lean(scenario, preset(name))
        leaning = f", leaning by {1e3 * tilt:.2g} mrad" if tilt > 1e-6 else ""
        state = f"stands{leaning}" if height < limit else "TIPS OVER"
        found.append(
            f"On {name}, the machine tips {about} with its CG above {limit:.2f} m; at {height:.2f} m it {state}."
        )
    half = float(one["half_distance"])
    rule = np.sqrt(scenario.gravity * height) / (2 * np.pi * half)
    stood, fell = (int(np.isfinite(tipping[what]).sum()) for what in ("stands", "falls"))
    wanted = tipping.sizes["mounts"] * simulated
    return (
        *found,
        f"As a rule, whatever the mass: mounts tip the machine when it heaves below √(g h)/(2π b) = {rule:.2f} Hz, "
        f"with CG height h = {height:.2f} m and half the mounts' distance b = {half:.2f} m.",
        f"Nonlinear runs agree: {stood} of {wanted} stood {100 * MARGIN:g} % below the computed height, and "
        f"{fell} of {wanted} fell over {100 * MARGIN:g} % above.",
    )


def _tipping_chart(tipping: xr.Dataset, height: float) -> Figure:
    half = tipping["half_distance"].values
    lines = curves(tipping["closed_form"].assign_coords(width=half), "mounts", 1, "{}: tips above")
    runs = (("stands", "run stood (0.5 % below)", 7, "s"), ("falls", "run fell (0.5 % above)", 1, "X"))
    for what, words, color, marker in runs:
        both = tipping[what].transpose("mounts", "width").values.ravel()
        lines.append(Line(words, np.tile(half, tipping.sizes["mounts"]), both, color, marker=marker))
    here = float(tipping["half_distance"].sel(width=1.0))
    lines.append(Line("this machine", [here], [height], 2, marker="o"))
    return lines_chart(
        "When it tips over", "half distance of the mounts [m]", {"CG height [m]": lines}, logarithmic="y"
    )


def _gain_chart(gains: xr.Dataset, title: str) -> Figure:
    panels = {"CG over floor [dB]": curves(decibel(gains["gain"]), "system")}
    return lines_chart(title, "frequency [Hz]", panels, logarithmic="x", limits=dict.fromkeys(panels, (-70.0, 30.0)))
