"""Loads on the support and the estimate of its windup: equilibrium, laws, messages."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support.stiffness import frame_compliance, seat_loads
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.model.stiffness import unit_tensions_N

from .designs import drives, mirrored, reference

WALLS = ("back_plate_mm", "side_wall_mm", "motor_shelf_mm", "bearing_shelf_mm", "top_plate_mm", "rib_mm")


def with_walls(drive: BevelDrive, **walls: float) -> BevelDrive:
    return replace(drive, support=replace(drive.support, **walls))


def drawable(drive: BevelDrive) -> BevelLayout:
    """The layout, where the random radii leave one."""
    lay = BevelLayout(drive)
    try:
        assert all((lay.drum, lay.drum_shaft, lay.inputs, lay.guide, lay.axle, lay.frame, lay.top_plate))
    except NoFigureError:
        reject()
    return lay


@settings(max_examples=25, deadline=None)
@given(drives())
def test_load_of_1_Nm_leaves_the_mount_a_moment_about_the_drum_alone(drive: BevelDrive) -> None:
    dims = drawable(drive)
    loads = seat_loads(dims, unit_tensions_N(layout_of(drive).si))
    force = loads.force_N.sum(axis=0)
    moment = np.cross(loads.point_mm, loads.force_N).sum(axis=0) / 1e3
    moment[2] += loads.gearhead_torque_Nm.sum()
    size = abs(loads.force_N).max()
    assert abs(force).max() < 1e-9 * size, f"net force {force} N"
    # A load that opposes positive rotation turns the support against +Y.
    assert np.allclose(moment, [0.0, -1.0, 0.0], atol=1e-9), f"net moment {moment} N m"


@settings(max_examples=25, deadline=None)
@given(drives(), st.lists(st.floats(0.0, 200.0), min_size=4, max_size=4))
def test_any_tensions_load_the_mount_by_their_moment_on_the_drum(drive: BevelDrive, tension: list[float]) -> None:
    d = layout_of(drive).si
    loads = seat_loads(drawable(drive), np.array(tension))
    on_drum = float((d.sigma * np.array(tension) * d.drum_radius_m).sum())
    moment = np.cross(loads.point_mm, loads.force_N).sum(axis=0) / 1e3
    moment[2] += loads.gearhead_torque_Nm.sum()
    assert np.allclose(loads.force_N.sum(axis=0), 0.0, atol=1e-9 * (1 + max(tension)))
    assert np.allclose(moment, [0.0, -on_drum, 0.0], atol=1e-9 * (1 + max(tension))), f"{moment}, drum {on_drum} N m"


def test_unit_tensions_carry_1_Nm(drive: BevelDrive) -> None:
    d = layout_of(drive).si
    carried = float((d.sigma * unit_tensions_N(d) * d.drum_radius_m).sum())
    assert carried == pytest.approx(1.0, abs=1e-12), f"{carried} N m"


def test_reference_keeps_its_limit_and_shares_add_up(dims: BevelLayout) -> None:
    found = frame_compliance(dims)
    limit, torque = dims.windup_limit_mrad, dims.drive.loads.test_torque_Nm
    assert found.windup_mrad(torque) <= limit, f"{found.windup_mrad(torque):.4f} mrad, limit {limit} mrad"
    assert sum(found.shares_urad_Nm.values()) == pytest.approx(found.windup_urad_Nm)
    assert min(found.shares_urad_Nm.values()) > 0.0, f"{found.shares_urad_Nm}"


def test_windup_is_inverse_to_the_modulus(drive: BevelDrive, as_drawn_urad_Nm: float) -> None:
    material = drive.frame_material
    softer = replace(material, youngs_modulus_GPa=material.youngs_modulus_GPa / 3)
    soft = frame_compliance(BevelLayout(replace(drive, frame_material=softer))).windup_urad_Nm
    ratio = soft / as_drawn_urad_Nm
    assert ratio == pytest.approx(3.0, rel=1e-6), f"{ratio}"


@pytest.fixture(scope="module")
def as_drawn_urad_Nm() -> float:
    """Windup of the reference support."""
    return frame_compliance(BevelLayout(reference())).windup_urad_Nm


@pytest.mark.parametrize("wall", WALLS)
def test_a_thicker_wall_is_stiffer(drive: BevelDrive, as_drawn_urad_Nm: float, wall: str) -> None:
    thickness = getattr(drive.support, wall)
    thick = frame_compliance(BevelLayout(with_walls(drive, **{wall: 1.25 * thickness}))).windup_urad_Nm
    assert thick < as_drawn_urad_Nm, (
        f"{wall}: {as_drawn_urad_Nm:.3f} urad per N m at {thickness} mm, {thick:.3f} at 1.25 times as much"
    )


def test_mirror_image_is_as_stiff(drive: BevelDrive, as_drawn_urad_Nm: float) -> None:
    there = frame_compliance(BevelLayout(mirrored(drive))).windup_urad_Nm
    assert there == pytest.approx(as_drawn_urad_Nm, rel=1e-6), f"{as_drawn_urad_Nm} and {there} urad per N m"


@settings(max_examples=6, deadline=None)
@given(drives(), st.tuples(*[st.floats(0.5, 9.0)] * 6))
def test_any_design_has_a_windup_or_a_sentence(drive: BevelDrive, walls: tuple[float, ...]) -> None:
    dims = drawable(with_walls(drive, **dict(zip(WALLS, walls, strict=True))))
    try:
        found = frame_compliance(dims).windup_urad_Nm
    except ValueError as error:
        said = str(error)
    else:
        said = "frame: a figure"
        assert np.isfinite(found), f"windup {found}"
        assert found > 0.0, f"windup {found}"
    assert said.startswith("frame: "), said


def test_a_solid_column_yields_less_than_a_hollow_one() -> None:
    dims = BevelLayout(reference())
    hollow = frame_compliance(dims).windup_urad_Nm
    filled = replace(dims.frame, column_pocket_bottom_z=dims.levels.motor_shelf_bottom_z)
    assert not filled.has_column_pocket
    solid = frame_compliance(dims.with_dimensions(frame=filled)).windup_urad_Nm
    assert 0.3 * hollow < solid < hollow, f"solid {solid:.3g}, hollow {hollow:.3g} urad/(N m)"


def test_wall_of_no_thickness_is_named() -> None:
    dims = BevelLayout(reference())
    levels = replace(dims.levels, motor_shelf_top_z=dims.levels.motor_shelf_bottom_z)
    with pytest.raises(ValueError, match="motor shelf 0 mm"):
        frame_compliance(dims.with_dimensions(levels=levels))
