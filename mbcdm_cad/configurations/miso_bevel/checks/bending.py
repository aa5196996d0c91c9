"""Bend ratio D/d of the cable: on the pulleys, and at the stop inside the input pulley."""

from __future__ import annotations

from mbcdm_cad.checks.bending import ANCHOR_RATIO, bending_checks
from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.configurations.miso_bevel.cable_path import stop_geometry
from mbcdm_cad.configurations.miso_bevel.design_under_test import BevelUnderTest


def anchor_bend(s: BevelUnderTest) -> Comparison:
    """The constant bend of the cable before the swaged stop inside the input pulley."""
    s.levels  # noqa: B018 - without levels there is no winding, hence no stop
    d = s.drive.cable.diameter_mm
    return worst(
        at_least(
            f"D/d of the bend at the stop of {c.name}",
            2 * stop_geometry(s.drive, c).bend_radius_mm / d,
            ANCHOR_RATIO,
            "D/d",
        )
        for c in s.steps
    )


_THINNER = (down("rope diameter_mm"), down("transmission.ratios.input_to_guide"), up("all radii of transmission"))
CHECKS = (
    *bending_checks(_THINNER),
    Check(
        "anchor_bend",
        "Standing bend at the cable's stop",
        "rope makers' tables, interpolated: estimate",
        anchor_bend,
        adjust=_THINNER,
    ),
)
