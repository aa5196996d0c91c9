"""The drum's own turn and its web's stress against solid finite elements of its STEP, which share only the drawing.

Needs gmsh and scikit-fem (tests/requirements-solids.lock, which CI installs); gmsh is under the GPL and so is no
dependency. Half a minute a drum; thirty random ones: ``python -m benchmarks.studies.random_drums --runs 30``.
"""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import pytest

from benchmarks.studies.random_drums import ALLOWED, ALLOWED_STRESS, by_both, drums
from mbcdm_cad.layouts.loader import load_design

pytest.importorskip("gmsh", reason="solid elements: pip install --require-hashes -r tests/requirements-solids.lock")
pytest.importorskip("skfem", reason="solid elements: pip install --require-hashes -r tests/requirements-solids.lock")
PARAMS = Path(__file__).parents[2] / "params"


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
