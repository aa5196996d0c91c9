"""The stored files of a part contain everything that a build needs of it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cadquery as cq
import pytest
from export_samples import STEEL

from mbcdm_cad.build.export.step import part_step
from mbcdm_cad.build.kernel import measure, shape_from_brep
from mbcdm_cad.build.makefiles import make_part_files
from mbcdm_cad.build.partfiles import PartFiles
from mbcdm_cad.errors import GeometryError
from mbcdm_cad.storage.cache import Cache

KEY = "5" * 64


def test_part_survives_the_cache(solids: dict[str, cq.Solid], tmp_path: Path) -> None:
    made = make_part_files("plate", solids["plate"], STEEL, 0.02)
    Cache(tmp_path).put(KEY, made.to_blobs())
    blobs = Cache(tmp_path).get(KEY)
    assert blobs is not None
    found = PartFiles.from_blobs("plate", blobs)
    assert (found.brep, found.step, found.stl, found.shape) == (made.brep, made.step, made.stl, made.shape)
    assert abs(found.mesh_volume_error) < 1e-3, f"mesh volume off by {found.mesh_volume_error:.1e}"
    solid = shape_from_brep(found.brep)
    assert measure(solid).volume_mm3 == pytest.approx(made.shape.volume_mm3, rel=1e-12)
    assert part_step("plate", solid, STEEL) == made.step


def test_stored_part_is_read_without_the_kernel(solids: dict[str, cq.Solid], tmp_path: Path) -> None:
    Cache(tmp_path).put(KEY, make_part_files("disc", solids["disc"], STEEL, 0.02).to_blobs())
    code = f"""
import sys
from pathlib import Path
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.build.export.glb import glb_bytes
from mbcdm_cad.build.mass import item_mass
from mbcdm_cad.build.partfiles import PartFiles
part = PartFiles.from_blobs("disc", Cache(Path({str(tmp_path)!r})).get({KEY!r}))
print(len(part.stl), round(part.shape.volume_mm3), [n for n in ("cadquery", "OCP", "vtkmodules") if n in sys.modules])
"""
    root = Path(__file__).parents[4]
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    size, volume, imported = done.stdout.split(maxsplit=2)
    assert int(size) > 84
    assert int(volume) == 51472  # pi 64^2 4
    assert imported == "[]\n"


def test_unsound_part_is_not_made() -> None:
    with pytest.raises(GeometryError, match="drum: a Compound of 2 solids"):
        make_part_files("drum", cq.Workplane().box(9, 1, 1).cut(cq.Workplane().box(3, 3, 3)).val(), STEEL, 0.02)
