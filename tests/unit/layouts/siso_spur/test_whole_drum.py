"""Drums that are closed all round: turns beside each other, terminals that come by, the ring's strain, messages."""

from dataclasses import replace
from math import atan2, hypot, pi, tau

import numpy as np
import pytest

from mbcdm_cad.checks.run import run_all, run_check
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.siso_spur.checks.wraps import turns_on_drum
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.structure.quadrilateral import elements, solve
from mbcdm_cad.model.structure.sector_mesh import RimStep, SectorShape, sector_mesh
from mbcdm_cad.parts.drum_sector.part import DrumSector
from mbcdm_cad.workshop.kernel import validate_solid

TEXT = """name: turns
configuration: siso_spur
travel: {half_angle_deg: HALF}
transmission: {input_to_drum: 6.0}
drive: {motor: maxon-ec60flat-200W, gearhead: none, encoder: none, drum_encoder: none}
loads: {peak_torque_Nm: 2.0}
"""


def drive_of(half_deg: float, more: str = "") -> SpurDrive:
    drive = load_text(TEXT.replace("HALF", str(half_deg)) + more).drive
    assert isinstance(drive, SpurDrive)
    return drive


@pytest.fixture(scope="module")
def turns() -> SpurLayout:
    """A drum that turns two and a quarter times each way."""
    layout = layout_of(drive_of(810.0))
    assert isinstance(layout, SpurLayout)
    return layout


def test_the_rules_give_a_drum_of_many_turns_that_passes(turns: SpurLayout) -> None:
    drive = turns.drive
    assert drive.whole_drum and not drive.stopped
    found = run_all(checks_of(drive), turns)
    assert not [r.id for r in found if r.status == "fail"]
    assert "stop_pin" not in {item.name for item in turns.bill().items} and not turns.drum.has_slot
    told = {r.id for r in found}
    assert {"turns_on_drum", "no_stop"} <= told and not {"stop_slot", "stop_pin", "wrap_under_turn"} & told


def test_turns_beside_each_other_on_the_drum_as_drawn(turns: SpurLayout) -> None:
    """Distances of the drawn centre line to itself and to the pockets, against the check's closed form."""
    drive, d = turns.drive, turns.drum
    lengths = [turns.cable_paths(float(a))[0].length_mm for a in np.linspace(-14.1, 14.1, 7)]
    assert np.ptp(lengths) < 1e-9 * lengths[0], lengths
    check = turns_on_drum
    pocket_gaps = []
    (path,) = turns.cable_paths(0.0)
    for t, run in zip(d.tensioners, sorted(drive.cables, key=lambda c: c.step), strict=True):
        pieces = [p for n, p in path.pieces if n in {f"{kind}_{run.name}" for kind in ("drum", "lay", "dead")}]
        points = np.concatenate([p.points(np.linspace(0.0, 1.0, 4001)) for p in pieces])
        assert np.allclose(np.hypot(points[:, 0], points[:, 2]), t.radius_mm, atol=0.02)
        angle = np.unwrap(np.arctan2(points[:, 0], points[:, 2]))
        order = np.argsort(angle)
        angle, y = angle[order], points[order, 1]
        # The same place one turn further.
        apart = np.abs(np.interp(angle + tau, angle, y, right=np.nan) - y)
        turn = drive.helix_lead_mm * drive.total_ratio
        assert np.nanmax(apart) == pytest.approx(turn, rel=1e-6)
        along = t.side * angle
        along -= tau * round((along.min() - drive.landing_rad) / tau)
        off = along - t.anchor_rad + tau
        beside = (off > 0.0) & (off < atan2(t.pocket_end, t.radius_mm))
        pocket_gaps.append(float(np.abs(y[beside] - t.y_mm).min()) - d.nut_pocket - turns.flank_mm)
    told = run_check(check, turns)
    assert told.actual == pytest.approx(min(pocket_gaps), abs=2e-3), (told, pocket_gaps)


def test_terminals_come_by_the_input_and_their_pockets_stay_apart(turns: SpurLayout) -> None:
    drive, d = turns.drive, turns.drum
    rear, front = d.tensioners
    assert not rear.front and front.front and rear.y_mm < 0.0 < front.y_mm
    assert d.pocket_y(rear, d.nut_pocket)[1] < d.pocket_y(front, d.nut_pocket)[0]
    nut = drive.tensioner.nut_across_flats_mm / 3**0.5
    furthest = max(hypot(t.radius_mm + nut, t.nuts_end) for t in d.tensioners)
    furthest = max(furthest, *(hypot(t.radius_mm, t.last_tip) for t in d.tensioners))
    assert furthest < turns.frame.shelf_bottom_z and furthest < drive.centre_distance_mm - drive.input_radius_mm


def test_the_ring_is_one_solid_of_its_volume(turns: SpurLayout) -> None:
    part = DrumSector(turns.drum, 2.5)
    solid = part.solid()
    validate_solid("drum", solid)
    assert solid.Volume() == pytest.approx(part.volume_mm3(), rel=2e-3)


def test_wraps_of_more_than_a_turn_hold_as_endless_ones(turns: SpurLayout) -> None:
    """Friction of 0.15 over a turn holds e^0.94: at the test torque nothing slips as far as the terminals."""
    loads = turns.loads
    torque = turns.drive.loads.test_torque_Nm * np.array([0.0, 1.0])
    endless = np.ptp(solve_equilibrium(loads.si, torque).drum_angle_rad)
    _, on_drum = turns.wraps_rad(0.0)
    assert on_drum.min() > 2 * tau
    real = np.ptp(solve_equilibrium(loads.si.with_(drum_wrap_rad=on_drum), torque).drum_angle_rad)
    assert real == pytest.approx(endless, rel=1e-9)


def test_a_closed_web_turns_as_a_ring_in_shear() -> None:
    """T (1/a^2 - 1/b^2) / (4 pi G t), the exact solution; a seam that is left open turns 15 % further."""
    modulus, nu, a, b, t = 71700.0, 0.33, 10.0, 50.0, 2.0
    exact = 1e3 / (4 * pi * modulus / (2 * (1 + nu)) * t) * (1 / a**2 - 1 / b**2)
    mesh = sector_mesh(SectorShape(pi, a, (RimStep(b, 0.0, t),)), b / 14)
    parts = elements(mesh.node_mm, mesh.corner, mesh.thickness_mm, modulus, nu)
    stiffness = parts.stiffness.copy()
    held = np.isclose(mesh.radius_mm[mesh.corner], a)
    for k in range(8):
        stiffness[:, k, k] += 1e9 * held[:, k // 2]
    rim = np.flatnonzero(np.isclose(mesh.radius_mm, b))
    angle = mesh.angle_rad[rim]
    share = np.gradient(angle)
    share[[0, -1]] /= 2.0
    load = np.zeros((2 * len(mesh.node_mm), 1))
    load[2 * rim, 0], load[2 * rim + 1, 0] = np.cos(angle) * share, -np.sin(angle) * share
    load *= 1e3 / b / share.sum()
    moved = mesh.solved(stiffness, load)
    assert float(load[:, 0] @ moved[:, 0]) / 1e3 == pytest.approx(exact, rel=2e-3)
    cut = solve(mesh.corner, stiffness, load)
    assert float(load[:, 0] @ cut[:, 0]) / 1e3 > 1.1 * exact


def test_a_printed_drum_has_lugs_up_to_the_turn_beside_them() -> None:
    """Rules lengthen stud and lead until the terminal of a long fibre rope reaches its preload and its lug holds."""
    more = "rope: {type: uhmwpe-1}\ndrum: {material: pla}\nsupport: {material: pla}\n"
    s = layout_of(drive_of(270.0, more))
    assert isinstance(s, SpurLayout)
    found = {r.id: r for r in run_all(checks_of(s.drive), s)}
    assert not [r for r in found.values() if r.status == "fail"]
    assert found["take_up"].actual >= found["take_up"].limit and s.drum.lug_reach > s.drum.nut_pocket
    for t in s.drum.tensioners:
        # Most of its side is wound at one end of the travel.
        turned = t.side * s.half_travel_rad
        (path,) = s.cable_paths(turned)
        piece = next(p for n, p in path.pieces if n == f"drum_{t.cable_name}")
        x, y, z = piece.points(np.linspace(0.0, 1.0, 4001)).T
        off = np.arctan2(x, z) - turned - np.arctan2(*t.at(t.lug_start))
        near = np.abs((off + pi) % tau - pi) < 0.25
        low, high = s.drum.lug_y(t)
        gap = np.maximum(low - y[near], y[near] - high).min() - s.flank_mm
        assert near.any() and gap >= s.drive.drum_material.min_wall_mm - 0.01, gap


def test_an_input_of_too_many_turns_names_travel_and_ratio() -> None:
    with pytest.raises(InputError, match="too many turns on the input") as caught:
        load_text(TEXT.replace("HALF", "1080.0").replace("6.0", "20.0"))
    assert "input_to_drum" in str(caught.value)


def test_a_sector_that_is_too_small_names_the_whole_drum() -> None:
    drive = drive_of(100.0, "drum: {sector_half_angle_deg: 170.0}\n")
    wider = replace(drive, half_travel_deg=200.0)
    (told,) = run_all([c for c in checks_of(wider) if c.id == "wrap_under_turn"], layout_of(wider))
    assert told.status == "fail" and "drum.sector_half_angle_deg to 180" in told.remedy, told


@pytest.mark.parametrize(
    ("more", "what"),
    [
        ("drum: {sector_half_angle_deg: 177.0}\n", "no gap is left"),
        ("drum: {sector_half_angle_deg: 180.0}\nCROSSED", "two anchored cables would cross"),
        ("drum: {sector_half_angle_deg: 180.0}\nidlers: {pairs: 1}\n", "no whole drum beside idlers"),
    ],
)
def test_what_a_whole_drum_cannot_have(more: str, what: str) -> None:
    text = TEXT.replace("HALF", "60.0") + more.replace("CROSSED", "")
    if "CROSSED" in more:
        text = text.replace("{input_to_drum: 6.0}", "{input_to_drum: 6.0, cables: two_anchored}")
    with pytest.raises(InputError, match=what):
        load_text(text)


def stated(half_deg: float, ratio: float, radius_mm: float, torque_Nm: float, more: str = "") -> SpurDrive:
    text = TEXT.replace("HALF", str(half_deg)).replace("drive: {", "#").replace("2.0}", f"{torque_Nm}}}")
    drive = load_text(text.replace("6.0}", f"{ratio}, drum_radius_mm: {radius_mm}}}") + more).drive
    assert isinstance(drive, SpurDrive)
    return drive


@pytest.mark.parametrize(
    ("asked", "rope", "thicker"),
    [((300.0, 6.0, 40.0, 3.0), "FF-081", "7x7-1.0"), ((130.0, 15.0, 70.0, 2.0), "7x7-0.61", "FF-081")],
)
def test_a_stated_radius_takes_the_thickest_rope_that_bends_on_its_input(
    asked: tuple[float, float, float, float], rope: str, thicker: str
) -> None:
    """The thinnest rope for the usual preload bent too sharply; with less preload a thinner one holds."""
    drive = stated(*asked)
    assert drive.cable.name == rope
    assert not [r.id for r in run_all(checks_of(drive), layout_of(drive)) if r.status == "fail"]
    assert "bend_ratio" in {
        r.id
        for r in run_all(
            [check for check in checks_of(drive) if check.id == "bend_ratio"],
            layout_of(stated(*asked, f"rope: {{type: {thicker}}}\n")),
        )
        if r.status == "fail"
    }


@pytest.mark.slow
def test_the_web_of_a_wide_rim_bears_its_stress() -> None:
    drive = stated(150.0, 12.0, 90.0, 8.0)
    assert drive.drum.web_thickness_mm > 2.0
    assert not [r.id for r in run_all(checks_of(drive), layout_of(drive)) if r.status == "fail"]
