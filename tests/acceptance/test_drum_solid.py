"""The drum's own turn against solid finite elements of its STEP, a second route that shares only the drawing.

Needs ``pip install gmsh scikit-fem`` in the environment; gmsh is under the GPL and so is no dependency. Takes about two
minutes a drum.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.model.structure.drum_sector import Isotropic, sector_study
from mbcdm_cad.parts.drum_sector.structure import hub, land_pulls, sector_shape

pytest.importorskip("gmsh", reason="the solid mesh needs gmsh: pip install gmsh scikit-fem")
pytest.importorskip("skfem", reason="the solid elements need scikit-fem: pip install gmsh scikit-fem")
PARAMS = Path(__file__).parents[2] / "params"


@pytest.mark.slow
@pytest.mark.parametrize("layout", ["mbcdm", "siso_bevel", "siso_spur"])
def test_plane_elements_agree_with_solid_ones(layout: str, tmp_path: Path) -> None:
    from tests.support.drum_solid import drum_by_solids

    drive = load_design(PARAMS / f"{layout}.yaml").drive
    dims, material = drive.layout.drum, drive.drum.material
    share = {cable.name: 1.0 / len(drive.cables) for cable in drive.cables}
    thread = drive.screw(dims.set_screw).thread_mm
    elastic = Isotropic(material.youngs_modulus_GPa * 1e3, material.poisson_ratio)
    plane = sector_study(sector_shape(dims), hub(dims, thread), land_pulls(dims, share, share), elastic)
    whole = plane.web_urad_Nm + plane.hub_to_screws_urad_Nm + plane.hub_to_face_urad_Nm
    solid = drum_by_solids(dims, material, thread, share, tmp_path).turn_urad_Nm
    assert whole == pytest.approx(solid, rel=0.10), f"plane {whole:.0f}, solid {solid:.0f} urad/N m"
