"""Shapes of a drum's web compared by mass, turn and stress, with the plane elements of the model.

    python -m benchmarks.studies.drum_shapes params/mbcdm.yaml

Each shape is the drum of the design with another web; its mass is that of the drum with the web's volume exchanged.
"Cost" counts the settings and cutters that the web needs: 1 turned, 2 with milled windows, 3 with small corners too.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from math import degrees, pi, radians

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import elastic
from mbcdm_cad.model.structure.drum_sector import sector_study
from mbcdm_cad.model.structure.sector_mesh import Opening, RimStep, SectorShape
from mbcdm_cad.parts.drum_sector.dims import hub, land_pulls, sector_shape
from mbcdm_cad.parts.drum_sector.part import DrumSector

# Spokes between hub and slot, in degrees, and slices of which a triangle is made.
SPOKE_DEG, SLICES = 8.0, 6


def shapes(s: SectorLayout) -> Iterator[tuple[str, int, SectorShape]]:
    """Name, cost and shape."""
    drawn, d = sector_shape(s.drum), s.drum
    slot = drawn.openings[-1]
    plain = replace(drawn, rings=drawn.rings[1:] if d.root_mm > 0.0 else drawn.rings)
    full = replace(plain, openings=(slot,))
    inner, outer, half = d.hub_radius + 3.0, slot.inner_mm - 1.5, radians(min(d.half_angle_deg, 85.0))
    yield "full web", 1, full
    yield "two windows outside the slot", 2, plain
    yield "the same, web twice as thick round the hub (drawn)", 2, drawn
    yield "full web, twice as thick round the hub", 1, replace(drawn, openings=(slot,))
    thick = replace(full.rings[0], end_mm=full.rings[0].end_mm + 0.5)
    yield "full web, 0.5 mm thicker", 1, replace(full, rings=(thick, *full.rings[1:]))
    rim = full.rings[0].outer_mm
    box = (replace(full.rings[0], outer_mm=rim - 4.0), RimStep(rim, full.rings[0].start_mm, full.rings[-1].end_mm))
    yield "full web, rim 4 mm higher (box)", 1, replace(full, rings=(*box, *full.rings[1:]))
    spokes = [-half + k * 2.0 * half / 6.0 for k in range(7)]
    gap = radians(SPOKE_DEG) / 2.0
    between = tuple(Opening(inner, outer, a + gap, b - gap, 1.0) for a, b in pairwise(spokes))
    yield "windows between hub and slot, straight spokes", 2, replace(plain, openings=(*between, *plain.openings))
    yield "the same, spokes that are triangles", 3, replace(plain, openings=(*_triangles(inner, outer, spokes), slot))


def _triangles(inner: float, outer: float, spokes: list[float]) -> Iterator[Opening]:
    """Windows that narrow outwards and inwards in turn, of slices."""
    step, gap = (outer - inner) / SLICES, radians(SPOKE_DEG) / 2.0
    for n, (a, b) in enumerate(pairwise(spokes)):
        for k in range(SLICES):
            share = (k + 0.5) / SLICES
            wide = ((b - a) / 2.0 - gap) * (1.0 - share if n % 2 else share)
            middle = (a + b) / 2.0
            if degrees(wide) > 1.0:
                yield Opening(inner + k * step, inner + (k + 1) * step, middle - wide, middle + wide, 0.0)


def _web_mm3(shape: SectorShape, hub_mm: float, to_mm: float) -> float:
    """Volume of the rings inside a radius, without the openings."""
    found, low = 0.0, hub_mm
    for ring in shape.rings:
        high = min(ring.outer_mm, to_mm)
        if high > low:
            found += shape.half_angle_rad * (high**2 - low**2) * (ring.end_mm - ring.start_mm)
            low = high
    web = next(ring for ring in shape.rings if ring.outer_mm > shape.openings[-1].inner_mm)
    holes = sum((o.outer_mm**2 - o.inner_mm**2) / 2.0 * (o.end_rad - o.start_rad) for o in shape.openings)
    holes -= sum((4.0 - pi) * o.corner_mm**2 for o in shape.openings)
    return found - holes * (web.end_mm - web.start_mm)


def main(path: str) -> None:
    """Print the table."""
    layout = layout_of(load_design(path).drive)
    assert isinstance(layout, SectorLayout)
    drive, d = layout.drive, layout.drum
    names = [t.cable_name for t in d.tensioners]
    share = {name: 1.0 / len(names) for name in names}
    pulls = land_pulls(d, share, {c.name: c.preload_N for c in drive.cables})
    thread, peak = drive.screw(d.set_screw).thread_mm, drive.loads.peak_torque_Nm
    density = drive.drum_material.density_g_cm3 * 1e-3
    drawn_g = DrumSector(d, thread).volume_mm3() * density
    to = d.rim_inner_radius
    drawn_web = _web_mm3(sector_shape(d), d.hub_radius, to)
    print("| web | mass, g | turn, urad/N m | stress at the peak torque, MPa | mass x turn | cost |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, cost, shape in shapes(layout):
        study = sector_study(shape, hub(d, thread), pulls, elastic(drive.drum_material))
        turn = study.web_urad_Nm + study.hub_to_screws_urad_Nm + study.hub_to_face_urad_Nm
        mass = drawn_g + (_web_mm3(shape, d.hub_radius, to) - drawn_web) * density
        stress = max(float(study.von_mises_MPa(way * peak).max()) for way in (1.0, -1.0))
        print(f"| {name} | {mass:.1f} | {turn:.1f} | {stress:.0f} | {mass * turn:.0f} | {cost} |")


if __name__ == "__main__":
    main(sys.argv[1])
