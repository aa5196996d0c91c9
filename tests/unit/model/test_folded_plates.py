"""Folded plates compared with beams and tubes with known solutions."""

from __future__ import annotations

import numpy as np
import pytest

from mbcdm_cad.model.plate_mesh import Plates, freedoms, sides, solve, stiffness

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
    element = stiffness(sides(plates), plates.thickness_mm, MODULUS, POISSON)
    found = solve(plates, element, held, np.zeros(load.size), load.ravel()).reshape(-1, 6)
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
    for k in stiffness(rng.uniform(1, 9, (20, 2)), rng.uniform(0.5, 5, 20), MODULUS, POISSON):
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
    element = stiffness(sides(plates), plates.thickness_mm, MODULUS, POISSON)
    held = np.repeat(node[:, 0] < 1e-9, 6)
    load = np.zeros((len(node), 6))
    end = np.flatnonzero(node[:, 0] > length - 1e-9)
    off = node[end, 1:]
    load[end, 1], load[end, 2] = -off[:, 1], off[:, 0]
    load /= (load[end, 2] * off[:, 0] - load[end, 1] * off[:, 1]).sum()
    found = solve(plates, element, held, np.zeros(load.size), load.ravel()).reshape(-1, 6)
    turn = float((found[end, 2] * off[:, 0] - found[end, 1] * off[:, 1]).sum() / (off**2).sum())
    bredt = length * 4 * side / thickness / (4 * side**4 * MODULUS / (2 * (1 + POISSON)))
    assert turn == pytest.approx(bredt, rel=0.05), f"twist {turn:.4g} rad per N mm, Bredt {bredt:.4g}"


def test_springs_to_the_base_and_work_of_the_load_agree() -> None:
    plates = strip(40.0, 6.0, 5, 2.0, 2)
    element = stiffness(sides(plates), plates.thickness_mm, MODULUS, POISSON)
    rng = np.random.default_rng(2)
    size = 6 * len(plates.node_mm)
    ground, load = np.full(size, 300.0), rng.normal(size=size)
    found = solve(plates, element, np.zeros(size, dtype=bool), ground, load)
    local = found[freedoms(plates)]
    stored = float(np.einsum("ni,nij,nj->", local, element, local) + ground @ found**2)
    assert stored == pytest.approx(float(load @ found), rel=1e-9), f"stored {stored:.9g}, work {load @ found:.9g}"
