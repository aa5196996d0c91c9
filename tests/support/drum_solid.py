"""A drum sector by solid finite elements: its turn under its cables, and the stress in web and hub away from notches.

Away from notches is what stress linearisation gives (ASME VIII-2, annex 5-A): over columns through the web with sides
of one web's thickness the stresses are a straight line across the thickness, so that a corner's peak, which only the
mesh limits, counts with the column's mean. The model's plane elements are averaged over the same columns.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi, radians
from pathlib import Path

import numpy as np

from mbcdm_cad.design.bought import Material
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.equilibrium import sum_per_input
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.parts.drum_sector.dims import SET_SCREW_ANGLES_DEG, DrumDims
from mbcdm_cad.parts.part import MadePart
from tests.support.frame_solid import resultant
from tests.support.solid_fe import Floats, Ints, Pull, Solid, drum_load, on_land, tetrahedra

# Longest tetrahedra, over the drum's radius.
SIZE = 1.0 / 24.0
# A column counts where at least this share of it is metal.
FILLED = 0.6
# Length along the land before an anchor, over which its pull is spread, mm.
ANCHORED_MM = 3.0


Weight = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Columns:
    """Columns through the web, from the hub to the rim, in polar coordinates.

    The last at the hub to either side are left out: the notch in which the web's straight edge meets the hub.
    """

    from_mm: float
    to_mm: float
    side_mm: float
    half_angle_rad: float

    def numbers(self, x: Floats, z: Floats) -> Ints:
        """The column that each place belongs to, -1 outside."""
        r, a = np.hypot(x, z), np.arctan2(x, z) + pi
        rows = max(1, round((self.to_mm - self.from_mm) / self.side_mm))
        row = np.floor((r - self.from_mm) / (self.to_mm - self.from_mm) * rows).astype(np.int64)
        middle = self.from_mm + (row + 0.5) * (self.to_mm - self.from_mm) / rows
        column = np.floor(a * middle / self.side_mm).astype(np.int64)
        notch = (row == 0) & ((self.half_angle_rad - np.abs(a - pi)) * middle < self.side_mm)
        inside = (row >= 0) & (row < rows) & ~notch
        return np.where(inside, row * 100_000 + column, -1)


def columns_of(d: DrumDims) -> Columns:
    """Those of a drum's web."""
    return Columns(d.hub_radius, d.rim_inner_radius, d.web_end_y - d.web_start_y, radians(d.half_angle_deg))


@dataclass(frozen=True)
class DrumBySolids:
    """Turn of the cables against the payload in urad per N m, the bore free to turn on the shaft; greatest equivalent
    stress at the given torque of either sense, with the preload: of the web's linearised stress, the web's anywhere, of
    the hub's outside by the torque alone, away from holes, web and face, MPa."""

    turn_urad_Nm: float
    web_MPa: float
    web_peak_MPa: float
    hub_MPa: float


def pulls(d: DrumDims, share: dict[str, float]) -> list[Pull]:
    """The cables on their lands."""
    found = []
    for t in d.tensioners:
        land = min(d.lands, key=lambda k, t=t: (abs(k.surface_radius_mm - t.radius_mm), abs(k.y_start - t.y_mm)))
        # Lands of one radius side by side are one face, whose facets may reach across both.
        face = [k for k in d.lands if abs(k.surface_radius_mm - land.surface_radius_mm) < 1e-6]
        ends = (min(k.y_start for k in face), max(k.y_end for k in face))
        found.append(Pull(t.side, land.surface_radius_mm, ends, t.y_mm, t.anchor_rad, share[t.cable_name]))
    return found


def von_mises_MPa(stress: Floats) -> Floats:
    """Equivalent stress of stresses (3, 3, ...)."""
    mean = (stress[0, 0] + stress[1, 1] + stress[2, 2]) / 3.0
    square = sum((stress[i, j] - (mean if i == j else 0.0)) ** 2 for i in range(3) for j in range(3))
    return np.asarray(np.sqrt(1.5 * square))


def linearised_MPa(stress: Floats, place: Floats, volume: Floats, number: Ints, height: Floats) -> tuple[Ints, Floats]:
    """Columns, and the larger equivalent stress (m,) at either end of each: stresses (3, 3, n) that are a straight line
    along ``height`` (n,), from -1 to 1, by least squares."""
    kept = number >= 0
    found, own = np.unique(number[kept], return_inverse=True)
    w, h, s = volume[kept], height[kept], stress[:, :, kept]

    def mean(values: Floats) -> Floats:
        return np.bincount(own, w * values, len(found)) / np.bincount(own, w, len(found))

    first, second = mean(h), mean(h**2)
    spread = np.maximum(second - first**2, 1e-6)
    ends = []
    for end in (-1.0, 1.0):
        at = np.zeros((3, 3, len(found)))
        for i in range(3):
            for j in range(3):
                level, slope = mean(s[i, j]), (mean(s[i, j] * h) - mean(s[i, j]) * first) / spread
                at[i, j] = level + slope * (end - first)
        ends.append(von_mises_MPa(at))
    return found, np.maximum(*ends)


def drum_by_solids(
    d: DrumDims,
    material: Material,
    set_screw_thread_mm: float,
    share: dict[str, float],
    tension_N: dict[str, float],
    torque_Nm: float,
    folder: Path,
) -> DrumBySolids:
    """Draw the drum, write it as STEP, mesh that and solve for 1 N m and for the preloads."""
    from mbcdm_cad.parts.drum_sector.part import DrumSector

    step = folder / "drum.step"
    DrumSector(d, set_screw_thread_mm).solid().exportStep(str(step))
    solid = Solid(
        tetrahedra(step, SIZE * d.lands[-1].surface_radius_mm),
        material.youngs_modulus_GPa * 1e3,
        material.poisson_ratio,
    )
    load = np.stack([drum_load(solid, pulls(d, share)), preload(solid, d, tension_N)], axis=1)
    radius = np.hypot(solid.place[0], solid.place[2])
    face = np.flatnonzero((np.abs(solid.place[1] - d.hub_face_y) < 1e-3) & (radius < d.hub_radius + 1e-3))
    bore = np.flatnonzero(np.abs(radius - d.bore_radius) < 0.02)
    moved = solid.moved(load, face, solid.guided(bore))
    unit, place, volume = solid.stress_MPa(moved[:, 0])
    rest, _, _ = solid.stress_MPa(moved[:, 1])
    web, low = _web(d, place), d.web_start_y
    number = np.where(web, columns_of(d).numbers(place[0], place[2]), -1)
    # In each column the metal reaches from the web's back to the height that it has there.
    thick = np.where(np.hypot(place[0], place[2]) < d.root_radius, d.root_end_y - low, d.web_end_y - low)
    height = 2.0 * (place[1] - low) / thick - 1.0
    full = _filled(number, volume, columns_of(d).side_mm ** 2 * (d.web_end_y - low))
    found = peak = 0.0
    for way in (torque_Nm, -torque_Nm):
        stress = rest + way * unit
        found = max(found, linearised_MPa(stress, place, volume, np.where(full, number, -1), height)[1].max())
        peak = max(peak, von_mises_MPa(stress)[web].max())
    return DrumBySolids(
        float(load[:, 0] @ moved[:, 0]) * 1e3, found, peak, torque_Nm * _hub_MPa(d, unit, place, set_screw_thread_mm)
    )


def _web(d: DrumDims, place: Floats) -> Floats:
    r = np.hypot(place[0], place[2])
    return np.asarray((r > d.hub_radius) & (r < d.rim_inner_radius) & (place[1] < max(d.root_end_y, d.web_end_y)))


def _filled(number: Ints, volume: Floats, whole_mm3: float) -> Floats:
    """Whether a place (n,) lies in a column that is filled."""
    _, own = np.unique(number, return_inverse=True)
    return np.asarray((np.bincount(own, volume) > FILLED * whole_mm3)[own] & (number >= 0))


def _hub_MPa(d: DrumDims, unit: Floats, place: Floats, thread_mm: float) -> float:
    """Greatest equivalent stress on the hub's outside for 1 N m, a hole's diameter from the holes' middles and a wall
    of the web from web and face; 0 where nothing is left."""
    r, a, y = np.hypot(place[0], place[2]), np.arctan2(place[0], place[2]), place[1]
    wall = d.web_end_y - d.web_start_y
    away = (r < d.hub_radius) & (r > d.hub_radius - 0.1 * (d.hub_radius - d.bore_radius))
    away &= (y > max(d.root_end_y, d.web_end_y) + wall) & (y < d.hub_face_y - wall)
    for deg in SET_SCREW_ANGLES_DEG:
        off = np.abs(np.angle(np.exp(1j * (a - np.radians(deg))))) * r
        away &= np.hypot(off, y - d.set_screw_y) > thread_mm
    for x, z in d.payload_places:
        away &= (np.hypot(place[0] - x, place[2] - z) > d.payload_hole) | (y < d.hub_face_y - d.payload_depth - wall)
    stress = von_mises_MPa(unit)[away]
    return float(stress.max()) if stress.size else 0.0


def preload(solid: Solid, d: DrumDims, tension_N: dict[str, float]) -> Floats:
    """Forces of the preloads: pressure along the lands, and the anchors' pull on the last of them."""
    load = np.zeros(solid.place.shape[1])
    for pull, t in zip(pulls(d, tension_N), d.tensioners, strict=True):
        tension, land, end = tension_N[t.cable_name], on_land(solid, pull), pull.wrap_rad
        # Ends of the land that a pocket cuts leave a little of the anchor's length out.
        last = end - ANCHORED_MM / pull.surface_mm
        inwards, back = (tension * length / land.area_mm2(start, end) for start, length in ((0.0, end), (last, 1.0)))
        wrapped, anchored = land.weight(0.0, end), land.weight(last, end)

        def pressed(
            p: Floats,
            side: int = pull.side,
            inwards: float = inwards,
            back: float = back,
            wrapped: Weight = wrapped,
            anchored: Weight = anchored,
        ) -> tuple[Floats, Floats, Floats]:
            r = np.hypot(p[0], p[2])
            out, along = -inwards * wrapped(p), -side * back * anchored(p)
            return out * p[0] / r + along * p[2] / r, 0.0 * r, out * p[2] / r - along * p[0] / r

        load += solid.traction(land.facets, pressed)
    return load


def columns_MPa(
    d: DrumDims, place_mm: Floats, area_mm2: Floats, thickness_mm: Floats, stresses: Sequence[Floats]
) -> float:
    """The model's stresses (n, 3) of a face at places (n, 2), averaged over the columns of :func:`linearised_MPa`; the
    greatest equivalent stress of any."""
    number = columns_of(d).numbers(place_mm[:, 0], place_mm[:, 1])
    volume = area_mm2 * thickness_mm
    full = _filled(number, volume, columns_of(d).side_mm ** 2 * (d.web_end_y - d.web_start_y))
    _, own = np.unique(number[full], return_inverse=True)
    whole = np.bincount(own, volume[full])
    greatest = 0.0
    for stress in stresses:
        sx, sz, txz = (np.bincount(own, volume[full] * stress[full, k]) / whole for k in range(3))
        greatest = max(greatest, float(np.sqrt(sx**2 - sx * sz + sz**2 + 3.0 * txz**2).max()))
    return greatest


# Longest tetrahedra, over the part's largest radius.
SHAFT_SIZE = 0.3
# Half the band of the lands that takes the torque, over their length.
BAND = 0.15


def solid_of(part: MadePart, material: Material, size_mm: float, folder: Path) -> Solid:
    """The part as drawn, meshed."""
    step = folder / "part.step"
    part.solid().exportStep(str(step))
    return Solid(tetrahedra(step, size_mm, 0.2), material.youngs_modulus_GPa * 1e3, material.poisson_ratio)


def pulley_torsion_urad_Nm(layout: SectorLayout, folder: Path) -> float:
    """Twist of the input pulleys from their collars' upper edge to the middle of their lands, seen by the payload."""
    unit = unit_tensions_N(layout.loads.si)
    torques = sum_per_input(layout.loads.si, unit, layout.loads.si.input_radius_m)
    bill, found = layout.bill(0.0), 0.0
    for pulley, torque in zip(layout.inputs, torques, strict=True):
        part = bill.parts[f"input_pulley_{pulley.name}"].part
        radius = max(pulley.lower_land_radius, pulley.upper_land_radius)
        solid = solid_of(part, layout.drive.pulley_material, SHAFT_SIZE * radius, folder)
        x, y, z = solid.place
        low, high = pulley.land_bottom_z, pulley.land_top_z
        middle, half = (low + high) / 2.0, BAND * (high - low)
        clamped = (z < layout.collar.top_z + 1e-6) & (np.hypot(x, y) > pulley.bore_radius + 1e-3)

        def on_land(p: Floats, low: float = low, high: float = high, least: float = pulley.lower_neck_radius) -> Floats:
            return (p[2] > low - 1e-6) & (p[2] < high + 1e-6) & (np.hypot(p[0], p[1]) > least)

        def round_it(p: Floats, middle: float = middle, half: float = half) -> tuple[Floats, ...]:
            inside = np.abs(p[2] - middle) < half
            return -p[1] * inside, p[0] * inside, 0.0 * inside

        load = solid.traction(solid.facets(on_land), round_it)
        load *= 1e3 * abs(torque) / resultant(solid, load, np.zeros(3))[5]
        found += float(load @ solid.moved(load, np.flatnonzero(clamped))) * 1e3
    return found
