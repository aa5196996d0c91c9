"""The fast estimate of the frame's windup compared with solid finite elements; frames with the motors above."""

from dataclasses import replace
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.studies import random_designs
from benchmarks.studies.random_drums import ALLOWED, ALLOWED_STRESS, by_both, drums
from mbcdm_cad.checks.size import estimated_mass_g
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, new_design_text
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.checks import box_mm
from mbcdm_cad.layouts.miso_bevel.drive import bevel
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support.stiffness import frame_compliance, seat_loads
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.parts.bill import CABLE
from mbcdm_cad.workshop.interference import answers
from mbcdm_cad.workshop.kernel import validate_faces, validate_solid
from tests.acceptance.test_docs_commands import EDITS, EXCLUDED
from tests.acceptance.test_docs_commands import failing as failing_edit
from tests.acceptance.test_docs_commands import requirements as reference
from tests.support.frame_fe import SupportFE, brick_stiffness, seats
from tests.support.interference_of_solids import body, run_of
from tests.support.random_generator import PRINTED, Passing, failing, load, requirements
from tests.support.reference import ABOVE, PARAMS, REFERENCE

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


pytest.importorskip("gmsh", reason="solid elements: pip install --require-hashes -r tests/requirements-solids.lock")
pytest.importorskip("skfem", reason="solid elements: pip install --require-hashes -r tests/requirements-solids.lock")


@pytest.mark.slow
@pytest.mark.parametrize("file", ["mbcdm", "how-to/leg", "siso_spur"])
def test_plane_elements_agree_with_solid_ones(file: str) -> None:
    """In the leg a thin web bends out of its plane."""
    found = by_both(load_design(PARAMS / f"{file}.yaml"))
    assert abs(found.off) <= ALLOWED and abs(found.web_off) <= ALLOWED_STRESS, found


@pytest.mark.slow
def test_plane_elements_agree_with_solid_ones_on_random_drums_of_the_other_layouts() -> None:
    others = [d for d in islice(drums(), 4) if d.drive.configuration in ("siso_bevel", "miso_spur")]
    found = [by_both(loaded) for loaded in others]
    assert len(found) == 2
    held = (abs(drum.off) <= ALLOWED and abs(drum.web_off) <= ALLOWED_STRESS for drum in found)
    assert all(held), "\n".join(map(str, found))


pytest.importorskip("gmsh", reason="solid elements: pip install --require-hashes -r tests/requirements-solids.lock")
pytest.importorskip("skfem", reason="solid elements: pip install --require-hashes -r tests/requirements-solids.lock")
# Folded plates for a frame of thick walls, in which one part of the drive's turn in three arises.
FRAME, PULLEY = 0.16, 0.10


def _layout(name: str) -> SectorLayout:
    layout = layout_of(load_design(PARAMS / f"{name}.yaml").drive)
    assert isinstance(layout, SectorLayout)
    return layout


@pytest.mark.slow
@pytest.mark.parametrize("name", ["siso_spur", "siso_bevel"])
def test_folded_plates_agree_with_solid_elements(name: str, tmp_path: Path) -> None:
    from tests.support.frame_solid import frame_by_solids

    layout = _layout(name)
    found = layout.frame_compliance
    assert found is not None
    solid, _ = frame_by_solids(layout, tmp_path)
    off = found.windup_urad_Nm / solid - 1.0
    assert abs(off) < FRAME, f"plates {found.windup_urad_Nm:.2f}, solid elements {solid:.2f} urad per N m: {off:+.1%}"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["siso_spur", "siso_bevel"])
def test_torsion_of_an_input_pulley_agrees_with_solid_elements(name: str, tmp_path: Path) -> None:
    from tests.support.drum_solid import pulley_torsion_urad_Nm

    layout = _layout(name)
    found = next(c.urad_Nm for c in structure_of(layout).causes if c.name == "input pulleys, torsion")
    solid = pulley_torsion_urad_Nm(layout, tmp_path)
    assert found == pytest.approx(solid, rel=PULLEY), f"{found:.2f} by steps, {solid:.2f} urad per N m by solids"


MESH_MM = 0.05


@pytest.mark.slow
def test_all_choices_together_clash_nowhere_and_weigh_what_was_estimated() -> None:
    drive = bevel(load_text(new_design_text("arranged")).drive)
    drive = replace(
        drive,
        centre_distance_mm=42.0,
        input_setback_mm=1.2,
        helix_lead_mm=0.89,
        input_pulleys=replace(drive.input_pulleys, surface="grooved"),
        gearhead=replace(drive.gearhead, screw_count=3),
        support=replace(drive.support, back_y_mm=drive.support.back_y_mm - 1.2),
    )
    dims = BevelLayout(drive)
    centred = bill(dims)
    solids = {name: spec.part.solid() for name, spec in centred.parts.items() if not name.startswith(CABLE)}
    for name in ("frame", "top_plate", "gearhead", "input_pulley_left", "input_pulley_right"):
        validate_solid(name, solids[name])
        validate_faces(name, solids[name])
    mass = sum(
        solids[item.part].Volume() * item.material.density_g_cm3 * 1e-3 if item.mass_g is None else item.mass_g
        for item in centred.items
    )
    design = BevelLayout(drive)
    assert estimated_mass_g(centred) == pytest.approx(mass, rel=0.01)
    assert box_mm(design)[2] == pytest.approx(drive.drum.hub_face_y_mm - drive.support.back_y_mm)
    run = run_of(dims, {name: body(name, solid, MESH_MM) for name, solid in solids.items()}, (-35.0, 35.0))
    clashes = run.clashes(answers(run, {}, 1))
    assert not clashes, "\n".join(map(str, clashes))


POSES = 3


def short(ratio: float, radius_mm: float, half_deg: float, torque_Nm: float, **blocks: Any) -> dict[str, Any]:
    return {
        "name": "raised",
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": half_deg},
        "transmission": {"ratio": ratio, "drum_radius_mm": radius_mm, **blocks.pop("transmission", {})},
        "loads": {"peak_torque_Nm": torque_Nm},
        "drive": {"motor_side": "above", **blocks.pop("drive", {})},
        **blocks,
    }


# Each kind of drive that the layout has, two in one design where neither changes what the other tests.
DESIGNS = {
    "large, four screws": short(12.0, 150.0, 30.0, 25.0),
    "small, grooved": short(6.0, 34.0, 20.0, 0.5, input_pulleys={"surface": "grooved"}),
    "printed, three screws, turned": short(
        9.0, 80.0, 30.0, 2.0, drive={"gearhead": "gearhead-76-22", "gearhead_angle_deg": 40.0}, **PRINTED
    ),
    "flat motors without gearheads": short(9.0, 80.0, 30.0, 1.0, drive={"gearhead": "none"}),
    "below, three screws, turned": short(
        8.0, 60.0, 20.0, 3.0, drive={"gearhead": "gearhead-76-22", "gearhead_angle_deg": -25.0, "motor_side": "below"}
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", DESIGNS)
def test_built_as_foreseen(name: str) -> None:
    loaded = load(DESIGNS[name])
    assert not failing(loaded)
    failures = list(random_designs.exercise(Passing(0, DESIGNS[name], loaded), POSES))
    assert not failures, "\n".join(f"{f.stage}: {f.what}" for f in failures)


@pytest.mark.slow
def test_the_workshop_can_make_it() -> None:
    """Every drawing but the drum's, which is that of motors below, makes its part; a forced build is never a crash."""
    data = DESIGNS["flat motors without gearheads"]
    failures = list(random_designs.exercise_workshop(Passing(0, data, load(data)), ("drum",)))
    assert not failures, "\n".join(f"{f.stage}: {f.what}" for f in failures)


@pytest.mark.parametrize("name", [name for name in EDITS if name not in EXCLUDED])
def test_one_edit_of_the_reference_passes_with_motors_above(name: str) -> None:
    data = reference()
    EDITS[name](data)
    data["drive"]["motor_side"] = "above"
    assert failing_edit(data) == {}


@pytest.mark.slow
def test_motors_above_reach_as_far_as_motors_below() -> None:
    """Of random requirements, all that pass with motors below pass with motors above."""
    passed = 0
    for seed in range(1, 16):
        found = []
        for side in ("below", "above"):
            data = requirements(seed)
            data["drive"] = {"motor_side": side}
            try:
                found.append(not failing(load(data)))
            except InputError:
                found.append(False)
        assert found[1] or not found[0], f"seed {seed} passes with motors below only"
        passed += found[1]
    assert passed >= 12, passed
