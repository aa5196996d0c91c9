"""Drives as builders make them: without encoders of their own, and with a hollow centre through drum and frame."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.loader import layout_of, load_text, new_design_text
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.support.parts import round_end_mm2
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.rig.dynamic.rig import rig_of
from tests.support.checked import failing

SHORT = """\
name: bare
configuration: {layout}
travel: {{half_angle_deg: 45.0}}
transmission: {{input_to_drum: 9.0, drum_radius_mm: 75.0}}
loads: {{peak_torque_Nm: 1.0}}
drive: {{encoder: {encoder}, drum_encoder: {drum_encoder}}}
"""
BORE_MM = 40.0


def made(layout: str = "siso_spur", more: str = "", encoder: str = "none", drum_encoder: str = "none") -> Layout:
    text = SHORT.format(layout=layout, encoder=encoder, drum_encoder=drum_encoder)
    return layout_of(load_text(text + more).drive)


@pytest.fixture(scope="module")
def bare() -> Layout:
    return made()


@pytest.fixture(scope="module")
def hollow() -> Layout:
    return made(more=f"drum: {{shaft_bore_mm: {BORE_MM}}}\n")


@pytest.mark.parametrize("layout", ["siso_spur", "miso_spur"])
def test_it_passes_every_check_and_each_item_joins_in_one_step(layout: str) -> None:
    found = made(layout)
    assert failing(found) == {}
    names = [item.name for item in found.bill().items]
    assert [name for name in names if "encoder" in name] == []
    assert sorted(item for step in found.assembly_order for item in step.items) == sorted(names)


def test_no_step_speaks_of_an_encoder(bare: Layout) -> None:
    said = [step.text for step in bare.assembly_order if "encoder" in step.text]
    assert said == []
    assert "encoder" in " ".join(
        step.text for step in made(encoder="encoder-17", drum_encoder="encoder-24-ring").assembly_order
    )


def test_the_frame_has_neither_pocket_nor_threads_for_them(bare: SpurLayout) -> None:
    sheet = bare.bill().parts["frame"].part.sheet("frame")
    assert [group.letter for group in sheet.holes] == list("ABCDEF")
    assert not bare.frame.boss.has_encoder and not bare.frame.has_encoder


def test_the_motors_own_encoder_is_what_the_rig_reads(bare: Layout) -> None:
    step = rig_of(bare.drive).encoders[0].resolution_rad
    assert abs(step * 2**14 * bare.drive.gearhead.ratio / (2 * pi) - 1.0) < 1e-12, step


def test_a_controller_that_sees_only_the_motor_leaves_the_gearheads_twist(drive: SpurDrive) -> None:
    """With an encoder on its input the twist of gearhead and coupling is held off the payload, else it is not."""
    text = new_design_text("siso_spur", "siso_spur").replace("encoder: encoder-17", "encoder: none")
    seen, unseen = structure_of(layout_of(drive)), structure_of(layout_of(load_text(text).drive))
    assert seen is not None and unseen is not None
    before = [cause.name for cause in seen.causes if cause.before_input]
    assert before and seen.payload_urad_Nm < seen.motor_urad_Nm
    assert unseen.payload_urad_Nm == unseen.motor_urad_Nm
    assert set(before) <= {cause.name for cause in unseen.causes}, before


@pytest.mark.parametrize("layout", ["siso_bevel", "miso_bevel"])
@pytest.mark.parametrize("field", ["encoder", "drum_encoder"])
def test_other_layouts_refuse_with_what_to_do(layout: str, field: str) -> None:
    text = new_design_text("other", layout)
    line = next(line for line in text.splitlines() if line.startswith(f"  {field}: "))
    with pytest.raises(InputError, match=rf"drive.{field}: {layout} is drawn with this encoder only.*siso_spur"):
        load_text(text.replace(line, f"  {field}: none"))


def test_the_set_screws_do_not_meet_in_the_shaft_of_a_small_drive() -> None:
    """No ring encoder asks for a shaft of 5 mm any more; two M3 at a right angle would meet in one of 3 mm."""
    text = SHORT.format(layout="siso_spur", encoder="none", drum_encoder="none").replace(
        "torque_Nm: 1.0", "torque_Nm: 0.2"
    )
    layout = layout_of(load_text(text + "drum: {material: pla}\nsupport: {material: pla}\n").drive)
    assert failing(layout) == {}
    thin = layout_of(load_text(text + "drum: {bearing: 618/3}\n").drive)
    assert "set_screw_tips" in failing(thin)


def test_a_hollow_centre_of_the_stated_diameter_passes(hollow: SpurLayout) -> None:
    assert failing(hollow) == {}
    assert 2 * hollow.drum_shaft.bore_radius == BORE_MM
    bearing = hollow.drive.bearings.drum
    assert bearing.bore_mm - BORE_MM >= 2 * hollow.drive.shaft_material.min_wall_mm, bearing
    # Nothing else stands in it: the shaft runs from the frame's back to the face of the hub.
    assert hollow.drum_shaft.y_start == hollow.levels.back_y
    assert hollow.drum_shaft.y_end == hollow.levels.hub_face_y


def test_the_plates_round_end_takes_in_a_boss_wider_than_the_arm(hollow: SpurLayout) -> None:
    """Area of the disc outside a strip, against points counted on a grid."""
    frame = hollow.frame
    assert frame.boss.radius > frame.half_width, (frame.boss.radius, frame.half_width)
    r, w, n = frame.boss.radius, frame.half_width, 2000
    grid = (np.arange(n) + 0.5) / n * 2 * r - r
    x, z = np.meshgrid(grid, grid)
    inside = (x**2 + z**2 < r**2) & ~((np.abs(x) < w) & (z > 0.0))
    counted = inside.sum() * (2 * r / n) ** 2
    assert abs(round_end_mm2(frame) / counted - 1.0) < 1e-3, (round_end_mm2(frame), counted)
    narrow = replace(frame, boss=replace(frame.boss, radius=w / 2))
    assert abs(round_end_mm2(narrow) / (pi * w**2 / 2) - 1.0) < 1e-12
