"""Partial coherence of the floor between mounts (Luco and Wong 1986)."""

import numpy as np
from pydantic import Field

from ehamj.settings import Positive, Settings
from ehamj.signals import Array


class Coherence(Settings):
    """How alike the floor is at two mounts: the coherency's magnitude is exp(−(γ ω d/V_s)²).

    Luco and Wong, *Response of a rigid foundation to a spatially random ground motion*, Earthquake Eng. Struct. Dyn.
    14 (1986), 891-908. It is a magnitude: `scipy.signal.coherence` estimates its square. A wave adds the phase.
    """

    gamma: float = Field(
        0.2, ge=0, description="incoherence γ [-]; Luco and Wong consider 0.1 to 0.5, 0.2 is assumed; 0: fully coherent"
    )
    shear_speed: Positive = Field(200.0, description="shear wave speed of the soil V_s [m/s] (assumed: stiff soil)")

    def magnitude(self, frequency: Array, distance: Array) -> Array:
        """Coherency magnitude at ``frequency`` [Hz] between points ``distance`` [m] apart, broadcast."""
        return np.exp(-((self.gamma * 2.0 * np.pi * frequency * distance / self.shear_speed) ** 2))

    def factor(self, frequency: Array, positions: Array) -> Array:
        """Factor A of the coherency matrix A·Aᵀ at each frequency, shape (n, mount, mount).

        A times as many independent unit lines as there are mounts gives lines that are coherent as stated. It comes
        from eigenvalues, which stays exact where the matrix is singular (mounts that move as one); the strongest
        pattern, in which all mounts move alike, is the last column, with positive sign.

        Args:
            frequency: shape (n,) [Hz].
            positions: of the mounts, shape (mount, 2) [m].
        """
        distance = np.linalg.norm(positions[:, None] - positions, axis=2)
        values, vectors = np.linalg.eigh(self.magnitude(frequency[:, None, None], distance))
        vectors *= np.where(vectors.sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
        return vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
