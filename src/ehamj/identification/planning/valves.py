"""Multisines at the valves, of low peak, as large as valve and machine allow."""

import math
from functools import lru_cache
from typing import Final, Literal

from pydantic import Field

from ehamj.errors import InputError, did_you_mean
from ehamj.identification.planning.candidate import HIGHEST, Bench, CandidateSettings, rounded
from ehamj.identification.planning.limits import reach
from ehamj.identification.planning.trial import Trial
from ehamj.rig.low_peak import LowPeak, Spacing, low_peak, zippered
from ehamj.settings import Band, Positive

BANDS: Final = ((1.0, 10.0), (10.0, 80.0), (80.0, 400.0))
"""Of the usual candidates [Hz]: where oil and leakage are soft, the machine's modes, valve and oil column."""
MOST: Final = 8
"""Mounts up to which each is a candidate of its own."""


class ValveCandidate(CandidateSettings):
    """Multisines at the valves; those of several mounts share no line, so that each can be told apart."""

    kind: Literal["valves"]
    band: Band = Field((1.0, 100.0), description="lowest and highest frequency [Hz]")
    mounts: tuple[str, ...] | None = Field(None, description="mounts that are driven, by name; without: all that obey")
    spacing: Spacing = Field("even", description="how lines lie in the band: even has the lowest peak")
    lines: int = Field(20, ge=1, le=200, description="lines of each mount, at most")
    period: Positive | None = Field(
        None, description="time after which it repeats; without: two periods of the lowest frequency, at least 1 s [s]"
    )
    level: float = Field(0.8, gt=0, le=1, description="share of the first limit that it comes to [-]")
    seed: int = Field(0, ge=0, description="of the phases that the search begins with")

    @classmethod
    def usual(cls, bench: Bench) -> tuple[CandidateSettings, ...]:
        """In three bands, all mounts and each by itself."""
        mounts = bench.machine.plant.obeying.mounts
        bands = [(low, min(high, HIGHEST * bench.rate)) for low, high in BANDS if low < 0.5 * HIGHEST * bench.rate]
        each = [(mount,) for mount in mounts] if 1 < len(mounts) <= MOST else []
        return tuple(
            cls(kind="valves", band=band, mounts=chosen)
            for band in bands
            for chosen in ([None, *each] if mounts else [])
        )

    def trial(self, bench: Bench) -> Trial:
        """See `CandidateSettings.trial`."""
        known = bench.machine.plant.obeying.mounts
        chosen = known if self.mounts is None else self.mounts
        for mount in chosen:
            if mount not in known:
                near = did_you_mean(mount, known)
                raise InputError(f"plan.candidates: mounts: {mount!r}: {near}must be one of {', '.join(known)}")
        if not chosen:
            raise InputError("plan.candidates: kind = 'valves': no mount obeys commands; leave these candidates out")
        if self.band[1] > 0.5 * bench.rate:
            raise InputError(
                f"plan.candidates: band = {list(self.band)} Hz: must end below half of plan.rate = {bench.rate:g} Hz"
            )
        period = self.period or max(1.0, math.ceil(2.0 / self.band[0]))
        if 2.0 * period > bench.duration:
            raise InputError(
                f"plan.candidates: period = {period:g} s: must fit twice into plan.duration = {bench.duration:g} s, "
                "once to settle and once to be compared"
            )
        signals = {
            f"valve_command {mount}": one
            for mount, one in zip(
                chosen, _designs(self.band, period, self.lines, len(chosen), self.spacing, self.seed), strict=True
            )
        }
        found = reach(bench.model, signals, bench.limits)
        played = {name: one.scaled(rounded(self.level * found.factor)) for name, one in signals.items()}
        table = [one.command([name.split(" ", 1)[1]]) for name, one in played.items()]
        whole = math.floor(bench.duration / period + 1e-9) * period
        scenario = bench.quiet(control={"kind": "open-loop", "signals": table}, duration=whole)
        where = "all mounts" if self.mounts is None and len(chosen) > 1 else ", ".join(chosen)
        peak = max(one.peak for one in played.values())
        words = (
            f"multisines {self.band[0]:g}–{self.band[1]:g} Hz at {where}, {len(table[0]['frequencies'])} lines each, "
            f"peak {peak:.3g} V, crest factor {max(one.crest_factor for one in played.values()):.2f}; "
            f"{100 * self.level:.0f} % of what {found.limit} allows"
        )
        called = self.name or f"valves {self.band[0]:g}-{self.band[1]:g} Hz {where}"
        inputs = {name: {"channel": name, "unit": "V"} for name in played}
        return Trial(called, self.kind, words, scenario, "periodic", period, played, seconds=whole, inputs=inputs)


@lru_cache(maxsize=64)
def _designs(
    band: tuple[float, float], period: float, lines: int, channels: int, spacing: Spacing, seed: int
) -> tuple[LowPeak, ...]:
    """Multisines of amplitude one."""
    dealt = zippered(*band, period, lines, channels, spacing)
    return tuple(low_peak(period, own, seed=seed + k) for k, own in enumerate(dealt))
