"""A frequency response as its file has it, before anything of it is judged."""

from dataclasses import dataclass, field

from ehamj.arrays import Array, ComplexArray


@dataclass(frozen=True)
class RawResponse:
    """One response: ``values`` (f,) at ``frequency`` [Hz] (f,)."""

    output: str
    """Of a file that names its places, such as ``12:+Z``; of others the key of [test.measurement]."""
    input: str
    frequency: Array = field(repr=False)
    values: ComplexArray = field(repr=False)
    unit: str | None = None
    """Output's unit over input's, as written; None where none is stated."""
    coherence: Array | None = field(default=None, repr=False)
    """γ² (f,)."""
    word: str = ""
    """What messages call it, where that is not output over input."""

    motion: str = ""
    """What the output is by its data type, where no unit is stated: displacement, velocity or acceleration over a
    force; of others ""."""

    @property
    def told(self) -> str:
        """What messages call it."""
        return self.word or f"{self.output} over {self.input}"
