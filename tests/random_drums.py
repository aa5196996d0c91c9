"""The turn of random drums by the model's plane elements and by solid elements of their STEP.

    python tests/random_drums.py --count 30

Drums are those of random short files that pass every check, the four layouts in turn, milled and printed. Needs gmsh
and scikit-fem (tests/requirements-solids.lock); half a minute a drum. Exit 1 if a drum differs by more than 10 %.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, islice
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests and their support, however this file is run
sys.path.insert(0, str(Path(__file__).parent))

from random_generator import LAYOUTS, Passing, Space, passing

from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.structure.drum_sector import Isotropic, sector_study
from mbcdm_cad.parts.drum_sector.structure import hub, land_pulls, sector_shape

ALLOWED = 0.10


@dataclass(frozen=True)
class DrumByBoth:
    """The turn of one drum, web with rim and hub, by both routes, urad per N m."""

    name: str
    material: str
    plane_urad_Nm: float
    solid_urad_Nm: float

    @property
    def off(self) -> float:
        """Plane over solid, less one."""
        return self.plane_urad_Nm / self.solid_urad_Nm - 1.0

    def __str__(self) -> str:
        return (
            f"{self.name:24} {self.material:14} plane {self.plane_urad_Nm:9.1f}  solid {self.solid_urad_Nm:9.1f} "
            f"urad/N m  {self.off:+.1%}"
        )


def by_both(loaded: LoadedDesign) -> DrumByBoth:
    """Both routes for the drum of one design; they share its dimensions alone."""
    from tests.support.drum_solid import drum_by_solids

    drive, layout = loaded.drive, loaded.drive.layout
    assert isinstance(layout, SectorLayout)
    dims, material = layout.drum, drive.drum_material
    names = [t.cable_name for t in dims.tensioners]
    share = {name: 1.0 / len(names) for name in names}
    thread = drive.screw(dims.set_screw).thread_mm
    elastic = Isotropic(material.youngs_modulus_GPa * 1e3, material.poisson_ratio)
    plane = sector_study(sector_shape(dims), hub(dims, thread), land_pulls(dims, share, share), elastic)
    whole = plane.web_urad_Nm + plane.hub_to_screws_urad_Nm + plane.hub_to_face_urad_Nm
    with TemporaryDirectory() as folder:
        solid = drum_by_solids(dims, material, thread, share, Path(folder)).turn_urad_Nm
    return DrumByBoth(f"{drive.configuration} {drive.name}", material.name, whole, solid)


def drums(first_seed: int = 1) -> Iterator[LoadedDesign]:
    """Designs that pass, one of each layout in turn."""
    each = [_passing(space, first_seed) for space in LAYOUTS.values()]
    while True:
        yield from (next(designs) for designs in each)


def _passing(space: Space, first_seed: int) -> Iterator[LoadedDesign]:
    found = (passing(seed, space) for seed in count(first_seed))
    return (p.loaded for p in found if isinstance(p, Passing))


def main() -> int:
    """Print every drum, and the largest difference."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=30)
    parser.add_argument("--first-seed", type=int, default=1)
    given = parser.parse_args()
    found = []
    for loaded in islice(drums(given.first_seed), given.count):
        found.append(by_both(loaded))
        print(found[-1], flush=True)
    worst = max(found, key=lambda drum: abs(drum.off))
    print(f"{len(found)} drums; largest difference {worst.off:+.1%}, {worst.name}; allowed {ALLOWED:.0%}")
    return int(abs(worst.off) > ALLOWED)


if __name__ == "__main__":
    sys.exit(main())
