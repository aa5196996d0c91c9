"""Each kind of piece: exact length compared with chords, end tangents with differences, and values by hand."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.routes.curves import Arc, Coil, Helix, Line, Parabola, Piece, _gauss, cut

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
PIECES: dict[str, Piece] = {
    "line": Line((1.0, 2.0, 3.0), (4.0, -2.0, 15.0)),
    "arc": Arc((1.0, -2.0, 0.5), X, Z, 7.0, 0.3, 2.9),
    "arc backwards": Arc((1.0, -2.0, 0.5), X, Z, 7.0, 2.9, 0.3),
    "helix": Helix((3.0, -1.0), 6.0, 0.4, 11.7, 2.0, -1.0),
    "helix backwards": Helix((3.0, -1.0), 6.0, 11.7, 0.4, 2.0, -1.0),
    "coil": Coil((1.0, 0.0, 5.0), Y, Z, 4.0, 0.2, 9.0, -1.0, 6.0),
    "parabola": Parabola((0.0, 0.0, 0.0), (1.0, 0.0, 0.1), (2.0, 0.3, 0.1)),
}


def chords(piece: Piece, count: int) -> float:
    points = piece.points(np.linspace(0.0, 1.0, count + 1))
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


@pytest.mark.parametrize("piece", PIECES.values(), ids=PIECES.keys())
def test_length_is_that_of_fine_chords(piece: Piece) -> None:
    """Chords fall short by a term in 1/n^2, so two counts give the limit (Richardson)."""
    coarse, fine = chords(piece, 2000), chords(piece, 4000)
    limit = fine + (fine - coarse) / 3
    assert abs(piece.length_mm / limit - 1) < 1e-11, f"{piece.length_mm} against {limit} by chords"


@pytest.mark.parametrize("piece", PIECES.values(), ids=PIECES.keys())
@pytest.mark.parametrize("fraction", [0.0, 0.37, 1.0])
def test_tangent_is_the_direction_of_travel(piece: Piece, fraction: float) -> None:
    h = 1e-6
    low, high = piece.points(np.array([fraction - h, fraction + h]))
    step = (high - low) / np.linalg.norm(high - low)
    tangent = piece.tangent(fraction)
    assert np.linalg.norm(tangent) == pytest.approx(1.0, abs=1e-14)
    assert np.abs(tangent - step).max() < 1e-8, f"{tangent} against {step}"


def test_lengths_known_by_hand() -> None:
    assert Line((0, 0, 0), (3, 4, 12)).length_mm == 13.0
    assert Arc((5, 5, 5), X, Y, 2.0, pi, 0.0).length_mm == pytest.approx(2 * pi, rel=1e-15)
    assert Helix((0, 0), 3.0, 0.0, 2 * pi, 0.0, 8 * pi).length_mm == pytest.approx(10 * pi, rel=1e-15)
    # y = x^2 from 0 to 1: sqrt(5)/2 + asinh(2)/4.
    exact = sqrt(5) / 2 + np.arcsinh(2) / 4
    assert Parabola((0, 0, 0), (0.5, 0, 0), (1, 1, 0)).length_mm == pytest.approx(exact, rel=1e-9)


@given(st.floats(-10, 10), st.floats(-10, 10), st.floats(0.5, 9), st.floats(-5, 5))
def test_a_helix_stays_on_its_cylinder_and_climbs_evenly(a0: float, a1: float, radius: float, rise: float) -> None:
    helix = Helix((2.0, -3.0), radius, a0, a1, 1.0, 1.0 + rise)
    points = helix.points(np.linspace(0, 1, 50))
    from_axis = np.hypot(points[:, 0] - 2.0, points[:, 1] + 3.0)
    assert np.abs(from_axis - radius).max() < 1e-12
    assert np.abs(np.diff(points[:, 2]) - rise / 49).max() < 1e-13


def test_a_parabola_joins_two_slopes() -> None:
    p = Parabola((0, 0, 0), (1, 0, 0), (1, 2, 0))
    assert p.tangent(0.0) == pytest.approx((1, 0, 0)) and p.tangent(1.0) == pytest.approx((0, 1, 0))


def test_the_table_of_the_quadrature_is_that_of_numpy() -> None:
    nodes, weights = np.polynomial.legendre.leggauss(12)
    found, found_weights = np.array(sorted(_gauss())).T
    assert np.abs(2 * found - 1 - nodes).max() < 1e-15
    assert np.abs(found_weights - weights).max() < 1e-15


@pytest.mark.parametrize("piece", PIECES.values(), ids=PIECES.keys())
@given(length_mm=st.floats(0.3, 40.0))
def test_the_parts_of_a_piece_are_the_piece(piece: Piece, length_mm: float) -> None:
    parts = cut(piece, length_mm)
    assert sum(part.length_mm for part in parts) == pytest.approx(piece.length_mm, rel=1e-12)
    ends = np.array([part.points(np.array([0.0, 0.5, 1.0])) for part in parts])
    whole = piece.points(np.linspace(0.0, 1.0, 2 * len(parts) + 1))
    off = np.abs(
        np.concatenate([ends[:, 0], ends[:, 1], ends[:, 2]]) - np.concatenate([whole[:-1:2], whole[1::2], whole[2::2]])
    )
    assert off.max() < 1e-12, f"{len(parts)} parts, off by {off.max()} mm"
    if not isinstance(piece, Parabola):
        assert max(part.length_mm for part in parts) <= length_mm * (1 + 1e-12)
