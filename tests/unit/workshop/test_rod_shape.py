"""Mass properties of a rod from its centre line: against closed forms, and against the kernel's of the drawn cable."""

from __future__ import annotations

from math import cos, pi, sin
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.parts.bill import CABLE
from mbcdm_cad.routes.curves import Arc, Line
from mbcdm_cad.workshop.kernel import measure
from mbcdm_cad.workshop.mass import rod_shape

PARAMS = Path(__file__).parents[3] / "params"


def test_straight_rod_has_the_inertia_of_a_cylinder() -> None:
    length, radius = 40.0, 3.0
    shape = rod_shape([Line((1.0, 2.0, -20.0), (1.0, 2.0, 5.0)), Line((1.0, 2.0, 5.0), (1.0, 2.0, 20.0))], radius)
    volume = pi * radius**2 * length
    assert shape.volume_mm3 == pytest.approx(volume)
    assert shape.area_mm2 == pytest.approx(2 * pi * radius * (length + radius))
    assert shape.centroid_mm == pytest.approx((1.0, 2.0, 0.0))
    across, along = volume * (3 * radius**2 + length**2) / 12, volume * radius**2 / 2
    # The rod is summed as 96 slices, which are points along it.
    assert np.diag(shape.inertia_mm5) == pytest.approx([across, across, along], rel=1e-3)


def test_bent_rod_has_the_volume_and_centroid_of_pappus() -> None:
    ring, radius, half = 20.0, 0.5, 1.2
    arc = Arc((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), ring, -half, half)
    shape = rod_shape([arc], radius)
    assert shape.volume_mm3 == pytest.approx(pi * radius**2 * ring * 2 * half)
    # Exact: (R + r^2/(4 R)) sin(a)/a; the line alone has R sin(a)/a.
    exact = (ring + radius**2 / (4 * ring)) * sin(half) / half
    assert shape.centroid_mm[0] == pytest.approx(exact, abs=radius**2 / (4 * ring) * 1.1 + 1e-3)
    assert shape.low_mm[0] == pytest.approx(ring * cos(half) - radius) and shape.high_mm[2] == pytest.approx(radius)


@pytest.mark.parametrize("design", ["mbcdm", "siso_spur"])
def test_cable_has_the_mass_that_the_kernel_finds(design: str) -> None:
    drive = load_design(PARAMS / f"{design}.yaml").drive
    parts = drive.layout.bill().parts
    spec = next(spec for name, spec in parts.items() if name.startswith(CABLE))
    line, solid = rod_shape(spec.part.pieces, spec.part.radius), measure(spec.part.solid())
    assert line.volume_mm3 == pytest.approx(solid.volume_mm3, rel=1e-5)
    assert line.centroid_mm == pytest.approx(solid.centroid_mm, abs=0.01)
    assert np.diag(line.inertia_mm5) == pytest.approx(np.diag(solid.inertia_mm5), rel=0.002)
    ends = drive.cable.diameter_mm / 2 + 0.01
    assert np.all(np.array(line.low_mm) <= np.array(solid.low_mm) + 0.02), "the box holds the cable"
    assert line.low_mm + line.high_mm == pytest.approx(solid.low_mm + solid.high_mm, abs=ends)
