"""The output as builders ask for it: screws of a stated number on a stated circle, their thread by the torque."""

from math import atan2, degrees, hypot, radians

import numpy as np
import pytest

from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.parts.drum_sector.dims import SET_SCREW_ANGLES_DEG, start_deg
from tests.support.checked import failing

SHORT = """\
name: output
configuration: {layout}
travel: {{half_angle_deg: 45.0}}
transmission: {{input_to_drum: 9.0, drum_radius_mm: 75.0}}
loads: {{peak_torque_Nm: {torque}}}
drum: {{{drum}}}
"""


def made(drum: str, torque: float = 8.0, layout: str = "siso_spur") -> SpurLayout:
    found = layout_of(load_text(SHORT.format(layout=layout, torque=torque, drum=drum)).drive)
    assert isinstance(found, SpurLayout)
    return found


@pytest.mark.parametrize(("circle_mm", "screws"), [(40.0, 6), (32.0, 3), (50.0, 8)])
def test_the_circle_and_the_number_are_those_of_the_file(circle_mm: float, screws: int) -> None:
    layout = made(f"output_circle_mm: {circle_mm}, output_screws: {screws}")
    places = layout.drum.payload_places
    assert [round(2 * hypot(x, z), 9) for x, z in places] == [circle_mm] * screws
    turned = sorted(degrees(atan2(x, z)) % 360.0 for x, z in places)
    assert np.allclose(np.diff(turned), 360.0 / screws), turned
    assert layout.drum.hub_radius > circle_mm / 2
    assert failing(layout) == {}


def test_more_screws_on_a_wider_circle_need_a_thinner_thread() -> None:
    """Friction holds mu F r for each screw: twice the screws on twice the circle hold four times the torque."""
    few, many = made("output_circle_mm: 24.0, output_screws: 4"), made("output_circle_mm: 48.0, output_screws: 8")
    assert many.drum.payload_screw_thread < few.drum.payload_screw_thread


def test_left_out_it_is_what_it_was() -> None:
    drum = made("outer_face_y_mm: 30.0").drum
    assert drum.payload_angles_deg == (0.0, 90.0, 180.0, 270.0)
    assert drum.payload_circle_radius == (drum.hub_radius + drum.bore_radius) / 2


@pytest.mark.parametrize(("screws", "apart_deg"), [(3, 45.0), (4, 45.0), (5, 27.0), (6, 15.0), (8, 22.5)])
def test_the_first_screw_keeps_all_of_them_away_from_the_set_screws(screws: int, apart_deg: float) -> None:
    holes = [start_deg(screws, SET_SCREW_ANGLES_DEG) + 360.0 / screws * k for k in range(screws)]
    off = [abs((hole - radial + 180.0) % 360.0 - 180.0) for hole in holes for radial in SET_SCREW_ANGLES_DEG]
    assert min(off) == apart_deg, sorted(off)[:3]


@pytest.mark.parametrize(("drum", "behind"), [("output_circle_mm: 24.0, output_screws: 12", True), ("", False)])
def test_set_screws_stand_behind_holes_that_would_come_near_them(drum: str, behind: bool) -> None:
    layout = made(drum)
    d, screw = layout.drum, layout.drive.screw(layout.drum.set_screw)
    assert failing(layout) == {}
    middle = (d.web_end_y + d.hub_face_y) / 2
    assert (d.set_screw_y < middle) is behind, (d.set_screw_y, middle)
    # The metal between the two cylinders, by points on both.
    turn, part = np.meshgrid(np.linspace(0.0, 2 * np.pi, 61), np.linspace(0.0, 1.0, 41))
    (x, z), *_ = sorted(d.payload_places, key=lambda at: abs(atan2(at[0], at[1]) - radians(SET_SCREW_ANGLES_DEG[0])))
    r = d.payload_hole / 2
    hole = np.stack([x + r * np.cos(turn), d.hub_face_y - part * d.payload_depth, z + r * np.sin(turn)], -1)
    out, a = d.bore_radius + part * (d.hub_radius - d.bore_radius), radians(SET_SCREW_ANGLES_DEG[0])
    r = screw.thread_mm / 2
    aside = r * np.cos(turn)
    set_screw = np.stack(
        [out * np.sin(a) + aside * np.cos(a), d.set_screw_y + r * np.sin(turn), out * np.cos(a) - aside * np.sin(a)], -1
    )
    wall = np.linalg.norm(hole.reshape(-1, 1, 3) - set_screw.reshape(1, -1, 3), axis=-1).min()
    assert wall >= layout.drive.drum_material.min_wall_mm - 1e-6, wall


def test_a_circle_without_walls_fails_with_the_figure() -> None:
    assert (
        "wall beside the payload's threads"
        in failing(made("output_circle_mm: 40.0, hub_diameter_mm: 40.0"))["hub_walls"]
    )


def test_a_stack_of_sectors_has_four_screws() -> None:
    with pytest.raises(InputError, match=r"drum.output_screws: the dowels between the hubs stand between four screws"):
        made("output_screws: 6", layout="miso_spur")
