"""Frames and input pulleys against solid finite elements of their STEP, routes that share only drawing and supports.

Needs gmsh and scikit-fem, as test_drum_solid.py; some ten seconds a part. Ten whole drives, part by part:
``python -m benchmarks.studies.random_structures``.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import structure_of

pytest.importorskip("gmsh", reason="solid elements: pip install --require-hashes -r tests/requirements-solids.lock")
pytest.importorskip("skfem", reason="solid elements: pip install --require-hashes -r tests/requirements-solids.lock")
PARAMS = Path(__file__).parents[2] / "params"
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
    from tests.support.shaft_solid import pulley_torsion_urad_Nm

    layout = _layout(name)
    found = next(c.urad_Nm for c in structure_of(layout).causes if c.name == "input pulleys, torsion")
    solid = pulley_torsion_urad_Nm(layout, tmp_path)
    assert found == pytest.approx(solid, rel=PULLEY), f"{found:.2f} by steps, {solid:.2f} urad per N m by solids"
