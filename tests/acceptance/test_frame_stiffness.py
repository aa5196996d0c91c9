"""The fast estimate of the frame's windup compared with solid finite elements, for walls that a designer changes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.layouts.miso_bevel.drive import bevel
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support.stiffness import frame_compliance, seat_loads
from mbcdm_cad.model.stiffness import unit_tensions_N
from tests.support.frame_fe import SupportFE, brick_stiffness, seats
from tests.support.motors_above import ABOVE

REFERENCE = Path(__file__).parents[2] / "params" / "mbcdm.yaml"
COARSE_MM, FINE_MM = 2.0, 1.6
# The coarse mesh is stiffer than the fine one by up to this, the fine one than the limit of ever finer ones by as much.
MESH_ERROR = 0.06
AGREEMENT = 0.20

WALLS = {
    "reference": {},
    "back plate 2.6": {"back_plate_mm": 2.6},
    "ribs 2": {"rib_mm": 2.0},
    "side walls 4": {"side_wall_mm": 4.0},
    "motor shelf 3": {"motor_shelf_mm": 3.0},
    "all thin": {"back_plate_mm": 2.6, "rib_mm": 3.0, "side_wall_mm": 4.0, "motor_shelf_mm": 3.0},
    "all thick": {"back_plate_mm": 6.0, "rib_mm": 7.0, "side_wall_mm": 7.0, "motor_shelf_mm": 5.0},
}


def dims_of(**walls: float) -> BevelLayout:
    drive = load_design(REFERENCE).drive
    return BevelLayout(replace(drive, support=replace(drive.support, **walls)))


def by_elements(dims: BevelLayout, cell_mm: float) -> float:
    loads = seat_loads(dims, unit_tensions_N(layout_of(dims.drive).si))
    model = SupportFE(dims, cell_mm)
    assert tuple(seat.name for seat in seats(dims)) == loads.names
    return model.windup_urad_Nm(loads.force_N, loads.gearhead_torque_Nm)


@cache
def reference_by_elements(cell_mm: float) -> float:
    return by_elements(dims_of(), cell_mm)


def test_brick_stores_nothing_in_rigid_motion_and_bends_as_a_beam() -> None:
    sides, modulus, poisson = np.array([10.0, 1.0, 1.0]), 1.0, 0.3
    brick = brick_stiffness(sides, poisson)
    values = np.linalg.eigvalsh(brick)
    assert abs(values[:6]).max() < 1e-12 * values.max(), f"rigid motions store {values[:6]}"
    assert values[6] > 1e-9 * values.max(), f"a seventh motion without energy: {values[6]}"
    # Pure bending of one long brick: u = x z, w = -x^2 / 2 at the corners, free to contract across.
    corner = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]) * sides - sides / 2
    motion = np.zeros((8, 3))
    motion[:, 0] = corner[:, 0] * corner[:, 2]
    motion[:, 2] = -(corner[:, 0] ** 2) / 2
    motion = motion.ravel()
    inner = np.zeros(24, dtype=bool)
    inner[1::3] = inner[2::3] = True
    # The end couples are given by u; what moves across is left to find its least energy.
    left = np.linalg.lstsq(brick[np.ix_(inner, inner)], -brick[np.ix_(inner, ~inner)] @ motion[~inner], rcond=None)[0]
    whole = motion.copy()
    whole[inner] = left
    energy, beam = whole @ brick @ whole, modulus * sides[0] * sides[1] * sides[2] ** 3 / 12
    assert energy == pytest.approx(beam, rel=0.01), f"twice the energy {energy:.5g}, beam {beam:.5g}"


@pytest.mark.slow
def test_shape_of_the_elements_is_that_of_the_parts() -> None:
    from mbcdm_cad.layouts.miso_bevel.bill import bill

    dims = dims_of()
    parts = bill(dims, 0.0).parts
    drawn = sum(parts[n].part.solid().Volume() for n in ("frame", "top_plate"))
    found = SupportFE(dims, COARSE_MM).volume_mm3
    # Holes with screws, pins and dowels in them count as full here: 1 % of the volume.
    assert 0.0 < found / drawn - 1.0 < 0.015, f"elements {found:.0f} mm^3, parts {drawn:.0f} mm^3"


@pytest.mark.slow
def test_finer_elements_change_little() -> None:
    coarse, fine = (reference_by_elements(c) for c in (COARSE_MM, FINE_MM))
    assert abs(fine / coarse - 1.0) < MESH_ERROR, f"{coarse:.2f} urad per N m at 2.0 mm, {fine:.2f} at 1.6 mm"


@pytest.mark.slow
def test_displacements_are_reciprocal() -> None:
    flexibility = SupportFE(dims_of(), 2.5).compliance()
    error = abs(flexibility - flexibility.T).max() / abs(flexibility).max()
    assert error < 1e-9, f"unsymmetric by {error:.2g}"
    assert np.linalg.eigvalsh((flexibility + flexibility.T) / 2).min() > 0.0


@pytest.mark.slow
def test_reference_keeps_its_limit_by_finite_elements() -> None:
    drive = load_design(REFERENCE).drive
    found = reference_by_elements(FINE_MM) * drive.loads.test_torque_Nm * 1e-3
    limit = layout_of(drive).windup_limit_mrad
    assert found < limit, f"{found:.4f} mrad at {drive.loads.test_torque_Nm} N m, limit {limit} mrad"


@pytest.mark.slow
@pytest.mark.parametrize("walls", WALLS.values(), ids=WALLS)
def test_estimate_agrees_with_finite_elements(walls: dict[str, float]) -> None:
    dims = dims_of(**walls)
    quick = frame_compliance(dims).windup_urad_Nm
    solid = by_elements(dims, COARSE_MM) if walls else reference_by_elements(COARSE_MM)
    assert abs(quick / solid - 1.0) < AGREEMENT, (
        f"estimate {quick:.2f}, finite elements {solid:.2f} urad per N m: {100 * (quick / solid - 1):+.1f} %"
    )


@pytest.mark.slow
def test_estimate_agrees_with_finite_elements_for_motors_above() -> None:
    dims = BevelLayout(bevel(load_text(ABOVE).drive))
    quick, found = frame_compliance(dims).windup_urad_Nm, by_elements(dims, COARSE_MM)
    assert abs(quick / found - 1.0) < AGREEMENT, f"{quick:.2f} urad per N m, {found:.2f} by finite elements"
