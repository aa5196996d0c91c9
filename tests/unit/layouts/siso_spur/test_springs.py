"""Springs in the terminals: give of the cables, preload that is kept, place of each part, checks and remedies."""

from dataclasses import replace
from itertools import pairwise
from math import exp, log

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.checks.run import run_all
from mbcdm_cad.design.bought import SpringSpec
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.lumped import compliance_of
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.layouts.springs import spring_start_Nm
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.model.creep import DAY_S, relaxation
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.model.stiffness import tangent_stiffness_Nm_rad
from mbcdm_cad.model.wrap import stretch_after_reversal, stretch_first_loading
from mbcdm_cad.parts.terminal import TerminalSpring
from mbcdm_cad.rig.bench import cables_of
from mbcdm_cad.rig.chain import chains, look, settle

TEXT = """name: springs
configuration: siso_spur
travel: {{half_angle_deg: 60.0}}
transmission: {{input_to_drum: 8.0}}
loads: {{peak_torque_Nm: 6.0}}
rope: {{type: {rope}}}
drum: {{{drum}}}
"""
DISCS = "spring: disc-8x4.2x0.4, spring_count: 6, tensioner: M4"


def drive_of(drum: str = DISCS, rope: str = "7x19-1.5") -> SpurDrive:
    drive = load_text(TEXT.format(rope=rope, drum=drum)).drive
    assert isinstance(drive, SpurDrive)
    return drive


@pytest.fixture(scope="module")
def sprung() -> SpurDrive:
    return drive_of()


def wound(drive: SpurDrive, friction: float, wrap_rad: float) -> DriveSI:
    n = len(drive.cables)
    return layout_of(drive).si.with_(
        friction_coefficient=friction, input_wrap_rad=np.full(n, wrap_rad), drum_wrap_rad=np.full(n, wrap_rad)
    )


def test_without_friction_rope_and_springs_are_springs_in_series(sprung: SpurDrive) -> None:
    d = wound(sprung, 1e-9, 2.0)
    length = d.free_span_m + 2.0 * (d.input_radius_m + d.drum_radius_m)
    # Six discs of 1400 N/mm.
    closed = float((d.drum_radius_m**2 / (length / d.axial_stiffness_N + 6 / 1.4e6)).sum())
    assert float(tangent_stiffness_Nm_rad(d, 0.5)) == pytest.approx(closed, rel=1e-6)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.05, 0.3), st.floats(0.1, 2.0), st.floats(0.3, 2.5), st.floats(0.3, 2.5))
def test_the_rig_s_rope_and_spring_stretch_as_the_model_s(mu: float, wrap: float, first: float, second: float) -> None:
    """Pieces that slip one by one, with no law of loading in them, against the closed forms, both ways and back."""
    drive = _KEPT
    (cable, *_) = cables_of(drive)
    d = wound(drive, mu, wrap).with_(input_wrap_rad=np.full(2, wrap))
    cut = replace(cable, friction=mu)
    state = chains((cut,), piece_rad=0.002, transport=False, input_wrap_rad=wrap, drum_wrap_rad=wrap, reach_rad=0.0)
    preload = cable.preload_N
    there, back = np.full(2, first * preload), np.full(2, second * preload)
    for tension, law in (
        (there, stretch_first_loading(d, there)[0]),
        (back, stretch_after_reversal(d, back, there)[0]),
    ):
        reached, slope = look(state, 0, float(law[0]))
        # In stretch: just after a reversal the rope alone is stiff, and a small stretch is much tension.
        assert abs(reached - tension[0]) / slope <= 2e-3 * np.abs(law[0]) + 5e-7, (reached, tension[0], law[0])
        settle(state, 0, float(tension[0]))


def test_friction_keeps_small_loads_from_the_springs(sprung: SpurDrive) -> None:
    mu, wrap = 0.15, 1.5
    d = wound(sprung, mu, wrap)
    rigid = d.with_(anchor_m_N=np.zeros(2))
    arrives = exp(mu * wrap)
    below, above = (np.full(2, share * arrives * d.preload_N[0]) for share in (0.99, 1.2))
    assert np.allclose(stretch_first_loading(d, below)[0], stretch_first_loading(rigid, below)[0])
    more = stretch_first_loading(d, above)[0] - stretch_first_loading(rigid, above)[0]
    assert more[0] == pytest.approx(d.anchor_m_N[0] * d.preload_N[0] * 0.2, rel=1e-9)


def test_the_turn_by_cause_and_the_torque_at_which_a_terminal_moves(sprung: SpurDrive) -> None:
    layout = layout_of(sprung)
    (cause,) = (c for c in structure_of(layout).causes if c.after_slip)
    ends = [layout_of(sprung).si.with_(**wraps) for wraps in layout.wraps_at_ends_rad]
    torque = sprung.loads.test_torque_Nm
    turns = [
        [
            float(np.ptp(solve_equilibrium(x, np.array([0.0, way * torque])).drum_angle_rad))
            for x in (d, d.with_(anchor_m_N=np.zeros(2)))
        ]
        for d in ends
        for way in (1.0, -1.0)
    ]
    assert cause.urad_Nm == pytest.approx(1e6 * max(a - b for a, b in turns) / torque, rel=1e-9)
    # At the torque where it starts, the least held tension ratio is that of the smallest wrap.
    start = spring_start_Nm(layout)
    held = float(layout_of(sprung).si.friction_coefficient) * min(
        float(w["drum_wrap_rad"].min()) for w in layout.wraps_at_ends_rad
    )
    ratios = [
        abs(log(float(t) / c.preload_N))
        for d in ends
        for way in (1.0, -1.0)
        for t, c in zip(solve_equilibrium(d, way * start).tension_N, sprung.cables, strict=True)
    ]
    assert max(ratios) == pytest.approx(held, rel=0.15), (start, held)
    # Rig and robot files have the springs in their cables, or none: not twice.
    lumped = compliance_of(sprung)
    assert lumped.land_to_payload == pytest.approx((structure_of(layout).payload_urad_Nm - cause.urad_Nm) * 1e-6)


def test_springs_keep_preload_while_a_fibre_rope_creeps() -> None:
    bare = drive_of("tensioner: M5", "uhmwpe-1.5")
    soft = drive_of("spring: disc-10x5.2x0.4, spring_count: 12, tensioner: M5", "uhmwpe-1.5")
    rope, preload = soft.cable, soft.cables[0].preload_N
    longest = max(layout_of(soft).tensioned_lengths_mm()) * 1e-3
    give = longest / rope.axial_stiffness_N
    assert layout_of(soft).softer_ends == pytest.approx((give + 12 / 930e3) / give)
    assert layout_of(bare).softer_ends == 1.0
    # The rope's creep in series with rope and springs, step by step: its strain is taken by both.
    hours, tension = np.geomspace(1e-3, 30 * 24.0, 4000), preload
    log_part = rope.creep_per_decade / log(10.0) / rope.breaking_load_N
    for a, b in pairwise(np.concatenate([[0.0], hours])):
        grown = log_part * tension * log((1.0 + b) / (1.0 + a)) + rope.creep_per_year / (365.25 * 24.0) * (
            tension / rope.breaking_load_N / 0.3
        ) ** rope.creep_load_exponent * (b - a)
        tension -= grown * longest / (give + 12 / 930e3)
    left = relaxation(rope, preload, 20.0, layout_of(soft).softer_ends).at_N(30 * DAY_S)
    assert left == pytest.approx(tension, rel=5e-3)
    assert left > relaxation(rope, preload, 20.0).at_N(30 * DAY_S)


def test_nut_springs_and_washers_lie_one_on_the_other(sprung: SpurDrive) -> None:
    items = {item.name: item for item in layout_of(sprung).bill(0.0).items}
    for t in layout_of(sprung).drum.tensioners:
        origin, nut = (
            np.array([row[3] for row in items[name].location.rows])
            for name in (f"spring_washer_{t.cable_name}_1", f"nut_{t.cable_name}_1")
        )
        # 12 mm with washers of 0.8 mm: six discs of 0.6 mm, less what the preload presses together.
        height = 6 * 0.6 + 2 * 0.8 - sprung.cables[0].preload_N * 6 / 1400.0
        assert np.linalg.norm(nut - origin) == pytest.approx(height, rel=1e-3)
    order = [name for step in layout_of(sprung).assembly_order for name in step.items]
    springs = [name for name in items if name.startswith("spring")]
    assert len(springs) == 2 * (6 + 2) and all(order.count(name) == 1 for name in springs)
    words = " ".join(step.text for step in layout_of(sprung).assembly_order)
    assert f"side_1 {6 * 0.6 + 1.6 - sprung.cables[0].preload_N * 6 / 1400.0:.2f}" in words


@pytest.mark.parametrize("name", ["disc-8x4.2x0.4", "coil-1.2x3.4"])
def test_a_drawn_spring_has_height_and_mass_of_its_entry(name: str) -> None:
    spec = SpringSpec(name=name, **package_entries("springs")[name])
    height = 0.5 * (spec.free_mm + spec.solid_mm)
    solid = TerminalSpring(spec, height).solid()
    box = solid.BoundingBox()
    assert (box.zmin, box.zmax) == pytest.approx((0.0, height), abs=1e-3)
    # Ground ends take up to a sixth of a coil.
    assert solid.Volume() * 7.9e-3 == pytest.approx(spec.mass_g, rel=0.03 if spec.kind == "disc" else 0.18)


def test_stiffness_of_the_entries_by_their_standards() -> None:
    """Almen and Laszlo at three quarters of the way flat (DIN EN 16984); EN 13906-1, four active coils."""
    for name, entry in package_entries("springs").items():
        spring = SpringSpec(name=name, **entry)
        if spring.kind == "coil":
            coils = spring.solid_mm / spring.strip_mm - 2.0
            stiffness = 70e3 * spring.strip_mm**4 / (8.0 * (spring.inside_mm + spring.strip_mm) ** 3 * coils)
        else:
            d, t, h = spring.outside_mm / spring.inside_mm, spring.strip_mm, spring.free_mm - spring.solid_mm
            k = ((d - 1) / d) ** 2 / ((d + 1) / (d - 1) - 2 / log(d)) / np.pi
            s = 0.75 * h
            bowed = (h / t - s / t) * (h / t - s / t / 2) + 1
            stiffness = 4 * 206e3 / 0.91 * t**3 / (k * spring.outside_mm**2) * bowed
        assert spring.stiffness_N_mm == pytest.approx(stiffness, rel=0.01), name
    # Forces of DIN 2093 at that way, N.
    forces = {"8x4.2x0.4": 210, "8x4.2x0.3": 119, "10x5.2x0.5": 329, "12.5x6.2x0.7": 673, "12.5x6.2x0.5": 291}
    for size, force in forces.items():
        disc = SpringSpec(name=size, **package_entries("springs")[f"disc-{size}"])
        assert disc.usable_N == pytest.approx(force, rel=0.025), size


def test_weak_loose_and_few_springs_are_told(sprung: SpurDrive) -> None:
    def found(drive: SpurDrive) -> dict[str, tuple[str, str]]:
        asked = [check for check in checks_of(drive) if check.id.startswith("spring")]
        return {r.id: (r.status, r.remedy) for r in run_all(asked, layout_of(drive))}

    def of(name: str) -> SpringSpec:
        return SpringSpec(name=name, **package_entries("springs")[name])

    assert not found(replace(sprung, spring=None))
    weak = found(replace(sprung, spring=of("coil-1.6x4.4")))
    assert weak["spring_flat"][0] == "fail" and "disc-8x4.2x0.4" in weak["spring_flat"][1], weak
    assert weak["spring_fits"][0] == "pass"
    loose = found(replace(sprung, spring=of("disc-12.5x6.2x0.5")))
    assert loose["spring_fits"] == ("fail", "choose drum.tensioner: M6, or leave it out"), loose
    short = found(sprung)
    assert short["spring_hold"][0] == "warn" and "drum.sector_half_angle_deg" in short["spring_hold"][1], short
    longer = replace(sprung, drum=replace(sprung.drum, sector_half_angle_deg=142.0))
    held = found(longer)
    assert held["spring_hold"][0] == "pass"
    assert "spring_hold" not in held["spring_keeps"][1] and "spring_hold then" in short["spring_keeps"][1]
    few = short["spring_keeps"]
    assert few[0] == "warn" and "spring_count to" in few[1], few
    wanted = int(few[1].split("spring_count to ")[1].split(";")[0])
    enough, more = (found(replace(sprung, drum=replace(sprung.drum, spring_count=wanted + n))) for n in (0, 2))
    assert enough["spring_keeps"][0] == "pass"
    assert found(replace(sprung, drum=replace(sprung.drum, spring_count=wanted - 1)))["spring_keeps"][0] == "warn"
    # One remedy does not undo the other.
    assert enough["spring_hold"][0] == "warn" and "spring_count" not in enough["spring_hold"][1], enough
    assert f"lower drum.spring_count, to no less than {wanted}" in more["spring_hold"][1], more


def test_a_remedy_names_a_softer_spring_and_a_terminal_with_a_spring_that_passes() -> None:
    def found(drive: SpurDrive, check: str) -> tuple[str, str, float]:
        (r,) = run_all([c for c in checks_of(drive) if c.id == check], layout_of(drive))
        return r.status, r.remedy, r.actual or 0.0

    text = TEXT.replace("6.0", "1.0")
    hard = load_text(text.format(rope="7x19-1.5", drum=DISCS)).drive
    assert isinstance(hard, SpurDrive)
    status, remedy, left = found(hard, "spring_keeps")
    assert (status, left) == ("warn", 0.0), (status, left, remedy)
    named, count = remedy.split("drum.spring: ")[1].split(";")[0].split(" with drum.spring_count: ")
    drum = f"spring: {named}, spring_count: {count}, tensioner: M4"
    soft = load_text(text.format(rope="7x19-1.5", drum=drum)).drive
    assert isinstance(soft, SpurDrive)
    assert found(soft, "spring_keeps")[0] == "pass", remedy
    status, remedy, _ = found(drive_of(rope="7x19-1.5, termination: ball"), "sleeve_fits")
    assert status == "fail" and "M5, with drum.spring: disc-10x5.2x0.4" in remedy, remedy


def test_the_rules_choose_a_terminal_that_leads_the_spring() -> None:
    drive = drive_of("spring: disc-8x4.2x0.4, spring_count: 4")
    assert drive.tensioner.name == "M4", drive.tensioner.name
    assert not [r for r in run_all(checks_of(drive), layout_of(drive)) if r.status == "fail"]


_KEPT = drive_of()
