"""A sensor in the floor that a wave reaches before the machine, and when it reaches the mounts, as is believed."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from ehamj.arrays import Array
from ehamj.ground.waves import Wave
from ehamj.settings import Settings, Vector3


class Upstream(Settings):
    """Where it stands, and what is believed of the wave that it is there for. It is the instrument of every ground_…
    channel, and gives ``ground_velocity upstream z``: what the floor does there, whatever is believed."""

    position: Vector3 = Field(description="x, y, z from the mount plane's centre [m]")
    wave: Wave = Field(
        description="the wave that is expected; the law takes it from here, the floor moves as [ground] says"
    )

    @property
    def said(self) -> str:
        """Where it stands and what is believed, in words."""
        x, y, z = self.position
        wave = f"a wave towards {self.wave.direction:g}° at {self.wave.speed:g} m/s"
        return f"at {x:g}, {y:g}, {z:g} m, for {wave}"

    def times(self, positions: ArrayLike) -> Array:
        """Time from the sensor to each of some ``positions`` (n, 3) [m], as is believed [s]."""
        places = np.asarray(positions, float).reshape(-1, len(self.position))
        return self.wave.delays(places) - self.wave.delays(np.array([self.position]))

    def check(self, names: Sequence[str], positions: ArrayLike) -> None:
        """Refuse a sensor that the wave does not reach before each mount.

        Raises:
            ValueError: naming the mount.
        """
        times = self.times(positions)
        first = int(np.argmin(times))
        if not times[first] > 0.0:
            raise ValueError(
                f"sensors.upstream.position = {list(self.position)}: a wave towards {self.wave.direction:g}° reaches "
                f"it {-1e3 * times[first]:.3g} ms after mount {names[first]}; it must stand where the wave comes from"
            )
