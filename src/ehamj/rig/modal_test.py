"""Modes identified from simulated measurements, as on a rig, beside the computed ones.

The nonlinear machine is excited with its valves held; what its feet do is identified without any model
(`ehamj.estimate.identification`), and a name goes to each mode found by its likeness to a computed one. Settings that a
test engineer takes from a first look (band, resolution, decay time) come from the computed modes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from ehamj.control.channels import point_row
from ehamj.errors import InputError
from ehamj.estimate.identification import Estimates, Stable, agreed, oscillating, polyreference, realise, residues
from ehamj.linear.eigen import mac
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import Mode, modes
from ehamj.linear.shapes import weights
from ehamj.mujoco.model import reduced
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.machine import Machine
from ehamj.plant.plant import Plant
from ehamj.result import Result
from ehamj.rig.ringdown import free_decays
from ehamj.run.simulate import simulate_many
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

Kind = Literal["ring-down", "random", "sweep", "hammer"]
KINDS: Final[tuple[Kind, ...]] = get_args(Kind)

LEVEL: Final = 5e-6
"""RMS velocity of each line of a random excitation [m/s]; of a rotation, at the mounts' mean distance."""
SWEEP_SPEED: Final = 5e-4
"""Peak velocity at the end of a sweep [m/s]."""
BLOW: Final = 2000.0
"""Peak force of a hammer [N]: the machine moves by micrometres."""
BLOW_WIDTH: Final = 0.8
"""Duration of a blow times the highest frequency of the band [-]: there half of the spectrum's height is left."""
POLES: Final = range(36, 73, 6)
"""Numbers of poles that fits of responses have, and which must agree."""
RING_ORDERS: Final = range(18, 27, 2)
"""Orders of the eigensystem realisation that must agree."""
MOST_LINES: Final = 1500
LONGEST_STEP: Final = 1e-4
"""Integration step [s] for modes up to about 600 Hz; its error there is 2e-4 of the frequency, by the fourth power."""
FOLLOWED: Final = 900.0
"""Highest frequency of a band [Hz] up to which that step serves."""
GROWS: Final = 1e-3
"""Growth rate [1/s] from which a machine counts as unstable; neutral pressures stay below it."""
HIGHEST_DAMPING: Final = 0.5
"""Damping ratio above which a pole is no mode to identify."""
FAINT: Final = 1e-3
"""Share of the strongest oscillation in a decay, from which on one counts: what is fainter is distortion."""
NEAR: Final = 0.1
"""Relative distance in frequency at which a computed mode becomes unlikely to be the one that was found."""
DECAYED: Final = 14.0
"""Time constants after which a motion counts as over: 1e-6 is left."""


@dataclass(frozen=True)
class Identified:
    """A mode found in signals.

    ``frequency`` is |λ|/2π [Hz], ``shape`` that of the mount plane's centre (6,) [m, rad], its largest part one.
    Spreads are standard deviations over model orders and records. ``computed`` is the mode that it is most like,
    ``likeness`` the MAC of both shapes; None: there is none.
    """

    name: str
    frequency: float
    damping_ratio: float
    shape: ComplexArray
    frequency_spread: float
    damping_spread: float
    computed: Mode | None
    likeness: float

    def to_dict(self) -> dict[str, Any]:
        """As plain data, the computed values beside it."""
        return {
            "name": self.name,
            "frequency_hz": self.frequency,
            "frequency_spread_hz": self.frequency_spread,
            "damping_ratio": self.damping_ratio,
            "damping_ratio_spread": self.damping_spread,
            "shape": {dof: [part.real, part.imag] for dof, part in zip(DOFS, self.shape.tolist(), strict=True)},
            "mac": self.likeness,
            "computed_frequency_hz": self.computed and self.computed.frequency,
            "computed_damping_ratio": self.computed and self.computed.damping_ratio,
        }


@dataclass(frozen=True)
class ModalTest:
    """What a test found, by frequency, how it was done, and the names of computed modes that it missed."""

    kind: Kind
    modes: tuple[Identified, ...]
    missed: tuple[str, ...]
    words: str

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        found = [mode.to_dict() for mode in self.modes]
        return {"kind": self.kind, "method": self.words, "modes": found, "missed": list(self.missed)}


def kind_of(name: str) -> Kind:
    """The kind of measurement of this name.

    Raises:
        InputError: if there is none.
    """
    for kind in KINDS:
        if kind == name:
            return kind
    raise InputError(f"measured = {name!r}: must be one of {', '.join(KINDS)}")


def modal_test(scenario: Scenario, kind: Kind, noise: float = 0.0, realisations: int | None = None) -> ModalTest:
    """Identify the machine's modes from a simulated measurement, valves held.

    Args:
        scenario: the machine; its ground, control and forces are replaced.
        kind: ``ring-down``: a jolt of the floor in all directions, then free decay. ``random``: periodic noise of the
            floor (a multisine of random phases), ``sweep``: an exponential sweep of the floor, one degree of freedom
            after the other; the feet's motion over the floor's is fitted. ``hammer``: blows on an upper corner of the
            machine in x, y and z, one after the other; the feet's velocity over the force is fitted.
        noise: RMS of white noise on every measured channel, over that channel's own RMS [-].
        realisations: records, which differ in noise and random phases; without, 3 where there is noise, else 1.

    Raises:
        InputError: if an argument is impossible, the machine is unstable, or its modes lie too far apart for one
            measurement.
    """
    kind_of(kind)
    if not 0.0 <= noise < 1.0:
        raise InputError(f"noise = {noise:g}: must be from 0 up to 1, as a share of the signal")
    if realisations is None:
        realisations = 3 if noise > 0.0 else 1
    if realisations < 1:
        raise InputError(f"realisations = {realisations}: must be at least 1")
    still = _still(scenario)
    model = linear_model(still.plant)
    growth = float(np.linalg.eigvals(model.A).real.max())
    if growth > GROWS:
        raise InputError(f"the machine is unstable with its valves held, it moves away as exp({growth:.3g} t): no test")
    computed = tuple(mode for mode in modes(model) if mode.machine_moves)
    if not computed:
        raise InputError("the machine has no oscillation: there is nothing to identify")
    plan = _Plan.of(computed)
    if kind == "ring-down":
        fits, words = _ring(still, plan, realisations, noise)
    else:
        fits, words = _responses(still, kind, plan, realisations, noise)
    found = agreed(fits)
    named, missed = _named(still.machine, found, computed)
    return ModalTest(kind, named, missed, words)


def _still(scenario: Scenario) -> Scenario:
    """The machine alone, with its plates tied where their feet are rigid: the same equations."""
    table = scenario.model_dump() | {
        "control": {"kind": "passive"},
        "ground": {"kind": "rest"},
        "compare": (),
        "force": (),
    }
    return parse_scenario(table | {"plates": reduced(scenario.plant).plates})


@dataclass(frozen=True)
class _Plan:
    """Settings of a measurement: band [Hz], spacing of its lines [Hz], decay rate of the slowest mode [1/s]."""

    low: float
    high: float
    spacing: float
    decay: float

    @classmethod
    def of(cls, computed: Sequence[Mode]) -> "_Plan":
        frequencies = [mode.frequency for mode in computed]
        # Two lines or so within the half-power width 2ζf of the sharpest mode.
        sharpest = min(2.0 * mode.damping_ratio * mode.frequency for mode in computed)
        spacing = 1.0 / math.ceil(1.0 / (0.6 * sharpest) * 100.0) * 100.0 if sharpest < 60.0 else 40.0
        low = max(spacing, 0.4 * min(frequencies))
        high = 1.45 * max(frequencies)
        decay = min(2 * np.pi * mode.damping_ratio * mode.frequency for mode in computed)
        if (high - low) / spacing > MOST_LINES:
            raise InputError(
                f"the machine's modes, {min(frequencies):.3g} to {max(frequencies):.3g} Hz with half-power widths down "
                f"to {sharpest:.3g} Hz, need {(high - low) / spacing:.0f} lines; one measurement has up to {MOST_LINES}"
            )
        return cls(low, high, spacing, decay)

    @property
    def step(self) -> float:
        """Integration step, and recording period of responses [s]."""
        return LONGEST_STEP / math.ceil(self.high / FOLLOWED)

    @property
    def lines(self) -> Array:
        """Lines of the band [Hz], multiples of the spacing."""
        first, last = math.ceil(self.low / self.spacing), math.floor(self.high / self.spacing)
        return self.spacing * np.arange(first, last + 1, dtype=np.float64)


# --- ring-down ----------------------------------------------------------------------------------------------------


def _ring(scenario: Scenario, plan: _Plan, realisations: int, noise: float) -> tuple[list[Estimates], str]:
    rate = 1000.0 * math.ceil(5.0 * plan.high / 1000.0)
    duration = math.ceil(1.4 / plan.decay * 1000.0) / 1000.0
    decays = free_decays(scenario, duration, rate, plan.step)
    fits = []
    for k in range(realisations):
        noisy = _with_noise(decays, noise, scenario.seed, k)
        size = np.abs(noisy).max(axis=(0, 1))
        for poles, shapes in realise(noisy / size, rate, RING_ORDERS):
            strength = np.abs(shapes).max(axis=0)
            strong = strength > FAINT * strength.max()
            fits.append(_in_band(poles[strong], size[:, None] * shapes[:, strong], plan))
    words = f"free decays of {duration:g} s after a jolt of the floor in each direction"
    words += f", eigensystem realisation, {len(fits)} fits"
    return fits, words


# --- responses of the feet ----------------------------------------------------------------------------------------


def _responses(
    scenario: Scenario, kind: Kind, plan: _Plan, realisations: int, noise: float
) -> tuple[list[Estimates], str]:
    inputs = AXES if kind == "hammer" else DOFS
    runs = simulate_many(
        _excited(scenario, kind, plan, name, realisation) for realisation in range(realisations) for name in inputs
    )
    fits, to_centre = [], np.linalg.pinv(_levers(scenario.plant))
    for realisation in range(realisations):
        own = runs[realisation * len(inputs) : (realisation + 1) * len(inputs)]
        columns = [
            _response(run, name, kind, plan, noise, [scenario.seed, realisation, k])
            for k, (run, name) in enumerate(zip(own, inputs, strict=True))
        ]
        response = np.stack(columns, axis=-1)
        if kind != "hammer":
            response = response / _scales(scenario.plant)
        for order in (count // len(inputs) for count in POLES):
            poles = polyreference(plan.lines, response, order)
            fit = _in_band(poles, np.zeros((1, poles.size), complex), plan)
            shapes = to_centre @ residues(plan.lines, response, fit.poles)
            fits.append(Estimates(fit.poles, shapes))
    signal = {"random": "periodic noise of the floor", "sweep": "sweep of the floor", "hammer": "hammer on a corner"}
    band = f"{plan.lines[0]:.0f} to {plan.lines[-1]:.0f} Hz, lines {plan.spacing:.3g} Hz apart"
    return fits, f"{signal[kind]}, {band}, pLSCF, {len(fits)} fits of {realisations} records"


def _in_band(poles: ComplexArray, shapes: ComplexArray, plan: _Plan) -> Estimates:
    found = oscillating(poles, shapes, 2 * np.pi * plan.low)
    size = np.abs(found.poles)
    kept = (size < 2 * np.pi * plan.high) & (-found.poles.real < HIGHEST_DAMPING * size)
    return Estimates(found.poles[kept], found.shapes[:, kept])


def _scales(plant: Plant) -> Array:
    """By what each degree of freedom of the floor is divided, so that the mounts move alike: 1, or a distance [m]."""
    distance = float(np.sqrt(np.mean(np.sum(np.array(plant.positions) ** 2, axis=1))))
    return np.array([1.0] * 3 + [distance] * 3)


def _levers(plant: Plant) -> Array:
    """Motion of the feet, mount by mount in x, y, z, per degree of freedom, (12, 6)."""
    return np.array([point_row((*place, 0.0), axis) for place in plant.positions for axis in range(len(AXES))])


def _excited(scenario: Scenario, kind: Kind, plan: _Plan, name: str, realisation: int) -> Scenario:
    """The run in which one input, a direction of the floor or of the hammer, excites the machine."""
    over = math.ceil(DECAYED / plan.decay * plan.spacing) / plan.spacing  # whole periods
    table = scenario.model_dump() | {"record_rate": 1.0 / plan.step, "timestep": plan.step}
    if kind == "hammer":
        length, width, height = scenario.machine.size
        blow = {"kind": "hammer", "point": [0.45 * length, 0.45 * width, 0.9 * height], "peak": BLOW}
        blow["direction"] = [float(axis == name) for axis in AXES]
        blow |= {"begin": 10 * plan.step, "pulse_time": plan.step * max(4, round(BLOW_WIDTH / plan.high / plan.step))}
        return parse_scenario(table | {"force": [blow], "duration": over})
    scale = float(_scales(scenario.plant)[DOFS.index(name)])
    ground: dict[str, Any]
    if kind == "random":
        f = plan.lines
        random = np.random.default_rng([scenario.seed, realisation, DOFS.index(name)])
        phases = random.uniform(0.0, 2.0 * np.pi, f.size)
        ground = {"kind": "multisine", "frequencies": f.tolist(), "phases": phases.tolist()}
        ground["velocities"] = [LEVEL / scale]
        duration = over + 1.0 / plan.spacing
    else:
        growth = math.log(plan.high / plan.low)
        turns = math.ceil(2.0 * (plan.high - plan.low) / growth)  # whole turns: the sweep ends where it began
        time = turns * growth / (plan.high - plan.low)
        ground = {"kind": "sweep", "first": plan.low, "last": plan.high, "sweep_time": time}
        ground["amplitude"] = SWEEP_SPEED / (2 * np.pi * plan.high) / scale
        duration = math.ceil(time * plan.spacing) / plan.spacing + over
    return parse_scenario(table | {"ground": {**ground, "dof": name}, "duration": duration})


def _response(run: Result, name: str, kind: Kind, plan: _Plan, noise: float, seed: list[int]) -> ComplexArray:
    """Motion of the feet over that of the floor in one degree of freedom, or over the force, (line, 12)."""
    time, rate = run.dataset.sizes["time"], run.scenario.record_rate
    # Of noise, one period; of what begins and ends at rest, everything. Velocities are as large in one line as in the
    # other, but a sweep's floor ends with a jump of velocity: displacements there.
    count = round(rate / plan.spacing) if kind == "random" else time - 1
    motion = "displacement" if kind == "sweep" else "velocity"
    feet = run.dataset[f"foot_{motion}"].values.reshape(time, -1)[-count:]
    if kind == "hammer":
        given = run.dataset["external_force"].values[-count:, DOFS.index(name)]
    else:
        floor = run.dataset[f"ground_{motion}"].values.reshape(time, -1)[-count:]
        given = floor @ np.linalg.pinv(_levers(run.scenario.plant)).T[:, DOFS.index(name)]
    answers = _with_noise(feet - feet[-1], noise, *seed)
    index = np.round(plan.lines * count / rate).astype(int)
    return np.asarray(np.fft.rfft(answers, axis=0)[index] / np.fft.rfft(given)[index, None])


def _with_noise(signals: Array, share: float, *seed: int) -> Array:
    if share == 0.0:
        return signals
    random = np.random.default_rng(list(seed)).normal(size=signals.shape)
    own = np.sqrt(np.mean(signals**2, axis=tuple(range(signals.ndim - 1))))
    return np.asarray(signals + share * own * random)


# --- names --------------------------------------------------------------------------------------------------------


def _named(
    machine: Machine, found: Sequence[Stable], computed: Sequence[Mode]
) -> tuple[tuple[Identified, ...], tuple[str, ...]]:
    """Each mode found under the name of the computed one that it is most like in shape and frequency."""
    shapes = np.array([mode.shape for mode in found]).T.reshape(len(DOFS), len(found))
    expected = np.array([mode.shape for mode in computed]).T
    lever = np.array([point_row(machine.cg, axis) for axis in range(len(AXES))] + [*np.eye(len(DOFS))[3:]])
    alike = mac(lever @ shapes, lever @ expected, weights(machine))
    apart = np.log(np.array([[abs(m.pole) / (2 * np.pi * c.frequency) for c in computed] for m in found]))
    likeness = alike * np.exp(-((apart.reshape(alike.shape) / NEAR) ** 2))
    pairs = {int(r): int(c) for r, c in zip(*linear_sum_assignment(-likeness), strict=True) if likeness[r, c] > 0.1}
    named = []
    for k, mode in enumerate(found):
        partner = computed[pairs[k]] if k in pairs else None
        shape = mode.shape / mode.shape[np.argmax(np.abs(mode.shape))]
        size = abs(mode.pole)
        named.append(
            Identified(
                partner.name if partner else f"unknown at {size / (2 * np.pi):.0f} Hz",
                size / (2 * np.pi),
                -mode.pole.real / size,
                shape,
                mode.frequency_spread,
                mode.damping_spread,
                partner,
                float(alike[k, pairs[k]]) if partner else 0.0,
            )
        )
    return tuple(named), tuple(mode.name for k, mode in enumerate(computed) if k not in pairs.values())
