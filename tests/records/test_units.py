"""The one table of units: every spelling of every prefix of every quantity, and what is none."""

import string

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.records.units import density_unit, is_silent, motion_unit, time_unit, unit

PREFIXES = {"": 1.0, "k": 1e3, "c": 1e-2, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "n": 1e-9, "p": 1e-12}
LONG = {"": 1.0, "kilo": 1e3, "centi": 1e-2, "milli": 1e-3, "micro": 1e-6, "nano": 1e-9}
LENGTHS = {"m": PREFIXES, "metre": LONG, "meters": LONG}
OTHERS = {"in": 0.0254, "inch": 0.0254, "ft": 0.3048, "mil": 2.54e-5, "micron": 1e-6}
SECONDS = ("s", "sec", "second", "seconds", "sec.")
QUANTITIES = ("displacement", "velocity", "acceleration")
SQUARES = ("^2", "**2", "2", "²", " ** 2", "^(2)")
BRACKETS = ("{}", "[{}]", "({})", " {} ", '"{}"', "[ ({}) ]")


def per_second(order: int) -> st.SearchStrategy[str]:
    """Every way to divide by seconds, once or twice."""
    if order == 0:
        return st.just("")
    below = st.sampled_from(SECONDS).flatmap(
        lambda s: st.sampled_from([f"/{s}", f" / {s}", f" per {s}"] if order == 1 else [f"/{s}/{s}", f"/({s}*{s})"])
    )
    if order == 1:
        powers = st.sampled_from([" s-1", " s^-1", "·s⁻¹", "*s**-1", "s-1", "s⁻¹"])
        return below | powers
    squared = st.sampled_from(SECONDS[:-1]).flatmap(
        lambda s: st.sampled_from(SQUARES).flatmap(lambda two: st.sampled_from([f"/{s}{two}", f"/({s}{two})"]))
    )
    powers = st.sampled_from([" s-2", " s^-2", "·s⁻²", "*s**-2", "s-2", "s⁻²"])
    return below | squared | powers


@st.composite
def motion_units(draw: st.DrawFn) -> tuple[str, str, float]:
    """A unit as somebody might write it, what it is of, and its SI value."""
    order = draw(st.integers(0, 2))
    tail = draw(per_second(order))
    if draw(st.booleans()):
        name, prefixes = draw(st.sampled_from(list(LENGTHS.items())))
        prefix = draw(st.sampled_from(list(prefixes)))
        text, size = prefix + name, prefixes[prefix]
        if name != "m" and tail[:1] == "s":  # metress-2 is nobody's
            tail = " " + tail
    else:
        text, size = draw(st.sampled_from(list(OTHERS.items())))
        tail = " " + tail if tail[:1] == "s" else tail
    text = draw(st.sampled_from(BRACKETS)).format(text + tail)
    if draw(st.booleans()):
        text = "".join(c.upper() if c in string.ascii_lowercase else c for c in text)
    return text, QUANTITIES[order], size


@given(motion_units())
def test_every_spelling_of_every_prefix_of_every_quantity(case: tuple[str, str, float]) -> None:
    text, quantity, size = case
    # A product of at most three factors: rounding of the last digit.
    assert motion_unit(text) == (quantity, pytest.approx(size, rel=1e-15))


@pytest.mark.parametrize(
    ("text", "size"),
    {
        **{"g": 9.80665, "G": 9.80665, "mg": 9.80665e-3, "MG": 9.80665e-3, "µg": 9.80665e-6, "ng": 9.80665e-9},
        **{"gn": 9.80665, "Gal": 1e-2, "mGal": 1e-5, "cm/s/s": 1e-2, "in/s^2": 0.0254, "[mm/s²]": 1e-3},
    }.items(),
)
def test_accelerations_by_their_own_names(text: str, size: float) -> None:
    assert motion_unit(text) == ("acceleration", pytest.approx(size, rel=1e-15))


def test_velocities_by_their_own_names() -> None:
    assert motion_unit("ips") == ("velocity", 0.0254)
    assert motion_unit("kine") == ("velocity", 1e-2)


@pytest.mark.parametrize(
    ("text", "size"),
    {
        **{"s": 1.0, "sec": 1.0, "[ms]": 1e-3, "MS": 1e-3, "msec": 1e-3, "µs": 1e-6, "ns": 1e-9},
        **{"min": 60.0, "h": 3600.0, "seconds": 1.0, "(milliseconds)": 1e-3},
    }.items(),
)
def test_times(text: str, size: float) -> None:
    assert time_unit(text) == pytest.approx(size, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["Nm", "kg", "MHz", "m/s*s", "m/s^-2", "m/s 2", "m/s^2 RMS", "mm/s peak", "%", "", "°C"]
)
@pytest.mark.parametrize("reader", [unit, motion_unit, time_unit, density_unit])
def test_what_could_be_read_in_two_ways_or_in_none_is_refused(text: str, reader: object) -> None:
    with pytest.raises(ValueError, match="known are") as caught:
        reader(text)  # type: ignore[operator]
    assert repr(text.strip()) in str(caught.value)


@given(st.text(max_size=20))
def test_any_text_is_a_unit_or_a_refusal(text: str) -> None:
    try:
        found = f"known are {unit(text).size}"
    except ValueError as error:
        found = str(error)
    assert "known are" in found


@pytest.mark.parametrize(("text", "way_out"), [("counts", "what one is with ground"), ("mV", "what 1 V stands for")])
def test_counts_and_volts_are_known_but_no_motion(text: str, way_out: str) -> None:
    with pytest.raises(ValueError, match=way_out):
        motion_unit(text)
    with pytest.raises(ValueError, match="is of time"):
        motion_unit("ms")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("(m/s)^2/Hz", ("velocity", 1.0, False)),
        ("(mm/s^2)^2/Hz", ("acceleration", 1e-3, False)),
        ("g^2/Hz", ("acceleration", 9.80665, False)),
        ("m^2/s^4/Hz", ("acceleration", 1.0, False)),
        ("µm²/Hz", ("displacement", 1e-6, False)),
        ("um/s/sqrt(Hz)", ("velocity", 1e-6, True)),
        ("ng/√Hz", ("acceleration", 9.80665e-9, True)),
        ("m/s²/√(Hz)", ("acceleration", 1.0, True)),
    ],
)
def test_spectral_densities_and_their_roots(text: str, found: tuple[str, float, bool]) -> None:
    quantity, size, root = density_unit(text)
    assert (quantity, root) == (found[0], found[2])
    assert size == pytest.approx(found[1], rel=1e-14)  # a square root of a square


@pytest.mark.parametrize("text", ["m/s", "m/Hz", "s^2/Hz", "Hz"])
def test_other_powers_are_no_densities(text: str) -> None:
    with pytest.raises(ValueError, match=r"is not \(U\)\^2/Hz"):
        density_unit(text)


@pytest.mark.parametrize("text", [None, "", " ", "NONE", "none", "-", "N/A", "[]", '""'])
def test_what_states_no_unit(text: str | None) -> None:
    assert is_silent(text)
    assert not is_silent("m")
