"""What a machine that is stepped shows at one instant: the channels of a result, of one row."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ehamj.arrays import Array
from ehamj.errors import did_you_mean
from ehamj.forces import Load
from ehamj.ground import GroundSample
from ehamj.memory import COMMAND
from ehamj.mujoco.rows import Rows
from ehamj.plant.kinematics import points_moved
from ehamj.run.drive import Driving
from ehamj.run.faults import Struck
from ehamj.run.held import Held
from ehamj.run.observe import Channels, Observing
from ehamj.run.prepare import Prepared
from ehamj.variables import FIXED, MOTIONS, VARIABLES, labels_of


class Instant(Observing):
    """Channels at one instant by their names in a result (`ehamj.variables`), each of one row, made when asked for."""

    def __init__(
        self, prepared: Prepared, row: Rows, struck: Sequence[Struck], time: float, driving: Driving, held: Held,
        load: Load,
    ) -> None:  # fmt: skip
        """What was recorded.

        Args:
            prepared: what is stepped.
            row: the one row.
            struck: faults until then.
            time: of the row [s].
            driving: of the step that begins at the instant.
            held: since the instant before.
            load: what the scenario's own forces are, about the machine's centre of gravity.
        """
        super().__init__(prepared, row, struck)
        self.times = np.array([time])
        self._held, self._own_load = held, load
        points = driving.inputs[0][:, : len(held.commands), :COMMAND]
        self._ground_now = GroundSample(points[..., 0], points[..., 1] / prepared.timestep, points[..., 2])

    @property
    def time(self) -> float:
        """[s]"""
        return float(self.times[0])

    @property
    def _sampled(self) -> GroundSample:
        return self._ground_now

    @property
    def _pushed(self) -> bool:
        return True

    def _load(self) -> Array:
        return self._own_load.sample(self.times)[0] + self._held.force

    def _moved(self, order: int, place: str) -> Channels:
        """All motions of all places at once: of one row that takes no longer."""
        own = {name: len(points) for name, points in self._places.items()}
        motions = [self._machine(k) for k in range(len(MOTIONS))]
        moved = points_moved(motions, [point for points in self._places.values() for point in points])
        found, first = Channels(), 0
        for name, count in own.items():
            found |= self._named(name, [motion[first : first + count] for motion in moved])
            first += count
        return found

    def value(self, name: str, *labels: Any) -> Any:
        """A channel, or one number of it: ``value("foot_velocity", "front-left", "z")``; in SI as in a result.

        Raises:
            KeyError: if there is no such channel, or its labels are others.
        """
        if name not in self:
            raise KeyError(f"{name}: {did_you_mean(name, self)}must be one of {', '.join(self)}")
        found, along = self[name][0], FIXED | labels_of(self._scenario, self._prepared.controller)
        if len(labels) > len(VARIABLES[name][0]):
            raise KeyError(f"{name}: has {len(VARIABLES[name][0])} labels, {', '.join(VARIABLES[name][0]) or 'none'}")
        for label, dimension in zip(labels, VARIABLES[name][0], strict=False):
            if label not in along[dimension]:
                raise KeyError(f"{name}: {label!r} is none of {', '.join(map(str, along[dimension]))}")
            found = found[list(along[dimension]).index(label)]
        return found
