"""Bend ratio D/d of the cable: on the pulleys, and at the stop inside the input pulley."""

from __future__ import annotations

from collections.abc import Iterator

from mbcdm_cad.checks.bending import anchor_check, bending_checks
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.layouts.miso_bevel.cable_path import stop_of
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout


def _stop_bends_mm(s: BevelLayout) -> Iterator[tuple[str, float]]:
    s.levels  # noqa: B018 - without levels there is no winding, hence no stop
    for c in s.steps:
        yield c.name, stop_of(s.drive, c).bend_radius_mm


_THINNER = (down("rope diameter_mm"), down("transmission.ratios.input_to_guide"), up("all radii of transmission"))
CHECKS = (*bending_checks(_THINNER), anchor_check(_stop_bends_mm, _THINNER))
