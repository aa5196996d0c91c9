"""The drum's own turn and stress: elements against beams, a full ring against its closed form, laws, and published FE.

Solid finite elements of the drawn STEP are compared in tests/acceptance/test_frame_stiffness.py.
"""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import pi

import numpy as np
import pytest
from numpy.typing import NDArray
from threadpoolctl import threadpool_info, threadpool_limits

from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, new_design_text
from mbcdm_cad.model import plate_mesh
from mbcdm_cad.model.plate_mesh import Plates, sides
from mbcdm_cad.model.structure import drum_sector, quadrilateral
from mbcdm_cad.model.structure.quadrilateral import (
    FREEDOMS,
    eccentric,
    elements,
    freedoms,
    plane_law,
    plate_elements,
    solve,
    solve_mesh,
)
from mbcdm_cad.model.structure.sector_mesh import RimStep, SectorShape
from mbcdm_cad.parts.drum_sector.dims import Window, hub, land_pulls, sector_shape
from mbcdm_cad.report.analysis_report import analyse_design
from tests.support.reference import PARAMS

METAL = drum_sector.Isotropic(71_700.0, 0.33)
HUB = drum_sector.Hub(10.0, 4.0, 0.0, 10.0, 5.0, 0.0, 0, 0.0, 0, 7.0, 0.0, (0.0, 2.0), 2.0, pi)


# The windows of the drum whose STEP two independent programs of finite elements measured: inner and outer radius, ends.
MEASURED_WINDOWS = tuple(
    Window(inner, outer, *sorted((side * start, side * end)))
    for side in (1.0, -1.0)
    for inner, outer, start, end in (
        (13.0, 32.06, 6.626, 28.306),
        (39.86, 44.5, 6.626, 28.385),
        (13.0, 44.5, 41.557, 62.674),
    )
)


def study(
    cells: float = 28.0, windows: tuple[Window, ...] | None = MEASURED_WINDOWS, material: drum_sector.Isotropic = METAL
) -> drum_sector.SectorStudy:
    """The drum of the reference design, each cable with a quarter of the torque; ``windows`` None: not even a slot."""
    drive = load_design(PARAMS / "mbcdm.yaml").drive
    # Hub and web of the measured drum; the reference's are wider and thicker since.
    drum = layout_of(drive).drum
    web = {"web_end_y": drum.web_start_y + 2.0, "root_end_y": drum.web_start_y + 2.0}
    dims = replace(drum, windows=windows or (), hub_radius=10.0, root_radius=10.0, **web)
    names = [cable.name for cable in drive.cables]
    pulls = land_pulls(dims, dict.fromkeys(names, 0.25), dict.fromkeys(names, 70.0))
    shape = sector_shape(dims)
    shape = replace(shape, openings=()) if windows is None else shape
    return drum_sector.sector_study(shape, hub(dims, 2.5), pulls, material, cells)


def test_a_mesh_is_solved_as_a_full_matrix_is() -> None:
    """A chain of elements of three freedoms, numbered row by row; one freedom is held."""
    rng = np.random.default_rng(1)
    where = np.arange(0, 40)[:, None] + np.arange(3)
    where = np.where(where == 17, -1, where - (where > 17))
    root = rng.normal(size=(40, 3, 3))
    stiffness, load, full = root @ root.transpose(0, 2, 1), rng.normal(size=(41, 2)), np.zeros((41, 41))
    for own, element in zip(where, stiffness, strict=True):
        free = own >= 0
        full[np.ix_(own[free], own[free])] += element[np.ix_(free, free)]
    assert solve_mesh(where, stiffness, load) == pytest.approx(np.linalg.solve(full, load), rel=1e-9)


def test_a_mesh_is_solved_by_bands_on_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """scipy has linear algebra of its own, loaded with the first mesh; two threads take five times as long."""
    seen: list[int] = []

    def threads(*_: object, **__: object) -> tuple[None, NDArray[np.float64], int]:
        seen.extend(one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas")
        return None, np.zeros((1, 1)), 0

    monkeypatch.setattr(quadrilateral, "dpbsv", threads)
    with threadpool_limits(2):
        solve_mesh(np.zeros((1, 1), dtype=int), np.ones((1, 1, 1)), np.zeros((1, 1)))
    assert set(seen) == {1}, seen


def test_a_mesh_that_nothing_holds_is_refused_by_bands() -> None:
    spring = np.array([[[1.0, -1.0], [-1.0, 1.0]]])
    with pytest.raises(np.linalg.LinAlgError):
        solve_mesh(np.array([[0, 1]]), spring, np.ones((2, 1)))


def test_a_cantilever_of_elements_bends_as_a_beam() -> None:
    """One element across the height, as across a spoke: deflection F l^3 / (3 E I) and shear 6 F l / (5 G A)."""
    length, height, thick, force, count = 40.0, 4.0, 2.0, 10.0, 20
    x = np.repeat(np.linspace(0.0, length, count + 1), 2)
    node = np.stack([x, np.tile([0.0, height], count + 1)], axis=1)
    low = 2 * np.arange(count)
    corner = np.stack([low, low + 2, low + 3, low + 1], axis=1)
    found = elements(node, corner, np.full(count, thick), METAL.modulus_MPa, METAL.poisson)
    stiffness = found.stiffness.copy()
    stiffness[0, [0, 1, 6, 7], [0, 1, 6, 7]] += 1e12
    load = np.zeros((2 * len(node), 1))
    load[[-3, -1], 0] = force / 2.0
    moved = float(solve(corner, stiffness, load)[-1, 0])
    inertia = thick * height**3 / 12.0
    beam = force * length**3 / (3.0 * METAL.modulus_MPa * inertia)
    beam += 1.2 * force * length / (METAL.shear_MPa * thick * height)
    assert moved == pytest.approx(beam, rel=0.01), f"{moved} mm, beam {beam} mm"


def test_a_full_ring_turns_as_its_closed_form() -> None:
    """A disc from a to b under the same shear all round: T / (4 pi G t) (1/a^2 - 1/b^2), the cables all round it."""
    a, b, thick = 10.0, 50.0, 2.0
    shape = SectorShape(pi - 1e-6, a, (RimStep(b, 0.0, thick),))
    pulls = tuple(drum_sector.LandPull(side, b, pi - 1e-3, 0.5, 0.0, 1.0) for side in (1, -1))
    found = drum_sector.sector_study(shape, HUB, pulls, METAL, 40.0)
    root, _ = HUB.root_mm2_N(METAL, (0.0, thick))
    ring = 1e9 / (4.0 * pi * METAL.shear_MPa * thick) * (1.0 / a**2 - 1.0 / b**2)
    ring += 1e9 * root / (2.0 * pi * a**3)
    # The change of tension is largest at the transfer and presses inwards there: a little more than pure shear.
    assert ring < found.web_urad_Nm < 1.6 * ring, f"{found.web_urad_Nm:.1f} urad/N m, ring {ring:.1f}"


@pytest.mark.parametrize(
    ("radius", "bore", "thick", "back"), [(15.0, 4.0, 2.0, 5.0), (11.5, 4.0, 4.8, 0.0), (15.75, 7.5, 8.0, 1.0)]
)
def test_a_web_all_round_turns_on_its_hub_as_a_body_of_revolution(
    radius: float, bore: float, thick: float, back: float
) -> None:
    """Torsion of the whole body by finite differences; the model: twist of its hub, its edge, shear of its web."""
    outer, face = 2.0 * radius, back + thick + 10.0
    exact, _ = revolved(radius, bore, outer, (0.0, back, back + thick, face), thick / 6.0)
    hub_ = replace(HUB, radius_mm=radius, bore_mm=bore, face_mm=face, set_mm=0.0)
    root, _ = hub_.root_mm2_N(METAL, (back, back + thick))
    start = back + thick * (0.5 + drum_sector.STIFFENED)
    found = hub_.twist_urad_Nm(METAL, start, face) + 1e9 * root / (2.0 * pi * radius**3)
    found += 1e9 / (4.0 * pi * METAL.shear_MPa * thick) * (1.0 / radius**2 - 1.0 / outer**2)
    assert found == pytest.approx(exact / METAL.shear_MPa * 1e9, rel=0.04), f"{found:.2f} urad/N m"


@pytest.mark.parametrize(("radius", "bore", "length"), [(40.0, 2.5, 7.0), (26.0, 2.5, 9.0)])
def test_a_wide_hub_passes_its_torque_on_under_its_outside(radius: float, bore: float, length: float) -> None:
    """The same body of revolution, sheared a web's thickness beside the web."""
    thick, torque = 2.0, 5.0
    face = thick / 2.0 + length
    _, shear = revolved(radius, bore, 1.2 * radius, (0.0, 0.0, thick, face), thick / 4.0)
    hub_ = replace(HUB, radius_mm=radius, bore_mm=bore, face_mm=face, edge_mm=(0.0, thick), web_mm=thick)
    found, exact = hub_.shear_MPa(torque) / drum_sector.UNEVEN, shear(2.0 * thick) * torque * 1e3
    assert found == pytest.approx(exact, rel=0.1), f"{found:.3f} MPa, rings {exact:.3f}"


def revolved(
    radius: float, bore: float, outer: float, heights: tuple[float, ...], cell: float
) -> tuple[float, Callable[[float], float]]:
    """Turn for a torque and a shear modulus of one, 1/mm^3, and by height the shear on the hub's outside: a hub from
    the first height to the last, which is held, with a web between the other two, whose outer edge carries the torque.
    Rings whose torques balance."""

    def lines(ends: tuple[float, ...]) -> np.ndarray:
        parts = [np.linspace(a, b, max(1, round((b - a) / cell)) + 1)[1:] for a, b in pairwise(ends) if b > a]
        return np.concatenate([ends[:1], *parts])

    r, y = lines((bore, radius, outer)), lines(heights)
    r_in, y_in = (r[1:] + r[:-1]) / 2.0, (y[1:] + y[:-1]) / 2.0
    web = (y_in > heights[1]) & (y_in < heights[2])
    metal = (r_in[:, None] < radius) | web
    number = np.where(metal, np.cumsum(metal).reshape(metal.shape) - 1, -1)
    out = 2.0 * np.pi * np.diff(y) / (0.5 * -np.diff(r_in**-2.0))[:, None]
    polar = np.pi / 2.0 * np.diff(r**4)
    along = polar[:, None] / np.diff(y_in)
    stiffness = np.zeros((metal.sum(), metal.sum()))
    for one, other, spring in ((number[:-1], number[1:], out), (number[:, :-1], number[:, 1:], along)):
        met = (one >= 0) & (other >= 0)
        i, j, k = one[met], other[met], spring[met]
        for row, column, sign in ((i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)):
            np.add.at(stiffness, (row, column), sign * k)
    held, load = number[:, -1], np.zeros(len(stiffness))
    stiffness[held[held >= 0], held[held >= 0]] += polar[held >= 0] / (np.diff(y)[-1] / 2.0)
    load[number[-1, web]] = np.diff(y)[web] / (heights[2] - heights[1])
    turned = np.linalg.solve(stiffness, load)
    outside = turned[number[np.flatnonzero(r_in < radius)[-1]]]
    slope, between = np.diff(outside) / np.diff(y_in), (y_in[1:] + y_in[:-1]) / 2.0
    return float(load @ turned), lambda y: radius * abs(float(np.interp(y, between, slope)))


@pytest.mark.parametrize(("bore", "torque", "shear"), [(4.0, 0.5, 190.0), (4.0, 8.0, 7.7), (15.0, 150.0, 20.0)])
def test_the_least_hub_has_the_shear_that_it_may_have(bore: float, torque: float, shear: float) -> None:
    radius = drum_sector.least_hub_mm(bore, torque, shear)
    found = replace(HUB, radius_mm=radius, bore_mm=bore).shear_MPa(torque)
    assert radius > bore and found == pytest.approx(shear, rel=1e-6), f"{radius} mm: {found} MPa"


@pytest.mark.parametrize(("thick", "height"), [(0.02, 0.0), (2.0, 0.0), (2.0, 7.0)])
def test_a_ring_bent_at_its_edge_leans_as_its_closed_form(thick: float, height: float) -> None:
    """Clamped at a, a moment m along b: the lean is m b (1 - a^2/b^2) / (D ((1 + nu) + (1 - nu) a^2/b^2)), the moment
    at a is 2 m over the same bracket (axisymmetric plates, Timoshenko and Woinowsky-Krieger, chapter 3). The same for
    a ring at a height above the plane of the freedoms, which follows it."""
    a, b, moment, around, rings = 10.0, 50.0, 3.0, 96, 40
    radius = np.repeat(np.linspace(a, b, rings + 1), around)
    angle = np.tile(np.arange(around) * 2.0 * pi / around, rings + 1)
    node = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(rings), np.arange(around), indexing="ij"))
    low, beside = i * around + j, i * around + (j + 1) % around
    corner = np.stack([low, low + around, beside + around, beside], axis=1)
    body = node, corner, np.full(len(corner), thick), METAL.modulus_MPa, METAL.poisson
    found, where = plate_elements(*body), freedoms(corner, FREEDOMS)
    whole = eccentric(elements(*body).stiffness, found.stiffness, np.full(len(corner), height))
    clamped, load = around * FREEDOMS, np.zeros((len(node), FREEDOMS))
    share = moment * 2.0 * pi * b / around
    edge = np.arange(rings * around, len(node))
    load[edge, 3], load[edge, 4] = share * np.cos(angle[edge]), share * np.sin(angle[edge])
    free = solve_mesh(np.maximum(where - clamped, -1), whole, load.reshape(-1, 1)[clamped:])[:, 0]
    moved = np.concatenate([np.zeros(clamped), free])
    plate = METAL.modulus_MPa * thick**3 / 12.0 / (1.0 - METAL.poisson**2)
    share_a = (a / b) ** 2
    bracket = (1.0 + METAL.poisson) + (1.0 - METAL.poisson) * share_a
    lean = moment * b * (1.0 - share_a) / (plate * bracket)
    leant = float(moved[FREEDOMS * edge[0] + 3])
    assert leant == pytest.approx(lean, rel=0.005), f"{leant} rad, {lean} rad"
    curved = found.curvature[0] @ moved[where[0, 8:]]
    at_a = (curved @ plane_law(METAL.modulus_MPa, METAL.poisson))[:, 0].mean() * thick**3 / 12.0
    first = a + (b - a) / rings / 2.0
    there = moment / bracket * ((1.0 + METAL.poisson) + (1.0 - METAL.poisson) * (a / first) ** 2)
    assert at_a == pytest.approx(there, rel=0.02), f"{at_a:.3f} N mm/mm beside the hub, {there:.3f}"


def test_cables_bend_the_web_by_how_far_they_lie_beside_its_middle() -> None:
    """Nothing in its middle; in front the opposite of behind, twice as far twice as much, and four times the turn."""
    shape = SectorShape(1.2, 10.0, (RimStep(40.0, 4.0, 6.0), RimStep(50.0, 2.0, 8.0)), rim_mm=40.0)

    def bent(at: float) -> drum_sector.SectorStudy:
        pulls = tuple(drum_sector.LandPull(side, 50.0, 1.0, 0.5, 70.0, at) for side in (1, -1))
        return drum_sector.sector_study(shape, HUB, pulls, METAL)

    behind, middle, front, further = (bent(at) for at in (3.0, 5.0, 7.0, 9.0))
    largest = np.abs(front.preload_bending).max()
    assert largest > 1.0, f"{largest:.2g} MPa"
    assert np.abs(middle.preload_bending).max() < 1e-9 * largest
    np.testing.assert_allclose(behind.preload_bending, -front.preload_bending, atol=1e-9 * largest)
    np.testing.assert_allclose(further.preload_bending, 2.0 * front.preload_bending, atol=1e-9 * largest)
    once, twice = (one.web_urad_Nm - middle.web_urad_Nm for one in (front, further))
    assert once > 0.1 and twice == pytest.approx(4.0 * once, rel=1e-6), f"{once:.3f} and {twice:.3f} urad/N m"


def test_windows_make_the_reference_soft_as_solid_elements_found() -> None:
    """Two independent programs: 621 (3D) and 665 (plane stress, sharp corners) urad/N m; without windows 33 to 47."""
    found = study()
    whole = found.web_urad_Nm + found.hub_to_screws_urad_Nm + found.hub_to_face_urad_Nm
    assert whole == pytest.approx(621.0, rel=0.10), f"{whole:.0f} urad/N m"
    full, slot = study(windows=None).web_urad_Nm, study(windows=()).web_urad_Nm
    assert 25.0 < full < slot < 70.0, f"{full:.0f} urad/N m without windows, {slot:.0f} with the stop's slot"


def test_a_drum_without_metal_under_a_cable_has_no_figure() -> None:
    """A file whose outer face lies below its lands: a trial of ``explain`` has such drums."""
    drum = layout_of(load_design(PARAMS / "mbcdm.yaml").drive).drum
    dims = replace(drum, lands=tuple(replace(land, y_end=land.y_start - 1.0) for land in drum.lands))
    names = [t.cable_name for t in dims.tensioners]
    pulls = land_pulls(dims, dict.fromkeys(names, 0.25), dict.fromkeys(names, 70.0))
    with pytest.raises(ValueError, match="drum: no metal under the cable on the land of radius"):
        drum_sector.sector_study(sector_shape(dims), hub(dims, 2.5), pulls, METAL, 14.0)


def test_a_finer_mesh_changes_little() -> None:
    coarse, fine = study().web_urad_Nm, study(56.0).web_urad_Nm
    assert fine == pytest.approx(coarse, rel=0.02), f"{coarse:.1f} and {fine:.1f} urad/N m"


def test_turn_is_inverse_to_the_modulus_and_stress_does_not_depend_on_it() -> None:
    stiff, soft = study(), study(material=drum_sector.Isotropic(METAL.modulus_MPa / 20.0, METAL.poisson))
    for name in ("web_urad_Nm", "hub_to_screws_urad_Nm", "hub_to_face_urad_Nm"):
        assert getattr(soft, name) == pytest.approx(20.0 * getattr(stiff, name), rel=1e-6), name
    np.testing.assert_allclose(soft.von_mises_MPa(2.0), stiff.von_mises_MPa(2.0), rtol=1e-5)


@pytest.mark.parametrize("layout", ["mbcdm", "siso_bevel", "siso_spur", "miso_spur"])
def test_analyse_says_what_the_drum_adds(layout: str) -> None:
    report = analyse_design(load_design(PARAMS / f"{layout}.yaml").drive)
    found = report.to_dict()["structure"]
    parts = {cause["name"]: cause["urad_Nm"] for cause in found["causes"] if cause["name"].startswith("drum:")}
    assert len(parts) == 3 and min(parts.values()) > 0.0, parts
    assert sum(parts.values()) < found["structure_at_payload_urad_Nm"], found
    for name, turn in parts.items():
        line = next(line for line in report.text().splitlines() if name in line)
        assert f" {turn:.1f} " in line, (name, turn, line)


def test_a_printed_drum_under_too_much_torque_is_above_its_yield_stress() -> None:
    text = new_design_text("weak", "siso_spur").replace("material: aluminium-7075", "material: pla", 1)
    drive = load_text(text).drive
    heavy = replace(drive, loads=replace(drive.loads, peak_torque_Nm=24.0))
    found = analyse_design(heavy).to_dict()["structure"]
    assert found["drum_peak_stress_MPa"] > found["drum_yield_MPa"], found
    assert "above the yield stress" in analyse_design(heavy).text()


MODULUS, POISSON = 70_000.0, 0.3


def strip(length: float, width: float, cells: int, thickness: float, normal: int) -> Plates:
    """A strip along x, ``normal`` to y (1) or z (2), one element wide."""
    across = 3 - normal
    node = np.zeros((2 * (cells + 1), 3))
    node[:, 0] = np.repeat(np.linspace(0.0, length, cells + 1), 2)
    node[1::2, across] = width
    first = 2 * np.arange(cells)
    # Cyclic axes: (z, x) for a normal along y, (x, y) for one along z.
    order = [0, 1, 3, 2] if normal == 1 else [0, 2, 3, 1]
    corner = first[:, None] + np.array(order)
    return Plates(node, corner, np.full(cells, normal), np.full(cells, thickness), np.zeros(cells, dtype=np.int64))


def tip_mm(plates: Plates, axis: int) -> float:
    """Deflection of the end by 1 N, the other end held."""
    node = plates.node_mm
    held = np.repeat(node[:, 0] < 1e-9, 6)
    load = np.zeros((len(node), 6))
    end = node[:, 0] > node[:, 0].max() - 1e-9
    load[end, axis] = 1.0 / end.sum()
    element = plate_mesh.stiffness(sides(plates), plates.thickness_mm, MODULUS, POISSON)
    found = plate_mesh.solve(plates, element, held, np.zeros(load.size), load.ravel()).reshape(-1, 6)
    return float(found[end, axis].mean())


@pytest.mark.parametrize("normal", [1, 2])
@pytest.mark.parametrize("thickness", [0.5, 3.0])
def test_strip_bends_as_a_beam_out_of_its_plane(normal: int, thickness: float) -> None:
    width, length = 4.0, 60.0
    beam = length**3 / (3 * MODULUS * width * thickness**3 / 12)
    found = tip_mm(strip(length, width, 12, thickness, normal), normal)
    assert found == pytest.approx(beam, rel=0.03), f"tip {found:.5g} mm/N, beam {beam:.5g}"


@pytest.mark.parametrize("normal", [1, 2])
def test_strip_bends_as_a_beam_in_its_plane(normal: int) -> None:
    width, length, thickness = 10.0, 60.0, 2.0
    shear = length / (5 / 6 * MODULUS / (2 * (1 + POISSON)) * width * thickness)
    beam = length**3 / (3 * MODULUS * thickness * width**3 / 12) + shear
    found = tip_mm(strip(length, width, 12, thickness, normal), 3 - normal)
    assert found == pytest.approx(beam, rel=0.03), f"tip {found:.5g} mm/N, beam with shear {beam:.5g}"


def test_element_has_the_six_motions_of_a_rigid_body_and_no_others() -> None:
    rng = np.random.default_rng(1)
    for k in plate_mesh.stiffness(rng.uniform(1, 9, (20, 2)), rng.uniform(0.5, 5, 20), MODULUS, POISSON):
        assert np.allclose(k, k.T, atol=1e-9 * k.max()), f"unsymmetric by {abs(k - k.T).max() / k.max():.2g}"
        values = np.linalg.eigvalsh(k) / k.max()
        assert abs(values[:6]).max() < 1e-12, f"rigid motions store {values[:6]}"
        assert values[6] > 1e-9, f"a seventh motion without energy: {values[:8]}"


def test_square_tube_twists_as_bredt_says() -> None:
    side, length, thickness, cells = 20.0, 120.0, 1.0, 16
    x = np.linspace(0.0, length, cells + 1)
    ring = np.array([(-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0)]) * side / 2
    node = np.array([(a, *p) for a in x for p in ring])
    corners, normals = [], []
    for here in 8 * np.arange(cells):
        there = here + 8
        for k in range(8):
            low, high = sorted((k, (k + 1) % 8), key=lambda p: ring[p].sum())
            if ring[low][1] == ring[high][1]:  # a side along y, its normal along z: (u, v) are (x, y)
                normals.append(2)
                corners.append((here + low, there + low, there + high, here + high))
            else:  # a side along z, its normal along y: (u, v) are (z, x)
                normals.append(1)
                corners.append((here + low, here + high, there + high, there + low))
    count = len(corners)
    plates = Plates(
        node, np.array(corners), np.array(normals), np.full(count, thickness), np.zeros(count, dtype=np.int64)
    )
    element = plate_mesh.stiffness(sides(plates), plates.thickness_mm, MODULUS, POISSON)
    held = np.repeat(node[:, 0] < 1e-9, 6)
    load = np.zeros((len(node), 6))
    end = np.flatnonzero(node[:, 0] > length - 1e-9)
    off = node[end, 1:]
    load[end, 1], load[end, 2] = -off[:, 1], off[:, 0]
    load /= (load[end, 2] * off[:, 0] - load[end, 1] * off[:, 1]).sum()
    found = plate_mesh.solve(plates, element, held, np.zeros(load.size), load.ravel()).reshape(-1, 6)
    turn = float((found[end, 2] * off[:, 0] - found[end, 1] * off[:, 1]).sum() / (off**2).sum())
    bredt = length * 4 * side / thickness / (4 * side**4 * MODULUS / (2 * (1 + POISSON)))
    assert turn == pytest.approx(bredt, rel=0.05), f"twist {turn:.4g} rad per N mm, Bredt {bredt:.4g}"


def test_springs_to_the_base_and_work_of_the_load_agree() -> None:
    plates = strip(40.0, 6.0, 5, 2.0, 2)
    element = plate_mesh.stiffness(sides(plates), plates.thickness_mm, MODULUS, POISSON)
    rng = np.random.default_rng(2)
    size = 6 * len(plates.node_mm)
    ground, load = np.full(size, 300.0), rng.normal(size=size)
    found = plate_mesh.solve(plates, element, np.zeros(size, dtype=bool), ground, load)
    local = found[plate_mesh.freedoms(plates)]
    stored = float(np.einsum("ni,nij,nj->", local, element, local) + ground @ found**2)
    assert stored == pytest.approx(float(load @ found), rel=1e-9), f"stored {stored:.9g}, work {load @ found:.9g}"
