"""One actuator failed: what still carries the machine, how it then moves, and how well the others isolate.

The law keeps driving all valves as if nothing had happened: it is the law of the intact machine. What the
actuator becomes is what a fault of a run (`ehamj.faults`) makes of it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Final, Literal, NamedTuple

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.faults.chamber_leak import FACTORS
from ehamj.faults.supply_lost import NEGLIGIBLE_AREA
from ehamj.labels import table
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.response import TURNS, rigid_floor
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant
from ehamj.plots import Figure, lines_chart
from ehamj.run.simulate import observed
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress, curves, decibel
from ehamj.studies.rest import modes_table, static_forces
from ehamj.studies.study import WholeHertz, among, study
from ehamj.studies.variants import still, with_actuators

STUCK: Final = 0.05
"""Opening of a valve that stuck while it worked, over full stroke [-]."""
INTACT: Final = "intact"
"""The machine as it is."""
STUCK_OPEN: Final = f"valve stuck {100 * STUCK:.0f} % open"
FAILURES: Final[dict[str, dict[str, Any]]] = {
    "valve stuck centred": {"kind": "valve-stuck", "opening": 0.0},
    STUCK_OPEN: {"kind": "valve-stuck", "opening": STUCK},
    "valve stuck fully open": {"kind": "valve-stuck", "opening": 1.0},
    "piston leaks": {"kind": "chamber-leak"},
    "membrane only": {"kind": "supply-lost"},
}
"""Faults of `ehamj.faults` by what they come to."""


class FailedSettings(Settings):
    """Which mount fails, and what is looked at."""

    mount: str | None = Field(None, description="mount whose actuator fails; without, the first that is not passive")
    dof: Literal["x", "y", "z"] | None = Field(
        None, description="direction in which the floor moves; without, the one that the mount acts along most"
    )
    failures: tuple[Annotated[str, among(FAILURES)], ...] = Field(tuple(FAILURES), description="what fails")
    lines: tuple[WholeHertz, ...] = Field(
        (2.0, 5.0, 10.0, 20.0, 50.0, 100.0),
        description="frequencies of the moving floor in the runs, whole numbers [Hz]",
        min_length=1,
    )
    # Far from the valves' limits, and far above the steps of their commands.
    velocity: float = Field(1e-6, gt=0, description="RMS velocity of each line [m/s]")


def at_mount(scenario: Scenario, mount: str | None) -> str:
    """The mount of that name; without one, the first that is not passive.

    Raises:
        InputError: if there is none, or nothing that could fail.
    """
    mounts = scenario.plant.obeying.mounts
    if not mounts:
        raise InputError("mount: all mounts are passive, there is no actuator that could fail")
    if mount is not None and mount not in mounts:
        passive = " (it is passive)" if mount in scenario.plant.mounts else ""
        raise InputError(f"mount = {mount!r}{passive}: must be one of {', '.join(mounts)}")
    return mount or mounts[0]


def moving_floor(scenario: Scenario, mount: str, dof: str | None = None) -> str:
    """Direction of the floor that the mount meets most, or the one that is asked for: x, y or z."""
    along = np.abs(scenario.plant.directions[scenario.plant.mounts.index(mount)])
    return dof or AXES[int(np.argmax(along))]


def failed(scenario: Scenario, failure: str, mount: str | None = None) -> Scenario:
    """The machine with one actuator failed, and at rest in it; ``intact`` is the machine as it is.

    Raises:
        InputError: if there is no such failure or mount.
    """
    if failure == INTACT:
        return scenario
    if failure not in FAILURES:
        raise InputError(f"failure = {failure!r}: must be one of {INTACT}, {', '.join(FAILURES)}")
    name, plant = at_mount(scenario, mount), scenario.plant
    fault = changed(scenario, {"fault": ({"mount": name, "time": 0.0, **FAILURES[failure]},)}).fault[0]
    settled = fault.settled(plant, np.zeros(len(plant.mounts)), np.inf)
    if failure == "membrane only":
        settled = settled.with_actuator(name, {"piston_area": NEGLIGIBLE_AREA})
    return changed(scenario, with_actuators(scenario, {name: settled.actuators[plant.mounts.index(name)]}))


def turns_of(plant: Plant) -> tuple[str, ...]:
    """Rotations that are looked at: rx and ry, and where the layout drives yaw rz too."""
    return TURNS if "yaw" in plant.layout.motions else TURNS[:2]


def residual(model: LinearModel, loop: Loop | None, hertz: Array, dof: str = "z") -> ComplexArray:
    """Motion of the CG [-] and rotations [rad/m, that is µrad/µm] over a floor that moves along ``dof``, (frequency,
    1 + rotations), linear."""
    outputs = (f"cg_displacement {dof}", *(f"machine_displacement {turn}" for turn in turns_of(model.plant)))
    return rigid_floor(model, hertz, loop, outputs, (dof,)).response[:, :, 0]


def simulated_residual(
    scenario: Scenario,
    loop: Loop | None,
    settings: FailedSettings = FailedSettings(),  # noqa: B008  # frozen
    dof: str = "z",
) -> ComplexArray:
    """As `residual`, at the settings' lines, from a nonlinear run of 5 s of which the last is evaluated."""
    f = np.array(settings.lines)
    phases = -np.pi * np.arange(f.size) * (np.arange(f.size) + 1) / f.size
    ground = {"kind": "multisine", "dof": dof, "frequencies": f.tolist(), "velocities": (settings.velocity,)}
    ground |= {"phases": phases.tolist(), "fade_in": 1.0}
    law = None if loop is None else loop.law
    run = observed(still(scenario, ground=ground, duration=5.0, record_rate=2000.0), controller=law)
    part = run.dataset.sel(time=slice(4.0 + 1e-9, None))
    time = part["time"].values
    turned = (part["machine_displacement"].sel(dof=turn) for turn in turns_of(scenario.plant))
    signals = [part["cg_displacement"].sel(axis=dof), *turned]
    waves = [wave(2 * np.pi * hertz * time) for hertz in f for wave in (np.cos, np.sin)]
    columns = np.column_stack([np.ones_like(time), time, *waves])  # a mean and a drift beside the lines
    fitted = np.linalg.lstsq(columns, np.column_stack([signal.values for signal in signals]), rcond=None)[0][2:]
    answer = fitted[0::2] - 1j * fitted[1::2]
    floor = np.sqrt(2.0) * settings.velocity / (2 * np.pi * f) * np.exp(1j * (phases - np.pi / 2))
    return np.asarray(answer / floor[:, None])


def simulated_event(
    scenario: Scenario, share: float, mount: str | None = None, duration: float = 1.5
) -> dict[str, Array]:
    """What each mount carries after a valve of the intact machine ran to a share of its stroke and stayed there.

    As `static_forces`, from a nonlinear run that begins at the intact machine's equilibrium.
    """
    name, plant = at_mount(scenario, mount), scenario.plant
    own = plant.actuators[plant.mounts.index(name)]
    step = {"kind": "step", "mounts": (name,), "amplitude": share * own.spool_stroke / own.valve_gain}
    control = {"kind": "open-loop", "signals": (step | {"start": 0.05},)}
    run = observed(still(scenario, control=control, duration=duration)).dataset.isel(time=-1)
    stiffness = np.array([actuator.membrane_stiffness for actuator in plant.actuators])
    stroke = run["stroke"].values
    return {"stroke": stroke, "oil": run["actuator_force"].values, "membrane": -stiffness * stroke}


@study(
    "failed-actuator",
    FailedSettings,
    "one actuator failed (stuck valve, leak, no oil): modes, forces, what isolation is left",
    small={"failures": ("membrane only",), "lines": (20.0,)},
)
def failed_actuator(scenario: Scenario, settings: FailedSettings, progress: Progress) -> Outcome:
    """A machine with a failed actuator that has no operating point is refused."""
    loop, mount = Loop.of(scenario, scenario.controller()), at_mount(scenario, settings.mount)
    dof, many = moving_floor(scenario, mount, settings.dof), len(scenario.plant.obeying.mounts)
    floor = FLOORS[dof]
    models, answers = {}, {}
    for case in (INTACT, *settings.failures):
        progress(f"{case}: linear model and run")
        machine = failed(scenario, case, mount)
        models[case] = linear_model(machine.plant)
        linear = residual(models[case], loop, np.array(settings.lines), dof)
        answers[case] = (linear, simulated_residual(machine, loop, settings, dof))
    progress("a valve runs away")
    static = static_forces(linear_model(failed(scenario, STUCK_OPEN, mount).plant))
    event = simulated_event(scenario, STUCK, mount)
    off = max(float(np.abs(static[part] - event[part]).max()) for part in ("oil", "membrane"))
    forces = _forces_table(models)
    isolation = _isolation_table(mount, floor, settings.lines, answers)
    residuals = _curves_table(models, loop, dof)
    largest = float(isolation["difference"].max())
    return Outcome(
        title="One actuator failed",
        question=f"What does the machine do when one of its {many} actuators, at {mount}, fails and the others go on?",
        answers=(
            *_failure_answers(mount, floor, isolation, forces),
            f"Nonlinear runs agree with the linear residuals within {largest:.1g} of the floor's motion"
            + (STEPS if largest > CLOSE else "."),
            f"A run in which the valve of the intact machine opens to {100 * STUCK:.0f} % and stays ends with the "
            f"forces computed for it, to {off:.2g} N.",
        ),
        tables={"isolation": isolation, "forces": forces, "modes": modes_table(models), "curves": residuals},
        drawings={
            floor.motion: Drawing(
                f"From {floor.words} to the CG, with one actuator of {many} failed; circles: nonlinear runs.",
                lambda: _failed_chart(floor, residuals, isolation, floor.motion, "CG over floor [dB]"),
            ),
            "rocking": Drawing(
                "Rotation that the same floor causes, since the failed mount still follows it.",
                lambda: _failed_chart(floor, residuals, isolation, "rotation", "rotation over floor [dB re 1 µrad/µm]"),
            ),
        },
        notes=NOTES,
        numbers={"largest_difference": largest, "force_difference_n": off},
    )


class Floor(NamedTuple):
    """A floor that moves along an axis, in words."""

    motion: str
    """What the machine then does."""
    words: str


FLOORS: Final = {
    "x": Floor("surge", "a floor that moves along x"),
    "y": Floor("sway", "a floor that moves along y"),
    "z": Floor("heave", "a heaving floor"),
}

LEAST: Final = 1e-9
"""Residual below which nothing is told apart [-]."""
CLOSE: Final = 0.01
"""Difference of run and linear residual, over the floor's motion, from which its cause is named [-]."""
STEPS: Final = ": the commands' steps count beside this floor; ask with a larger velocity."
TURNING: Final = 1e-2
"""Rotation over the floor from which a machine turns [µrad/µm]: 10 nm a metre from its centre for each µm."""

NOTES: Final = (
    "The law is that of the intact machine and drives all valves; without a law valves are held.",
    f"piston leaks: {FACTORS['piston']:g} times the flow-pressure coefficient, across the piston. membrane only: no "
    "oil in the cylinder. A stuck valve keeps its opening whatever the command.",
    "Negative membrane forces pull: the feet must be bolted.",
)


def _isolation_table(
    mount: str, floor: Floor, lines: Sequence[float], answers: Mapping[str, tuple[ComplexArray, ComplexArray]]
) -> xr.Dataset:
    linear, simulated = (np.array([pair[k] for pair in answers.values()]) for k in range(2))
    turn = [np.linalg.norm(part[..., 1:], axis=-1) for part in (linear, simulated)]
    motion, moved = floor.motion, [np.abs(part[..., 0]) for part in (linear, simulated)]
    return table(
        f"residual of {floor.words}, failure at {mount}",
        {"case": (list(answers), "", "actuator"), "frequency": (list(lines), "Hz", "frequency")},
        **{
            motion: (moved[0], "1", f"CG {motion} over floor, linear"),
            f"{motion}_simulated": (moved[1], "1", f"CG {motion} over floor, nonlinear run"),
        },
        rotation=(turn[0], "µrad/µm", "rotation over floor, linear"),
        rotation_simulated=(turn[1], "µrad/µm", "rotation over floor, nonlinear run"),
        difference=(np.abs(simulated - linear)[..., 0], "1", f"run less linear, CG {motion} over floor, complex"),
    )


def _curves_table(models: Mapping[str, LinearModel], loop: Loop | None, dof: str) -> xr.Dataset:
    f, floor = np.geomspace(0.5, 300.0, 201), FLOORS[dof]
    values = np.array([residual(model, loop, f, dof) for model in models.values()])
    return table(
        f"residual of {floor.words} over frequency, linear",
        {"case": (list(models), "", "actuator"), "frequency": (f, "Hz", "frequency")},
        **{floor.motion: (np.abs(values[..., 0]), "1", f"CG {floor.motion} over floor")},
        rotation=(np.linalg.norm(values[..., 1:], axis=-1), "µrad/µm", "rotation over floor"),
    )


def _forces_table(models: Mapping[str, LinearModel]) -> xr.Dataset:
    found = [static_forces(model) for model in models.values()]
    stroke, oil, membrane = (np.array([one[part] for one in found]) for part in ("stroke", "oil", "membrane"))
    mounts = next(iter(models.values())).plant.mounts
    return table(
        "what carries the machine at rest",
        {"case": (list(models), "", "actuator"), "mount": (list(mounts), "", "mount")},
        stroke=(stroke, "m", "stroke at rest"),
        oil=(oil, "N", "force of the oil at rest, towards the machine"),
        membrane=(membrane, "N", "force of the membrane at rest, towards the machine"),
    )


def _failure_answers(mount: str, floor: Floor, isolation: xr.Dataset, forces: xr.Dataset) -> list[str]:
    at = min(isolation["frequency"].values, key=lambda f: abs(np.log(f / 10.0)))
    found = []
    for case in isolation["case"].values:
        one, rest = isolation.sel(frequency=at, case=case), forces.sel(case=case)
        moved, linear, turn = (
            float(one[what]) for what in (f"{floor.motion}_simulated", floor.motion, "rotation_simulated")
        )
        ran, expected = (20 * np.log10(max(value, LEAST)) for value in (moved, linear))
        words = f"{case.capitalize()}: {floor.words} at {at:g} Hz reaches the CG with {ran:.0f} dB in the run"
        words += f" (linear {expected:.0f} dB)" if round(ran) != round(expected) else ""
        words += f" and turns the machine by {turn:.2g} µrad per µm" if turn > TURNING else ""
        words += " and hardly turns the machine" if turn <= TURNING else ""
        if case != INTACT:
            carried = rest["membrane"] + rest["oil"]
            low, high = (round(1e-3 * float(end), 1) + 0.0 for end in (carried.min(), carried.max()))  # no "-0.0"
            oil = float(rest["oil"].sel(mount=mount))
            spread = f"{low:.1f} to {high:.1f}" if float(carried.max() - carried.min()) > 1.0 else f"{low:.1f}"
            words += f"; at rest each mount carries {spread} kN"
            words += f", the oil there {1e-3 * oil:.1f} kN" if abs(oil) > 1.0 else ""
        found.append(words.replace(" -", " −") + ".")
    return found


def _failed_chart(floor: Floor, residuals: xr.Dataset, isolation: xr.Dataset, what: str, label: str) -> Figure:
    lines = curves(decibel(residuals[what].clip(1e-6)), "case")
    runs = curves(decibel(isolation[f"{what}_simulated"].clip(1e-6)), "case", 1)
    lines += [replace(run, label="" if k else "nonlinear run", marker="o") for k, run in enumerate(runs)]
    title = f"{floor.words.capitalize()} to {'rotation' if what == 'rotation' else 'the CG'}"
    return lines_chart(title, "frequency [Hz]", {label: lines}, logarithmic="x", limits={label: (-80.0, 20.0)})
