"""What mounts in any direction can do together: properties that hold whatever the layout."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ehamj.plant.layout import MOTION_NAMES, Layout


@st.composite
def layouts(draw: st.DrawFn) -> Layout:
    """3 to 12 mounts on a grid of 5 cm; parallel to axes, or anyhow; some passive."""
    n = draw(st.integers(3, 12))
    place = st.tuples(st.integers(-20, 20), st.integers(-15, 15), st.integers(-10, 10))
    positions = 0.05 * np.array(draw(st.lists(place, min_size=n, max_size=n)), float)
    axes = st.sampled_from([(0, 0, 1), (0, 0, 1), (1, 0, 0), (0, -1, 0)])
    anyhow = st.tuples(st.integers(-3, 3), st.integers(-3, 3), st.integers(1, 3))
    ways = np.array(draw(st.lists(axes | anyhow, min_size=n, max_size=n)), float)
    active = draw(st.lists(st.sampled_from([True, True, True, False]), min_size=n, max_size=n))
    return Layout(positions, ways / np.linalg.norm(ways, axis=1)[:, None], tuple(active))


def moved(layout: Layout, motion: np.ndarray) -> np.ndarray:
    """Stroke of each mount under a motion, written out: d·(u + θ × r)."""
    return np.array([
        d @ (motion[:3] + np.cross(motion[3:], r)) for r, d in zip(layout.positions, layout.directions, strict=True)
    ])  # fmt: skip


@settings(max_examples=60)
@given(layouts(), st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6))
def test_rows_are_the_strokes_of_any_motion(layout: Layout, motion: list[float]) -> None:
    np.testing.assert_allclose(layout.rows @ motion, moved(layout, np.array(motion)), rtol=0, atol=1e-14)


@settings(max_examples=60)
@given(layouts())
def test_motions_are_as_many_as_j_has_ranks_and_each_has_its_name_once(layout: Layout) -> None:
    rank = np.linalg.matrix_rank(layout.driven, tol=1e-7)
    assert layout.rank == len(layout.motions) == layout.basis.shape[1] == rank
    assert len(set(layout.motions)) == len(layout.motions)
    assert set(layout.motions) <= set(MOTION_NAMES.values())


@settings(max_examples=60)
@given(layouts())
def test_the_basis_reaches_every_stroke_and_the_fit_takes_it_back(layout: Layout) -> None:
    for column, motion in zip(layout.spread.T, layout.basis.T, strict=True):
        np.testing.assert_allclose(column, np.where(layout.active, moved(layout, motion), 0.0), rtol=0, atol=1e-12)
    np.testing.assert_allclose(layout.fit @ layout.spread, np.eye(layout.rank), rtol=0, atol=1e-6)
    # Every motion of the machine is felt by the mounts as one of the basis.
    np.testing.assert_allclose(layout.spread @ layout.fit @ layout.driven, layout.driven, rtol=0, atol=1e-7)


@settings(max_examples=60)
@given(layouts())
def test_self_stresses_move_nothing_and_are_all_there_is_beside(layout: Layout) -> None:
    n = sum(layout.active)
    assert layout.stresses.shape == (len(layout.active), n - layout.rank)
    assert len(layout.stress_names) == n - layout.rank
    assert np.abs(layout.rows.T @ layout.stresses).max(initial=0.0) < 1e-7
    assert not layout.stresses[~np.array(layout.active)].any()
    np.testing.assert_allclose(layout.stresses.T @ layout.stresses, n * np.eye(n - layout.rank), rtol=0, atol=1e-6 * n)
    assert np.linalg.matrix_rank(layout.pattern_basis, tol=1e-7) == n


@settings(max_examples=60)
@given(layouts(), st.randoms(use_true_random=False))
def test_in_another_order_mounts_have_the_same_rows(layout: Layout, random) -> None:  # type: ignore[no-untyped-def]
    order = list(range(len(layout.active)))
    random.shuffle(order)
    other = Layout(layout.positions[order], layout.directions[order], tuple(layout.active[k] for k in order))
    np.testing.assert_array_equal(other.rows, layout.rows[order])
    assert other.motions == layout.motions
    np.testing.assert_allclose(other.basis, layout.basis, rtol=0, atol=1e-7)
    np.testing.assert_allclose(other.spread, layout.spread[order], rtol=0, atol=1e-7)
    np.testing.assert_allclose(other.fit, layout.fit[:, order], rtol=0, atol=1e-5 * np.abs(layout.fit).max(initial=1.0))
    # The patterns span the same; which of a space are taken may follow the order.
    span = layout.stresses[order] @ layout.stresses[order].T
    np.testing.assert_allclose(other.stresses @ other.stresses.T, span, rtol=0, atol=1e-6 * len(order))


def test_four_upright_mounts_are_the_textbook_s() -> None:
    places = np.array([(0.9, 0.6, 0.0), (0.9, -0.6, 0.0), (-0.9, 0.6, 0.0), (-0.9, -0.6, 0.0)])
    layout = Layout(places, np.tile([0.0, 0.0, 1.0], (4, 1)), (True,) * 4)
    x, y, _ = places.T
    assert layout.motions == ("heave", "roll", "pitch")
    np.testing.assert_allclose(layout.spread, np.column_stack([np.ones(4), y, -x]), rtol=0, atol=1e-15)
    np.testing.assert_allclose(layout.stresses[:, 0], [1.0, -1.0, -1.0, 1.0], rtol=0, atol=1e-15)
    assert layout.patterns == ("heave", "roll", "pitch", "warp")


@pytest.mark.parametrize("active", [(True,) * 6, (True, True, True, False, True, True)])
def test_a_passive_mount_drives_nothing(active: tuple[bool, ...]) -> None:
    rng = np.random.default_rng(5)
    ways = rng.normal(size=(6, 3))
    layout = Layout(rng.uniform(-1, 1, (6, 3)), ways / np.linalg.norm(ways, axis=1)[:, None], active)
    assert layout.rank == sum(active)
    assert not layout.spread[~np.array(active)].any()


@settings(max_examples=60)
@given(layouts())
def test_passive_mounts_have_no_part_in_what_motions_are(layout: Layout) -> None:
    """The active mounts by themselves drive the same motions under the same names."""
    kept = list(layout.active)
    alone = Layout(layout.positions[kept], layout.directions[kept], (True,) * sum(kept))
    if any(kept):
        assert layout.motions == alone.motions
        np.testing.assert_allclose(layout.basis, alone.basis, atol=1e-9)
