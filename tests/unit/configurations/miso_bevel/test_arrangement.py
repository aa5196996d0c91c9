"""Arrangement of the drives: input axes set back from the guide's, gearheads of two to four screws."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, hypot

import numpy as np
import pytest

from mbcdm_cad.configurations.check_design import run_checks
from mbcdm_cad.configurations.loader import load_text, new_design_text
from mbcdm_cad.configurations.miso_bevel.bill import bill, moving_bodies
from mbcdm_cad.configurations.miso_bevel.drive import BevelDrive, bevel
from mbcdm_cad.configurations.miso_bevel.layout import layout
from mbcdm_cad.configurations.miso_bevel.routes import GUIDE, routed
from mbcdm_cad.errors import InputError
from mbcdm_cad.parts.bought.dims import screw_places
from mbcdm_cad.routes.curves import Arc, Line
from mbcdm_cad.routes.route import Span, Wrap


@pytest.fixture(scope="module")
def reference() -> BevelDrive:
    """The reference drive."""
    return bevel(load_text(new_design_text("reference")).drive)


def set_back(drive: BevelDrive, setback_mm: float, distance_mm: float = 42.0) -> BevelDrive:
    """The drive with its input axes moved, and its back plate with them."""
    back = drive.support.back_y_mm - setback_mm
    return replace(
        drive,
        centre_distance_mm=distance_mm,
        input_setback_mm=setback_mm,
        support=replace(drive.support, back_y_mm=back),
    )


def statuses(drive: BevelDrive) -> dict[str, str]:
    return {check.id: check.status for check in run_checks(drive)}


@pytest.mark.parametrize("distance_mm", [36.5, 42.0, 55.0, 62.0])
def test_a_setback_lets_the_terminals_pass_the_gearheads(reference: BevelDrive, distance_mm: float) -> None:
    before, after = (statuses(set_back(reference, mm, distance_mm)) for mm in (0.0, 1.2))
    assert before["drum_sweep"] == "fail" and after["drum_sweep"] == "pass"
    worse = {name for name in after if after[name] == "fail" and before[name] != "fail"} - {"envelope_y", "envelope_x"}
    assert not worse, f"the setback breaks {worse}"


@pytest.mark.parametrize("setback_mm", [0.0, 1.2, 9.0])
def test_routes_and_drawn_paths_agree_with_a_setback(reference: BevelDrive, setback_mm: float) -> None:
    """Two derivations: the model's by formula, the drawing's from tangent points."""
    drive = set_back(reference, setback_mm)
    model = routed(drive)
    routes, dims = model.routes, layout(drive)
    for route, path, run in zip(routes.cables, dims.cable_paths(0.0), drive.cables, strict=True):
        guide, span = path.piece("guide"), path.piece("span")
        assert isinstance(guide, Arc) and isinstance(span, Line)
        wrap = next(p for p in route.pieces if isinstance(p, Wrap) and p.body == GUIDE)
        drawn_deg, model_deg = np.degrees([abs(guide.angle_end - guide.angle_start), wrap.angle_rad])
        assert drawn_deg == pytest.approx(model_deg, abs=1e-9), run.name
        free = next(p for p in route.pieces if isinstance(p, Span) and p.length_m > 0.0)
        plan = span.tangent(0.0)[:2] / hypot(*span.tangent(0.0)[:2])
        assert np.abs(plan - np.array(free.direction[:2])).max() < 1e-9, f"{run.name}: {plan} against {free.direction}"
        start, end = path.piece("span_in").points(np.array([0.0]))[0], guide.points(np.array([0.0]))[0]
        assert hypot(*(end - start)[:2]) == pytest.approx(1e3 * free.length_m, abs=1e-9)
        assert hypot(*(start[:2] - np.array([run.input_side * drive.input_x_mm, -setback_mm]))) == pytest.approx(
            run.input_radius_mm, abs=1e-9
        )
    origins = {body.name: body.origin_mm for body in moving_bodies(dims)}
    for body in routes.bodies:
        if body.kind == "input":
            assert np.abs(np.array(body.point_m) * 1e3 - origins[body.name]).max() < 1e-9, body.name


def test_the_distance_of_the_axes_stays_l(reference: BevelDrive) -> None:
    drive = set_back(reference, 5.0)
    assert hypot(drive.input_x_mm, drive.input_y_mm) == pytest.approx(drive.centre_distance_mm, abs=1e-12)


def test_a_setback_beyond_half_of_l_is_refused_with_its_line() -> None:
    text = new_design_text("x").replace("  centre_distance_mm:", "  input_setback_mm: 20.0\n  centre_distance_mm:")
    with pytest.raises(InputError, match="too far behind") as raised:
        load_text(text)
    assert raised.value.problems[0].line > 1


@pytest.mark.parametrize("count", [2, 3, 4])
def test_screws_of_a_flange_mirror_in_its_middle_plane(count: int) -> None:
    places = screw_places(count, 6.5)
    assert len(places) == count
    assert {(round(-x, 6) + 0.0, round(y, 6)) for x, y in places} == {
        (round(x, 6) + 0.0, round(y, 6)) for x, y in places
    }
    angles = np.sort([atan2(y, x) % (2 * np.pi) for x, y in places])
    assert np.diff(angles) == pytest.approx(2 * np.pi / count, abs=1e-6)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
def test_every_gearhead_screw_is_in_the_bill_and_counted(reference: BevelDrive, count: int) -> None:
    drive = replace(reference, gearhead=replace(reference.gearhead, screw_count=count))
    items = [item.name for item in bill(layout(drive)).items if item.name.startswith("gearhead_screw_left")]
    assert items == [f"gearhead_screw_left_{n}" for n in range(1, count + 1)]
    assert statuses(drive)["screw_counts"] == ("pass" if count in (2, 3, 4) else "fail")
