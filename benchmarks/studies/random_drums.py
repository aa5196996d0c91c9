"""The turn and the stress of random drums by the model's plane elements and by solid elements of their STEP.

    python -m benchmarks.studies.random_drums --runs 30 --rows out/drums.jsonl

Drums are those of random short files that pass every check, the four layouts in turn, milled and printed. Needs gmsh
and scikit-fem (tests/requirements-solids.lock); half a minute a drum. A turn may differ by 10 %, a stress
away from notches (tests/support/drum_solid.py) by 25 %.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import count, islice
from math import sqrt
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.study import Row, Study, parser
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import elastic
from mbcdm_cad.model.structure.drum_sector import sector_study
from mbcdm_cad.model.structure.quadrilateral import AT_GAUSS, GAUSS, jacobian
from mbcdm_cad.model.structure.sector_mesh import SectorMesh
from mbcdm_cad.parts.drum_sector.dims import hub, land_pulls, sector_shape
from mbcdm_cad.routes import Floats
from tests.support.random_generator import LAYOUTS, Passing, Space, load, passing

ALLOWED, ALLOWED_STRESS = 0.10, 0.25


@dataclass(frozen=True)
class DrumByBoth:
    """One drum by both routes: its turn, web with rim and hub, in urad per N m; stresses at the peak torque of either
    sense, with the preload, MPa: greatest on either face of the web, averaged over columns of one thickness, and of the
    hub by the torque (0 where holes leave no place); greatest of the web and rim anywhere by the plane elements, of the
    web by the solid ones."""

    name: str
    material: str
    plane_urad_Nm: float
    solid_urad_Nm: float
    web_plane_MPa: float
    web_solid_MPa: float
    hub_model_MPa: float
    hub_solid_MPa: float
    peak_plane_MPa: float
    peak_solid_MPa: float

    @property
    def off(self) -> float:
        """Turn by plane elements over that by solid ones, less one."""
        return self.plane_urad_Nm / self.solid_urad_Nm - 1.0

    @property
    def web_off(self) -> float:
        """The same of the web's stress."""
        return self.web_plane_MPa / self.web_solid_MPa - 1.0

    @property
    def hub_off(self) -> float:
        """The same of the hub's stress."""
        return self.hub_model_MPa / self.hub_solid_MPa - 1.0 if self.hub_solid_MPa > 0.0 else 0.0

    def __str__(self) -> str:
        return (
            f"{self.name:24} {self.material:14} turn {self.plane_urad_Nm:8.1f} {self.solid_urad_Nm:8.1f} urad/N m "
            f"{self.off:+7.1%}  web {self.web_plane_MPa:7.2f} {self.web_solid_MPa:7.2f} MPa {self.web_off:+7.1%}  "
            f"hub {self.hub_model_MPa:6.2f} {self.hub_solid_MPa:6.2f} {self.hub_off:+7.1%}  "
            f"anywhere {self.peak_plane_MPa:7.2f} {self.peak_solid_MPa:7.2f}"
        )


def by_both(loaded: LoadedDesign) -> DrumByBoth:
    """Both routes for the drum of one design; they share its dimensions alone."""
    from tests.support.drum_solid import columns_MPa, drum_by_solids

    drive, layout = loaded.drive, layout_of(loaded.drive)
    assert isinstance(layout, SectorLayout)
    dims, material, torque = layout.drum, drive.drum_material, drive.loads.peak_torque_Nm
    names = [t.cable_name for t in dims.tensioners]
    share = {name: 1.0 / len(names) for name in names}
    preload = {c.name: c.preload_N for c in drive.cables}
    thread = drive.screw(dims.set_screw).thread_mm
    shape, tube = sector_shape(dims), hub(dims, thread)
    plane = sector_study(shape, tube, land_pulls(dims, share, preload), elastic(material))
    whole = plane.web_urad_Nm + plane.hub_to_screws_urad_Nm + plane.hub_to_face_urad_Nm
    place, area = _points(plane.mesh)
    thick = np.repeat(plane.mesh.thickness_mm, 4)
    faces = [face.reshape(-1, 3) for way in (1.0, -1.0) for face in plane.faces_MPa(way * torque)]
    web = columns_MPa(dims, place, area, thick, faces)
    with TemporaryDirectory() as folder:
        solid = drum_by_solids(dims, material, thread, share, preload, torque, Path(folder))
    return DrumByBoth(
        f"{drive.configuration} {drive.name}",
        material.name,
        whole,
        solid.turn_urad_Nm,
        web,
        solid.web_MPa,
        sqrt(3.0) * tube.shear_MPa(torque),
        solid.hub_MPa,
        max(float(plane.von_mises_MPa(way * torque).max()) for way in (1.0, -1.0)),
        solid.web_peak_MPa,
    )


def _points(mesh: SectorMesh) -> tuple[Floats, Floats]:
    """Places (4 n, 2) of the stresses of the plane elements, and the areas (4 n,) that they stand for."""
    at = jacobian(mesh.node_mm[mesh.corner], GAUSS)
    return (AT_GAUSS @ mesh.node_mm[mesh.corner]).reshape(-1, 2), at.det.ravel()


def drums(first_seed: int = 1) -> Iterator[LoadedDesign]:
    """Designs that pass, one of each layout in turn."""
    each = [_passing(space, first_seed) for space in LAYOUTS.values()]
    while True:
        yield from (next(designs) for designs in each)


def _passing(space: Space, first_seed: int) -> Iterator[LoadedDesign]:
    """As strength asks for: with a stiffness that any drive has, hub and web are not made stiffer."""
    for found in (passing(seed, space) for seed in count(first_seed)):
        if isinstance(found, Passing):
            yield load(found.data | {"loads": found.data["loads"] | {"stiffness_Nm_rad": 1.0}})


def table(rows: list[Row]) -> str:
    """Every drum, and the largest differences."""
    found = [DrumByBoth(**{key: value for key, value in row.items() if key != "task"}) for row in rows]
    lines = [str(drum) for drum in found]
    for what, allowed in (("turn", ALLOWED), ("web's stress", ALLOWED_STRESS), ("hub's stress", ALLOWED_STRESS)):
        off = max((OFF[what](drum) for drum in found), key=abs)
        lines.append(f"{what}: largest difference of {len(found)} drums {off:+.1%}, allowed {allowed:.0%}")
    return "\n".join(lines)


OFF = {"turn": lambda d: d.off, "web's stress": lambda d: d.web_off, "hub's stress": lambda d: d.hub_off}


def main() -> None:
    """Parse and do."""
    given = parser(__doc__, runs=30).parse_args()
    designs = {
        f"{one.drive.configuration} {one.drive.name}": one for one in islice(drums(given.first_seed), given.runs)
    }
    Study(lambda task: asdict(by_both(designs[task[0]])), table).run([(name,) for name in designs], given)


if __name__ == "__main__":
    main()
