"""Joints by friction, the drum's stress and the frame's limit against closed forms written here."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from math import hypot, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.checks.bearings import BEARING_PLAY_MM, coupling_runout
from mbcdm_cad.checks.comparison import CheckResult
from mbcdm_cad.checks.fixings import pulley_stress, set_screws_hold_Nmm, shaft_stress, stalled_Nm
from mbcdm_cad.checks.run import run_all
from mbcdm_cad.checks.structure import drum_stress, frame_windup, mounting_screws, payload_screws, stiffness
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, new_design_text
from mbcdm_cad.layouts.miso_bevel.checks import CHECKS
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import pulley_sections, structure_of
from mbcdm_cad.parts.drum_sector import dims
from mbcdm_cad.parts.fits import clamp_force_N, screw_hold
from tests.support.checked import failing, of_params, result
from tests.support.reference import PARAMS
from tests.unit.checks.designs import put, reference

REFERENCES = ("mbcdm", "siso_spur", "miso_spur", "siso_bevel")
# Force of a tightened screw of class 8.8, N: 0.7 x 640 N/mm2 over the stress area of ISO 898, mm2.
M25_N, M3_N = 0.7 * 640.0 * 3.39, 0.7 * 640.0 * 5.03
SHORT = """name: leg
configuration: siso_spur
travel: {{half_angle_deg: 50.0}}
transmission: {{input_to_drum: 8.0, drum_radius_mm: 60.0}}
loads: {{peak_torque_Nm: {peak}}}
"""


def sector(drive: Drive) -> SectorLayout:
    assert isinstance(layout_of(drive), SectorLayout)
    return layout_of(drive)


def test_payload_slips_at_four_times_mu_f_r() -> None:
    s = sector(reference())
    slips = 4 * 0.15 * M25_N * s.drum.payload_circle_radius * 1e-3
    found = payload_screws(s)
    assert s.drum.payload_screw_thread == 2.5
    assert found.actual == pytest.approx(slips / s.drive.loads.peak_torque_Nm, rel=2e-3), found


def _arms_mm(s: SectorLayout) -> float:
    """Sum of the distances of the mounting screws from their middle."""
    places = s.frame.mounts
    x, z = (sum(p[k] for p in places) / len(places) for k in (0, 1))
    return sum(hypot(p[0] - x, p[1] - z) for p in places)


def test_frame_slips_at_mu_f_times_the_arms_of_its_screws() -> None:
    s = sector(reference())
    slips = 0.15 * M3_N * _arms_mm(s) * 1e-3
    assert mounting_screws(s).actual == pytest.approx(slips / s.drive.loads.peak_torque_Nm, rel=2e-3)


def test_a_printed_frame_is_clamped_by_what_the_ring_under_a_washer_bears() -> None:
    s = sector(reference())
    soft = replace(s.drive.frame_material, yield_MPa=20.0, process="printed")
    printed = sector(put(s.drive, "frame_material", soft))
    found = mounting_screws(printed)
    # ISO 7089: 7 mm for M3; ISO 273: 3.4 mm.
    clamp = 0.4 * 20.0 * pi / 4 * (7.0**2 - 3.4**2)
    slips = 0.15 * clamp * _arms_mm(printed) * 1e-3
    assert clamp < M3_N and found.actual == pytest.approx(slips / s.drive.loads.peak_torque_Nm, rel=2e-3), found


LEG = """
name: leg
configuration: siso_spur
travel: {half_angle_deg: 60.0}
transmission: {input_to_drum: 9.0}
loads: {peak_torque_Nm: 30.0, stiffness_Nm_rad: 1.0}
drum: {material: pa12, output_screws: 8}
support: {material: pa12}
limits: {losses: counted, frame_windup_max_mrad: 2.5}
"""


@cache
def leg(more: str = "") -> SectorLayout:
    return sector(load_text(LEG + more).drive)


def test_a_leg_of_pa12_holds_with_inserts_only() -> None:
    """Cut threads creep: inserts let the base press on brass, and bear in the plastic across."""
    cut, inserts = leg(), leg("printing: {threads: inserts}")
    assert set(failing(cut)) == {"mounting_screws"}
    remedy = result(cut, "mounting_screws").remedy
    assert "set printing.threads to inserts" in remedy, remedy
    assert not failing(inserts)


def test_threads_cut_in_a_printed_plate_hold_what_creep_leaves() -> None:
    s = leg()
    thread, plate = s.mounting.thread_mm, s.drive.support.plate_mm
    # Three quarters of the thread's cylinder sheared, 0.4 of the yield stress over the root of three.
    clamp = 0.4 * 45.0 / sqrt(3.0) * 0.75 * pi * thread * min(2.0 * thread, plate)
    assert s.drive.frame_material.yield_MPa == 45.0
    slips = 0.15 * clamp * _arms_mm(s) * 1e-3
    assert mounting_screws(s).actual == pytest.approx(slips / 30.0, rel=2e-3), mounting_screws(s)


def test_an_insert_is_clamped_on_brass_and_bears_in_the_plastic() -> None:
    drive = leg("printing: {threads: inserts}").drive
    insert = drive.insert(drive.frame_material, 4.0)
    assert insert is not None
    held = screw_hold(4.0, drive.frame_material, insert, 8.0)
    # ISO 273: 4.5 mm; brass yields at 250 MPa.
    brass = 250.0 * pi / 4 * (insert.hole_mm**2 - 4.5**2)
    assert held.clamp_N == pytest.approx(brass) and held.slips_N(0.15) == pytest.approx(0.15 * brass)
    strips = 0.4 * 45.0 * pi * insert.outside_mm * insert.length_mm * 0.75 / sqrt(3.0)
    assert held.pull_N == pytest.approx(min(brass, strips), rel=1e-3)
    soft = replace(drive.frame_material, yield_MPa=2.0)
    bears = 0.4 * 2.0 * insert.outside_mm * insert.length_mm
    assert screw_hold(4.0, soft, insert, 8.0).slips_N(0.15) == pytest.approx(bears), "the insert moves in the plastic"


def test_a_thin_hub_is_judged_by_torsion() -> None:
    s = sector(reference())
    weak = replace(s.drive.drum_material, yield_MPa=20.0)
    thin = put(put(s.drive, "drum_material", weak), "drum.hub_diameter_mm", 2.0 * s.drum.bore_radius + 0.3)
    found = drum_stress(sector(thin))
    outer, bore = 2.0 * sector(thin).drum.hub_radius, 2.0 * s.drum.bore_radius
    torque = float(found.subject.split(" at ")[-1].split(" N m")[0])
    # 2.5: what solid elements give beside the web, over an even tube, within 17 %.
    shear = 2.5 * 16 * torque * 1e3 * outer / (pi * (outer**4 - bore**4))
    assert "in the hub" in found.subject, found
    assert found.actual == pytest.approx(20.0 / sqrt(3.0) / shear, rel=2e-3), found


@pytest.mark.parametrize("name", ["gallery/hip", "gallery/printed", "how-to/leg"])
def test_shaft_and_journals_count_stalled_motors_as_a_peak_torque_of_that_size(name: str) -> None:
    drive = of_params(name).drive
    stalled = stalled_Nm(sector(drive))
    assert stalled > 1.5 * drive.loads.peak_torque_Nm, stalled
    asked = replace(drive, loads=replace(drive.loads, peak_torque_Nm=stalled))
    for check in (shaft_stress, pulley_stress):
        found, other = check(sector(drive)), check(sector(asked))
        assert found.actual == pytest.approx(other.actual, rel=1e-6), (found, other)


def test_a_printed_pulley_counts_with_what_creep_leaves() -> None:
    drive = reference()
    metal = replace(drive.pulley_material, yield_MPa=50.0)
    found = [
        pulley_stress(sector(put(drive, "pulley_material", m))) for m in (metal, replace(metal, process="printed"))
    ]
    assert found[1].actual == pytest.approx(0.4 * found[0].actual, rel=1e-9), found


def test_set_screws_hold_by_the_forces_on_the_shaft() -> None:
    """Friction wherever the shaft is pressed: at both points, and where the bore carries the two thrusts together."""
    s = sector(reference())
    screw, radius = s.drive.screw(s.drum.set_screw), s.drum_shaft.radius
    thrust = 0.5 * clamp_force_N(screw.thread_mm)
    points = [thrust * np.array([np.sin(a), np.cos(a)]) for a in np.radians(dims.SET_SCREW_ANGLES_DEG)]
    pressed = [*points, -sum(points)]
    assert np.abs(sum(pressed)).max() < 1e-9 * thrust
    held = 0.15 * radius * sum(float(np.linalg.norm(force)) for force in pressed)
    assert set_screws_hold_Nmm(screw, radius) == pytest.approx(held, rel=1e-9)


@pytest.mark.parametrize("name", REFERENCES)
def test_the_references_hold_with_their_stated_margin(name: str) -> None:
    s = sector(of_params(name).drive)
    for check in (drum_stress, payload_screws, mounting_screws, frame_windup):
        assert check(s).holds, check(s)


def test_a_limit_that_is_left_out_is_the_turn_of_the_cables() -> None:
    s = sector(load_text(SHORT.format(peak=3.0)).drive)
    assert s.drive.limits.frame_windup_max_mrad is None
    cables = structure_of(s).cables_urad_Nm * s.drive.loads.test_torque_Nm * 1e-3
    assert frame_windup(s).limit == pytest.approx(cables), f"{frame_windup(s)}, cables {cables} mrad"
    advice = frame_windup.advice
    assert callable(advice)
    # The walls with the largest shares, the fields that thicken them, and the limit that nobody stated.
    assert s.frame_compliance is not None
    most = max(s.frame_compliance.shares_urad_Nm.items(), key=lambda share: share[1])[0]
    bridge = f"support.bridge_mm ({s.drive.support.bridge_mm:g})"  # type: ignore[attr-defined]
    for word in (f"({most} ", bridge, "limits.frame_windup_max_mrad, left out the cables' turn"):
        assert word in advice(s), advice(s)


def test_stiffness_is_a_figure_unless_it_is_asked_for() -> None:
    s = sector(reference())
    free = stiffness(s)
    assert free.sense == 0 and free.actual == pytest.approx(structure_of(s).stiffness_Nm_rad)
    assert not stiffness(sector(put(s.drive, "loads.stiffness_Nm_rad", free.actual * 1.01))).holds
    assert stiffness(sector(put(s.drive, "loads.stiffness_Nm_rad", free.actual * 0.99))).holds


@given(st.floats(0.1, 200.0), st.floats(8.0, 60.0), st.floats(2.0, 6.0))
def test_a_joint_holds_or_no_thread_with_walls_does(peak: float, hub: float, bore: float) -> None:
    material = reference().drum_material
    candidates = dims.joints(material, lambda _: None)
    found = dims.payload_joint(candidates, dims.JointLoad(peak), (hub + bore) / 2, hub, bore, material.min_wall_mm)
    holds = found.slips_Nm((hub + bore) / 2) >= dims.SLIP_SAFETY * peak
    stronger = [
        thread
        for thread in (3.0, 4.0, 5.0, 6.0)
        if thread + 2 * material.min_wall_mm + bore <= hub
        and dims.PayloadJoint(thread, material, None).slips_Nm((hub + bore) / 2) >= dims.SLIP_SAFETY * peak
    ]
    assert holds or not stronger, f"M{found.thread_mm:g} does not hold {peak} N m, {stronger} would"


@pytest.mark.parametrize("peak", [1.0, 10.0, 40.0])
def test_the_hub_grows_until_the_payload_holds(peak: float) -> None:
    s = sector(load_text(SHORT.format(peak=peak)).drive)
    assert payload_screws(s).holds, payload_screws(s)


def test_a_pulley_turns_in_its_bearing_as_beam_elements_of_its_steps_do() -> None:
    """A thin journal beside a long land bends little: the land's thickness counts where it lies."""
    s = sector(load_design(PARAMS / "siso_spur.yaml").drive)
    p, (lower, upper) = s.inputs[0], s.input_bearings_mm(0)
    steps = pulley_sections(p)
    cuts = {z for part in steps for z in (part.start_mm, part.end_mm) if lower < z < upper}
    z = np.unique([lower, upper, *cuts, *np.linspace(p.land_bottom_z, p.land_top_z, 41)])
    modulus = s.drive.pulley_material.youngs_modulus_GPa * 1e3
    k = np.zeros((2 * len(z), 2 * len(z)))
    for n, (a, b) in enumerate(pairwise(z)):
        part, h = next(t for t in steps if t.start_mm <= (a + b) / 2 <= t.end_mm), b - a
        bends = modulus * pi / 4 * (part.radius_mm**4 - part.bore_mm**4) / h**3
        k[2 * n : 2 * n + 4, 2 * n : 2 * n + 4] += bends * np.array(
            [
                [12, 6 * h, -12, 6 * h],
                [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                [-12, -6 * h, 12, -6 * h],
                [6 * h, 2 * h * h, -6 * h, 4 * h * h],
            ]
        )
    free = np.delete(np.arange(2 * len(z)), [0, 2 * len(z) - 2])
    # Slope at the lower bearing for 1 N at each place of the land.
    turned = np.linalg.inv(k[np.ix_(free, free)])[0]
    across = {int(f) // 2: t for f, t in zip(free, turned, strict=True) if f % 2 == 0}
    slope = max(abs(t) for n, t in across.items() if p.land_bottom_z <= z[n] <= p.land_top_z)
    pull = max(float(np.linalg.norm(loads.inputs[0].force_N)) for loads in s.loads.on_bodies)
    overhang = lower - (s.collar.bottom_z + s.collar.top_z) / 2
    assert coupling_runout(s).actual - BEARING_PLAY_MM / 2 == pytest.approx(pull * slope * overhang, rel=0.02)


ROPES = package_entries("ropes")
OWN_MODULUS = ("  modulus_GPa:", "  modulus_area:")


def _with_rope(rope: str, termination: str = "") -> Drive:
    """The reference drive on another rope, with the rope's own modulus."""
    lines = new_design_text("reference").splitlines()
    kept = [line for line in lines if not line.startswith(OWN_MODULUS)]
    text = "\n".join(line.replace("type: FF-081", f"type: {rope}") for line in kept) + "\n"
    if termination:
        text = text.replace("  friction_coefficient:", f"  termination: {termination}\n  friction_coefficient:")
    return load_text(text).drive


def _result(drive: Drive, check_id: str) -> CheckResult:
    return next(r for r in run_all(CHECKS, BevelLayout(drive)) if r.id == check_id)


@pytest.mark.parametrize("rope", ROPES)
def test_every_rope_of_the_package_has_an_end_and_a_terminal_that_fit(rope: str) -> None:
    drive = _with_rope(rope)
    assert drive.termination.fits(drive.cable), (rope, drive.termination.name)
    d, end = drive.cable.diameter_mm, drive.termination
    fitting = [n for n, t in package_entries("tensioners").items() if t["swage_diameter_mm"] >= end.sleeve_ratio * d]
    assert fitting, f"{rope}: no sleeve of {end.sleeve_ratio * d:.2f} mm"


def test_the_default_follows_the_construction() -> None:
    names = {rope: _with_rope(rope).termination.name for rope in ROPES}
    wires = {names[rope] for rope, entry in ROPES.items() if entry["construction"] != "braid"}
    assert wires == {"swaged"}, names
    thick = {names[r] for r, e in ROPES.items() if e["construction"] == "braid" and e["diameter_mm"] >= 1.0}
    thin = {names[r] for r, e in ROPES.items() if e["construction"] == "braid" and e["diameter_mm"] < 1.0}
    assert (thick, thin) == ({"spliced"}, {"potted"}), names


def test_a_wire_rope_cannot_be_spliced_and_the_remedy_says_what_can_be_done() -> None:
    found = _result(_with_rope("FF-081", "spliced"), "termination_fits")
    assert found.status == "fail" and "not on 7x7" in found.message, found
    assert "swaged or crimped or soldered or ball or potted or clamped" in found.remedy, found.remedy
    assert _result(_with_rope("FF-081", "soldered"), "termination_fits").status == "pass"


def test_a_weaker_end_holds_less() -> None:
    strong, weak = (_result(_with_rope("FF-081", name), "cable_ends") for name in ("swaged", "potted"))
    assert strong.actual is not None and weak.actual is not None
    assert weak.actual / strong.actual == pytest.approx(0.6 / 0.9), (strong, weak)


def test_a_rope_too_thick_for_the_sleeve_is_told_which_terminal_takes_it() -> None:
    found = _result(_with_rope("7x7-2.4"), "sleeve_fits")
    assert found.status == "fail" and found.remedy == "choose drum.tensioner: M4", found
    thick = replace(reference(), cable=replace(reference().cable, diameter_mm=20.0))
    assert "thinner rope" in _result(thick, "sleeve_fits").remedy


def test_an_unknown_termination_is_named() -> None:
    with pytest.raises(InputError, match="not in the catalogue of terminations"):
        _with_rope("FF-081", "glued")


SHORT_OF_ENDS = """name: ends
configuration: {layout}
travel: {{half_angle_deg: 35.0}}
{transmission}
loads: {{peak_torque_Nm: 2.0}}
rope: {{{rope}}}
"""
SPUR = "transmission: {input_to_drum: 8.0}"


def _short(rope: str, layout: str = "siso_spur", transmission: str = SPUR) -> Drive:
    return load_text(SHORT_OF_ENDS.format(layout=layout, transmission=transmission, rope=rope)).drive


@pytest.mark.parametrize("end", [n for n, e in package_entries("terminations").items() if "7x7" in e["constructions"]])
def test_an_end_holds_its_share_of_the_rope(end: str) -> None:
    drive = _with_rope("7x7-1.0", end)
    highest = layout_of(drive).loads.highest_N
    held = package_entries("terminations")[end]["strength_share"] * 808.0 / highest
    assert _result(drive, "cable_ends").message.startswith(f"{end} "), end
    at_terminal = float(_result(drive, "cable_ends").message.split("N over")[0].split(":")[1]) / highest
    assert at_terminal == pytest.approx(held, rel=1e-3), (end, at_terminal, held)


@pytest.mark.parametrize(("end", "rope"), [("knotted", "7x7"), ("clamped", "braid"), ("crimped", "braid")])
def test_an_end_that_its_rope_does_not_stand_is_refused_with_those_that_fit(end: str, rope: str) -> None:
    drive = _with_rope("FF-081" if rope == "7x7" else "uhmwpe-1", end)
    found = _result(drive, "termination_fits")
    assert found.status == "fail" and f"not on {rope}" in found.message, found
    assert end not in found.remedy and ("swaged" if rope == "7x7" else "spliced") in found.remedy, found.remedy


@pytest.mark.parametrize(
    ("layout", "transmission", "end", "kind"),
    [
        ("siso_spur", SPUR, "knotted", "braid"),
        ("siso_spur", SPUR, "clamped", "7x7"),
        ("miso_spur", SPUR, "crimped", "7x7"),
        ("siso_bevel", "transmission: {drum_radius_mm: 80.0, input_to_drum: 4.0}", "ball", "7x7"),
        ("miso_bevel", "transmission: {drum_radius_mm: 54.0, ratio: 9.0}", "crimped", "7x7"),
    ],
)
def test_ends_by_name_choose_rope_and_terminal(layout: str, transmission: str, end: str, kind: str) -> None:
    drive = _short(f"termination: {end}", layout, transmission)
    failed = failing(drive)
    assert drive.cable.construction == kind, drive.cable.name
    assert not failed.keys() & {"cable_ends", "termination_fits", "sleeve_fits", "take_up", "tension"}, failed


def test_a_knot_takes_rope_and_take_up_and_says_how_it_is_tied() -> None:
    spliced, knotted = (
        _short(f"type: uhmwpe-1, preload_N: 10.0, termination: {end}") for end in ("spliced", "knotted")
    )
    plans = [layout_of(drive).tensioning for drive in (spliced, knotted)]
    a, b = (plan.cables[0] for plan in plans)
    entry = package_entries("terminations")["knotted"]
    # One end a side of the one cable; the rope is 1 mm thick.
    assert b.need.setting_m == pytest.approx(entry["setting_ratio"] * 1e-3), b
    assert b.need.total_m - a.need.total_m == pytest.approx(entry["setting_ratio"] * 1e-3, rel=0.05), (a, b)
    beyond = [(s.cut_length_m - s.finished_m) * 1e3 for s in (a, b)]
    assert beyond[1] - beyond[0] > 0.9 * entry["tail_ratio"], beyond
    words = " ".join(step.text for step in layout_of(knotted).assembly_order)
    assert entry["making"] in words and "knotted" in words
    assert entry["making"] not in " ".join(step.text for step in layout_of(spliced).assembly_order)
