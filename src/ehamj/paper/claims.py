"""What the paper states in words, and what the numbers say to it."""

import math
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np

from ehamj.paper.actuator import bode, delta_h, omega_h
from ehamj.paper.cases import PaperCase, PaperStudy


class Claim(NamedTuple):
    """One statement of the paper in words, and what the numbers say to it.

    In `CLAIMS` the finding has places for the figures of merit of each case by name, and for `_further`.
    """

    section: str
    statement: str
    finding: str


CLAIMS: Final = (
    Claim(
        "2.2",
        "Eq. 8, as printed",
        "The damping term lacks its s. As printed it adds a time to a number; taken as numbers it is an undamped "
        "resonance, {printed_shifts} % above ω_h for the initial and the recommended design, with an infinite peak and "
        "a jump in phase, and −180° would be passed at {printed_crossings}. The paper's own frequencies do not come "
        "from it; the term must read 2δ_h s/ω_h.",
    ),
    Claim(
        "3 to 5",
        "Hydro-mechanical frequencies of 257, 182, 363, 513, 128 and 726 Hz",
        "All six follow from one initial frequency between {six_low:.2f} and {six_high:.2f} Hz. Table I as printed "
        "gives {initial.omega_h_hz:.2f} Hz, {six_short:.1f} % less; its rounding (the bulk modulus has two digits) "
        "leaves ten times that open.",
    ),
    Claim(
        "3",
        "One actuator under a machine load of 4 tonnes",
        "The whole machine on one actuator. A mount of four carries a quarter: {quarter.omega_h_hz:.0f} Hz and a "
        "damping ratio of {quarter.delta_h:.3f}, so the paper's numbers are not those of the four-mount machine.",
    ),
    Claim(
        "3",
        "The closed-loop bandwidth is limited by the lesser of valve and hydro-mechanical frequency",
        "As a limit, yes: with the highest proportional gain with {study.gain_margin_db:g} dB and "
        "{study.phase_margin_deg:g}°, {initial.bandwidth_hz:.0f} Hz of {initial.valve_hz:.0f} Hz for the initial "
        "design and {recommended.bandwidth_hz:.0f} Hz of {recommended.valve_hz:.0f} Hz for the recommended one. But "
        "the loop corrects errors only up to its gain crossover, {initial.gain_crossover_hz:.0f} and "
        "{recommended.gain_crossover_hz:.0f} Hz.",
    ),
    Claim(
        "3",
        "With the valve at ±90 % control stays below 100 Hz",
        "The same loop then has {initial_large_signal.bandwidth_hz:.0f} Hz of bandwidth (3 dB below a static gain that "
        "is itself below 1) and its gain crossover at {initial_large_signal.gain_crossover_hz:.0f} Hz.",
    ),
    Claim(
        "4.1",
        "A larger chamber lowers the bandwidth",
        "{volume_double.bandwidth_hz:.0f} Hz with twice the volume, {initial.bandwidth_hz:.0f} Hz as it is, "
        "{volume_half.bandwidth_hz:.0f} Hz with half.",
    ),
    Claim(
        "4.2",
        "A larger piston is preferable although it lowers the damping",
        "Damping ratio {area_double.delta_h:.3f} instead of {initial.delta_h:.3f}; gain crossover "
        "{area_double.gain_crossover_hz:.0f} instead of {initial.gain_crossover_hz:.0f} Hz. Merritt's limit "
        "2δ_hω_h = 4βK_C/V_t does not know the area.",
    ),
    Claim(
        "4.3",
        "The flow gain is a gain only",
        "Halving it moves the gain margin by {halved_margin:+.2f} dB and the crossover by {halved_crossover:.2g} Hz.",
    ),
    Claim(
        "4.3",
        "Damping is proportional to the flow-pressure coefficient",
        "{flow_pressure_half.delta_h:.4f}, {initial.delta_h:.4f}, {flow_pressure_double.delta_h:.4f}.",
    ),
    Claim(
        "5",
        "Small chamber, large piston and high flow-pressure coefficient together make the loop fast",
        "Gain crossover {initial.gain_crossover_hz:.0f} Hz initially, {area_double.gain_crossover_hz:.0f} Hz with the "
        "piston alone, {tight.gain_crossover_hz:.0f} Hz with piston and chamber, "
        "{recommended.gain_crossover_hz:.0f} Hz with all three: it is the piston that does it, and with it the "
        "additional leakage costs a little.",
    ),
    Claim(
        "5",
        "A gain margin of 128 dB is far superior to 116 dB",
        "Their difference comes out ({margin_gained:.1f} dB), but {slower:.1f} dB of it only say that a piston of "
        "twice the area moves half as fast per volt. What a loop gains is its velocity gain at the limit: "
        "{initial.velocity_gain_limit:.0f} and {recommended.velocity_gain_limit:.0f} 1/s.",
    ),
    Claim(
        "5",
        "Gain margins of 116 and 128 dB",
        "Table I gives {over_116:.1f} and {over_128:.1f} dB more: a factor of ten in loop gain. With ten times the "
        "flow gain and a valve of 260 Hz margins and frequencies come out ({initial_reading.gain_margin_db:.1f} dB at "
        "{initial_reading.phase_crossover_hz:.1f} Hz, {recommended_reading.gain_margin_db:.1f} dB at "
        "{recommended_reading.phase_crossover_hz:.1f} Hz). Table I stays the default.",
    ),
    Claim(
        "5",
        "A valve of 400 Hz makes it better still",
        "Bandwidth {recommended_fast_valve.bandwidth_hz:.0f} instead of {recommended.bandwidth_hz:.0f} Hz, gain "
        "crossover {recommended_fast_valve.gain_crossover_hz:.0f} instead of {recommended.gain_crossover_hz:.0f} Hz.",
    ),
    Claim(
        "5",
        "The frequencies of the recommended design are very well separated",
        "By a factor of {separation:.1f}, with the valve below the load. Valve makers ask for three times above it; "
        "here it is {recommended.valve_ratio:.2f} ({recommended_fast_valve.valve_ratio:.2f} with the faster valve).",
    ),
)
"""Every statement that the numbers can answer."""


def claims(study: PaperStudy, every: Mapping[str, PaperCase]) -> tuple[Claim, ...]:
    """The statements with their findings.

    Args:
        study: what was computed.
        every: cases and variants by name.
    """
    merits: dict[str, Any] = {name: case.merits for name, case in every.items()}
    values = merits | _further(study, merits)
    return tuple(claim._replace(finding=claim.finding.format_map(values)) for claim in CLAIMS)


def _further(study: PaperStudy, merits: Mapping[str, Any]) -> dict[str, Any]:
    """What the findings need beside the figures of merit of the cases."""
    first, last, halved = (merits[name] for name in ("initial", "recommended", "flow_gain_half"))
    low, high = _one_for_all_six()
    shifts, crossings = zip(*(_as_printed(study, name) for name in ("initial", "recommended")), strict=True)
    leakage = {"flow_pressure": study.actuator.flow_pressure}
    return {
        "study": study,
        "quarter": study.merits(study.design("initial"), study.mass / 4.0),
        "tight": study.merits(study.design("recommended").with_values(leakage), study.mass),
        "halved_margin": halved.gain_margin_db - first.gain_margin_db,
        "halved_crossover": halved.phase_crossover_hz - first.phase_crossover_hz,
        "margin_gained": last.gain_margin_db - first.gain_margin_db,
        "slower": 20.0 * math.log10(first.velocity_gain / last.velocity_gain),
        "over_116": first.gain_margin_db - 116,
        "over_128": last.gain_margin_db - 128,
        "separation": 1 / last.valve_ratio,
        "six_low": low,
        "six_high": high,
        "six_short": 100 * (low / first.omega_h_hz - 1),
        "printed_shifts": " and ".join(f"{shift:.3f}" for shift in shifts),
        "printed_crossings": " and ".join(f"{crossing:.0f} Hz" for crossing in crossings),
    }


def _as_printed(study: PaperStudy, name: str) -> tuple[float, float]:
    """Of eq. 8 to the letter: by how much its resonance lies above ω_h [%], and where its phase passes −180° [Hz]."""
    design = study.design(name)
    w, d = omega_h(design, study.mass), delta_h(design, study.mass)
    hertz = np.linspace(1.0, w / (2.0 * math.pi), 20001)[:-1]  # below the resonance its pole pair adds no phase
    _, phase = bode(design, study.mass, hertz, "eq8-printed")
    return 100.0 * (math.sqrt(1.0 + 2.0 * d / w) - 1.0), float(np.interp(180.0, -phase, hertz))


def _one_for_all_six() -> tuple[float, float]:
    """Between which initial frequencies all six printed ones come out [Hz]."""
    ratios = {257: 1.0, 182: 2**-0.5, 363: 2**0.5, 513: 2.0, 128: 0.5, 726: 8**0.5}
    low = max((printed - 0.5) / ratio for printed, ratio in ratios.items())
    high = min((printed + 0.5) / ratio for printed, ratio in ratios.items())
    return low, high
