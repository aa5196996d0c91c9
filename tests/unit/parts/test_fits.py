"""Limits of ISO 286 compared with the tables of the standard, as upper/lower deviation in micrometres."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.parts.fits import FITS, limits

# One size inside each range; ISO 286-2:2010.
PRINTED = {
    ("h5", 8.0): (0, -6),
    ("h6", 4.0): (0, -8),
    ("h6", 50.0): (0, -16),
    ("h7", 25.0): (0, -21),
    ("h8", 16.0): (0, -27),
    ("h9", 100.0): (0, -87),
    ("g6", 3.0): (-2, -8),
    ("g6", 5.0): (-4, -12),
    ("g6", 12.0): (-6, -17),
    ("g6", 60.0): (-10, -29),
    ("f7", 8.0): (-13, -28),
    ("f7", 40.0): (-25, -50),
    ("k5", 8.0): (7, 1),
    ("k5", 20.0): (11, 2),
    ("k6", 10.0): (10, 1),
    ("k6", 100.0): (25, 3),
    ("m6", 2.0): (8, 2),
    ("m6", 5.0): (12, 4),
    ("m6", 16.0): (18, 7),
    ("n6", 10.0): (19, 10),
    ("n6", 30.0): (28, 15),
    ("p6", 6.0): (20, 12),
    ("p6", 80.0): (51, 32),
    ("js6", 5.0): (4, -4),
    ("js6", 8.0): (4.5, -4.5),
    ("js7", 20.0): (10, -10),
    ("H6", 16.0): (11, 0),
    ("H7", 3.0): (10, 0),
    ("H7", 4.0): (12, 0),
    ("H7", 9.0): (15, 0),
    ("H7", 120.0): (35, 0),
    ("H8", 30.0): (33, 0),
    ("H9", 50.0): (62, 0),
    ("H10", 5.0): (48, 0),
    ("H11", 18.0): (110, 0),
    ("G7", 2.0): (12, 2),
    ("G7", 16.0): (24, 6),
    ("J7", 5.0): (6, -6),
    ("J7", 16.0): (10, -8),
    ("J7", 47.0): (14, -11),
    ("K7", 2.0): (0, -10),
    ("K7", 8.0): (5, -10),
    ("K7", 22.0): (6, -15),
    ("K7", 110.0): (10, -25),
    ("M7", 3.0): (-2, -12),
    ("M7", 8.0): (0, -15),
    ("M7", 60.0): (0, -30),
    ("N7", 3.0): (-4, -14),
    ("N7", 9.0): (-4, -19),
    ("N7", 16.0): (-5, -23),
    ("N7", 90.0): (-10, -45),
    ("P7", 2.0): (-6, -16),
    ("P7", 16.0): (-11, -29),
    ("P7", 40.0): (-17, -42),
    ("P7", 100.0): (-24, -59),
    ("K6", 5.0): (2, -6),
    ("M6", 5.0): (-1, -9),
    ("H7", 130.0): (40, 0),
    ("h6", 200.0): (0, -29),
    ("g6", 300.0): (-17, -49),
    ("K7", 150.0): (12, -28),
    ("K7", 450.0): (18, -45),
    ("J7", 200.0): (30, -16),
    ("M6", 300.0): (-9, -41),
    ("M7", 300.0): (0, -52),
    ("N7", 200.0): (-14, -60),
    ("P7", 130.0): (-28, -68),
    ("js7", 128.79): (20, -20),
}


@pytest.mark.parametrize(("code", "nominal"), sorted(PRINTED), ids=lambda v: str(v))
def test_printed_limits(code: str, nominal: float) -> None:
    found = limits(nominal, code)
    assert (round(found.upper_mm * 1e3, 6), round(found.lower_mm * 1e3, 6)) == PRINTED[code, nominal]


@given(st.floats(1.0, 500.0), st.sampled_from("fghkmnp"), st.sampled_from([6, 7]))
def test_shaft_and_hole_of_one_letter_fit_alike(nominal: float, letter: str, grade: int) -> None:
    """Shaft x6 in hole H7 has the same play as hole X7 on shaft h6: the rule by which ISO 286 sets K to P."""
    if letter in "kmnp" and nominal <= 3.0:
        return
    shaft, hole = limits(nominal, f"{letter}6"), limits(nominal, f"{letter.upper()}7")
    play_on_hole_basis = limits(nominal, "H7").upper_mm - shaft.lower_mm
    play_on_shaft_basis = hole.upper_mm - limits(nominal, "h6").lower_mm
    assert play_on_hole_basis == pytest.approx(play_on_shaft_basis, abs=1e-9)


@pytest.mark.parametrize("bad", [(0.5, "H7"), (501.0, "h6"), (10.0, "H4x"), (10.0, "x6"), (10.0, "J9"), (10.0, "H99")])
def test_what_is_not_in_the_tables_is_refused(bad: tuple[float, str]) -> None:
    with pytest.raises(ValueError, match=r"fit "):
        limits(*bad)


@given(st.floats(1.0, 500.0))
def test_every_fit_in_use_has_limits(nominal: float) -> None:
    for role, fit in FITS.items():
        found = limits(nominal, fit.code)
        assert found.smallest_mm < found.largest_mm, role
        assert fit.reason, role
        assert fit.source, role
