"""The least deviations that any unbiased estimate can have (Cramér 1946, Rao 1945), at the true values.

It knows the noise and shares nothing with what it judges but the engine: differences are its own, of the true machine.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from ehamj.rig.measurement import channel
from ehamj.run.many import observe_many
from ehamj.run.simulate import Observed
from ehamj.scenario.model import Scenario

DERIVED = 1e-4
"""Step of the runs that are differenced [s]."""
STEP = 2e-3
"""Of differences, over the value; of what may be zero in its own unit."""


def bound(
    runs: Mapping[str, Scenario],
    keys: Sequence[str],
    seen: Mapping[str, Sequence[str]],
    noise: Callable[[str, np.ndarray], float],
) -> dict[str, float]:
    """Least standard deviation of each value.

    Offsets of strokes are not known.

    Args:
        runs: tests of the true machine, by name.
        keys: of the values.
        seen: channels of each test.
        noise: RMS of white noise of a channel, by its name and samples.
    """
    information = np.zeros((len(keys), len(keys)))
    for name, run in runs.items():
        small, own = run.model_copy(update={"engine": "small-motion", "timestep": DERIVED}), list(seen[name])
        values = [value_of(small, key) for key in keys]
        steps = [STEP * (1.0 if ".cg." in key else abs(value)) for key, value in zip(keys, values, strict=True)]
        moved = [
            small.varied({key: value + sign * step})
            for key, value, step in zip(keys, values, steps, strict=True)
            for sign in (1, -1)
        ]
        at, *near = observe_many([small, *moved], partial(_channels, names=own))
        slopes = (
            np.array([near[2 * k] - near[2 * k + 1] for k in range(len(keys))]) / np.array(steps)[:, None, None] / 2
        )
        free = [k for k, one in enumerate(own) if one.startswith("stroke")]
        slopes[:, free] -= slopes[:, free].mean(axis=2, keepdims=True)
        slopes /= np.array([noise(one, samples) for one, samples in zip(own, at, strict=True)])[:, None]
        information += np.einsum("ict,jct->ij", slopes, slopes)
    size = np.sqrt(np.diag(information))
    inverse = np.linalg.inv(information / np.outer(size, size))
    return dict(zip(keys, (np.sqrt(np.diag(inverse)) / size).tolist(), strict=True))


def _channels(run: Observed, names: Sequence[str]) -> np.ndarray:
    return np.array([channel(run.dataset, name) for name in names])


def value_of(scenario: Scenario, key: str) -> float:
    """A value by its key."""
    place = scenario.table
    for part in key.split("."):
        place = place[int(part)] if isinstance(place, list | tuple) else place[part]
    return float(place)  # type: ignore[arg-type]
