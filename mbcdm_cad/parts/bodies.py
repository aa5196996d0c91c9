"""Bought parts as simplified solids: outside, mounting face, bores and holes are true to the catalogue.

Their masses come from the catalogue's ``entry``, not from the solids. Each is drawn along +Z from its mounting face or
seat at z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin

from mbcdm_cad.design.bought import Bearing, Encoder, Gearhead, InsertSpec, Motor, Screw, Servo
from mbcdm_cad.parts.milled import PlainRing, block, cut, cylinder_z, fuse, hexagon_z, one_solid, turned
from mbcdm_cad.parts.part import BoughtPart, Part, Ring, cq
from mbcdm_cad.parts.turned import PreloadSpringDims
from mbcdm_cad.routes.curves import Piece

# Width across the ring encoder's two flats over its diameter.
RING_ENCODER_FLATS = 22.0 / 24.0
# Screws of a flange begin at this angle from X. Y points to the front of the frame, where its shelves end: two screws
# lie along X, of three one is at the back, four lie on the diagonals.
_FIRST_SCREW_DEG = {2: 0.0, 3: -90.0, 4: 45.0}


def first_screw_rad(count: int) -> float:
    """Angle of a flange's first screw from X, seen along -Z."""
    return _FIRST_SCREW_DEG.get(count, 0.0) * pi / 180.0


def screw_places(count: int, radius_mm: float, turn_deg: float = 0.0) -> tuple[tuple[float, float], ...]:
    """(x, y) of the screws of a flange from its axis, mm, sorted; ``turn_deg``: how far it is turned from X to Y."""
    angles = [first_screw_rad(count) + turn_deg * pi / 180.0 + 2 * pi * k / count for k in range(count)]
    # Rounded to a picometre, so that a point on an axis has a coordinate of exactly 0.
    return tuple(sorted((round(radius_mm * cos(a), 9) + 0.0, round(radius_mm * sin(a), 9) + 0.0) for a in angles))


_EDGE = 0.3


def _circle(count: int, radius: float, first_rad: float = 0.0) -> list[tuple[float, float]]:
    angles = [first_rad + 2 * pi * k / count for k in range(count)]
    return [(radius * cos(a), radius * sin(a)) for a in angles]


def _with_face(
    gearhead: Gearhead, screw: Screw, hole_depth: float, back: list[tuple[float, float]], name: str
) -> cq.Solid:
    """A turned body whose outline begins at its ``back``, with the face, pilot, shaft and threads of ``gearhead``."""
    r = gearhead.diameter_mm / 2
    body = turned(
        [
            *back,
            (r, -_EDGE),
            (r - _EDGE, 0.0),
            (gearhead.pilot_diameter_mm / 2, 0.0),
            (gearhead.pilot_diameter_mm / 2, gearhead.pilot_height_mm),
            (gearhead.shaft_diameter_mm / 2, gearhead.pilot_height_mm),
            (gearhead.shaft_diameter_mm / 2, gearhead.shaft_length_mm),
            (0.0, gearhead.shaft_length_mm),
        ],
        name,
    )
    holes = [
        cylinder_z(screw.thread_mm / 2, x, y, -hole_depth, 1.0)
        for x, y in _circle(gearhead.screw_count, gearhead.bolt_circle_mm / 2, first_screw_rad(gearhead.screw_count))
    ]
    return cut(body, holes, name)


@dataclass(frozen=True)
class BearingBody(BoughtPart):
    """Bearing from z = 0, both rings in one body."""

    entry: Bearing

    def in_rings(self) -> tuple[Ring, ...]:
        """Both rings and what is between them."""
        b = self.entry
        shield, back = (b.inner_shoulder_mm / 2, b.outer_shoulder_mm / 2), min(0.2, b.width_mm / 8)
        whole = (b.outer_diameter_mm / 2, b.bore_mm / 2, 0.0, b.width_mm)
        return (whole, (*shield, 0.0, back), (*shield, b.width_mm - back, b.width_mm))

    def solid(self) -> cq.Solid:
        """Both rings in one body, the shield set back between them."""
        bearing = self.entry
        d, outer, width = bearing.bore_mm / 2, bearing.outer_diameter_mm / 2, bearing.width_mm
        inner_ring, outer_ring = bearing.inner_shoulder_mm / 2, bearing.outer_shoulder_mm / 2
        back = min(0.2, width / 8)
        return turned(
            [
                (d, 0.0),
                (inner_ring, 0.0),
                (inner_ring, back),
                (outer_ring, back),
                (outer_ring, 0.0),
                (outer, 0.0),
                (outer, width),
                (outer_ring, width),
                (outer_ring, width - back),
                (inner_ring, width - back),
                (inner_ring, width),
                (d, width),
            ],
            f"bearing {bearing.name}",
        )


@dataclass(frozen=True)
class InsertBody(BoughtPart):
    """Heat-set insert below z = 0."""

    entry: InsertSpec

    def solid(self) -> cq.Solid:
        """Insert from z = -length to 0 after setting: as wide as its hole, thread as a plain bore at its diameter."""
        insert = self.entry
        thread, hole, length = insert.thread_mm / 2, insert.hole_mm / 2, insert.length_mm
        return turned([(thread, -length), (hole, -length), (hole, 0.0), (thread, 0.0)], f"insert {insert.name}")


@dataclass(frozen=True)
class MotorBody(PlainRing, BoughtPart):
    """Motor below the gearhead's back at z = 0."""

    what, chamfers_mm = "motor", (_EDGE, 0.0)

    entry: Motor

    def ring(self) -> Ring:
        """Its can, from the gearhead's back (z = 0) downwards."""
        return (self.entry.diameter_mm / 2, 0.0, -self.entry.length_mm, 0.0)


@dataclass(frozen=True)
class MotorWithShaft(BoughtPart):
    """Motor without a gearhead, below its face at z = 0; depth of its tapped holes in mm."""

    entry: Motor
    face: Gearhead
    screw: Screw
    hole_depth: float

    def solid(self) -> cq.Solid:
        """Motor without a gearhead, below its face at z = 0, pilot and shaft above it, tapped holes for its screws."""
        motor, face, screw, hole_depth = self.entry, self.face, self.screw, self.hole_depth
        r, length = motor.diameter_mm / 2, motor.length_mm
        return _with_face(face, screw, hole_depth, [(0.0, -length), (r - _EDGE, -length), (r, _EDGE - length)], "motor")


@dataclass(frozen=True)
class ServoBody(BoughtPart):
    """Servo with its ears' front at z = 0 and its horn's axis along Z; its longer end is at +X."""

    entry: Motor
    servo: Servo
    hole: float  # radius of the ears' holes
    centre: Screw

    def solid(self) -> cq.Solid:
        """Housing with ears and their holes, and the spline up to the back of the horn with the thread of its screw."""
        s = self.servo
        middle, half, wide = s.axis_mm, s.body_mm / 2, s.width_mm / 2
        bodies: list[cq.Shape] = [
            block((middle - half, middle + half), (-wide, wide), (-s.behind_mm, s.before_mm)),
            block((middle - s.ears_mm / 2, middle + s.ears_mm / 2), (-wide, wide), (-s.ear_mm, 0.0)),
            cylinder_z(s.horn_mm / 4, 0, 0, s.before_mm - 0.5, s.horn_face_mm - s.horn_thickness_mm),
        ]
        holes = [
            cylinder_z(self.hole, middle + x * s.hole_length_mm / 2, y * s.hole_width_mm / 2, -s.ear_mm - 1.0, 1.0)
            for x in (-1, 1)
            for y in (-1, 1)
        ]
        thread = self.centre.thread_mm / 2
        holes.append(cylinder_z(thread, 0, 0, s.horn_face_mm - self.centre.length_mm - 0.5, s.horn_face_mm))
        return cut(fuse(bodies, "servo"), holes, "servo")


@dataclass(frozen=True)
class HornBody(BoughtPart):
    """Horn of a servo, a disc whose front is at the height of the servo's horn; its mass is part of the servo's."""

    entry: Motor
    servo: Servo
    thread: float  # radius of its threads
    centre: Screw

    def solid(self) -> cq.Solid:
        """Disc with its threads and the hole of its own screw, on the servo's axis."""
        s = self.servo
        low, high = s.horn_face_mm - s.horn_thickness_mm, s.horn_face_mm
        places = [(self.thread, x, y) for x, y in screw_places(s.horn_screws, s.horn_circle_mm / 2)]
        holes = [cylinder_z(r, x, y, low - 1.0, high + 1.0) for r, x, y in (*places, (self.centre.thread_mm / 2, 0, 0))]
        return cut(cylinder_z(s.horn_mm / 2, 0, 0, low, high), holes, "horn")


@dataclass(frozen=True)
class GearheadBody(BoughtPart):
    """Gearhead below its face at z = 0; depth of its tapped holes in mm."""

    entry: Gearhead
    screw: Screw
    hole_depth: float

    def solid(self) -> cq.Solid:
        """Gearhead below its face at z = 0, pilot and shaft above it, tapped holes for its screws."""
        gearhead, screw, hole_depth = self.entry, self.screw, self.hole_depth
        r = gearhead.diameter_mm / 2
        back = [(0.0, -gearhead.length_mm), (r, -gearhead.length_mm)]
        return _with_face(gearhead, screw, hole_depth, back, "gearhead")


@dataclass(frozen=True)
class EncoderBody(PlainRing, BoughtPart):
    """Encoder on a shaft's end, base at z = 0; depths of bore and tapped holes in mm."""

    what, chamfers_mm = "encoder", (0.0, _EDGE)

    entry: Encoder
    screw: Screw
    bore_depth: float
    hole_depth: float

    def ring(self) -> Ring:
        """Its housing."""
        return (self.entry.diameter_mm / 2, 0.0, 0.0, self.entry.length_mm)

    def cuts(self) -> list[cq.Shape]:
        """Blind bore, tapped holes in the base."""
        encoder, thread = self.entry, self.screw.thread_mm / 2
        places = _circle(encoder.screw_count, encoder.bolt_circle_mm / 2)
        bore = cylinder_z(encoder.bore_mm / 2, 0, 0, -1.0, self.bore_depth)
        return [bore, *(cylinder_z(thread, x, y, -1.0, self.hole_depth) for x, y in places)]


@dataclass(frozen=True)
class RingEncoderBody(PlainRing, BoughtPart):
    """Ring encoder, seat at z = 0; its screw heads lie ``grip`` mm above the seat."""

    what, chamfers_mm = "ring encoder", (0.0, _EDGE)

    entry: Encoder
    screw: Screw
    grip: float

    def ring(self) -> Ring:
        """Its housing, hollow."""
        return (self.entry.diameter_mm / 2, self.entry.bore_mm / 2, 0.0, self.entry.length_mm)

    def cuts(self) -> list[cq.Shape]:
        """Flats, and holes of the screws from behind, their heads sunk ``grip`` above the seat."""
        encoder, screw, grip = self.entry, self.screw, self.grip
        r, top = encoder.diameter_mm / 2, encoder.length_mm
        flat = RING_ENCODER_FLATS * r
        tools: list[cq.Shape] = [
            block((-r - 1.0, r + 1.0), side, (-1.0, top + 1.0)) for side in ((flat, r + 1.0), (-r - 1.0, -flat))
        ]
        for x, y in _circle(encoder.screw_count, encoder.bolt_circle_mm / 2):
            tools.append(cylinder_z(screw.clearance_mm / 2, x, y, -1.0, top + 1.0))
            tools.append(cylinder_z(screw.head_diameter_mm / 2 + 0.1, x, y, grip, top + 1.0))
        return tools


@dataclass(frozen=True)
class ScrewBody(BoughtPart):
    """Screw, its head's seat at z = 0."""

    cut_in_sections = False

    entry: Screw

    def in_rings(self) -> tuple[Ring, ...]:
        """Thread and head."""
        screw = self.entry
        head = (screw.head_diameter_mm / 2, 0.0, 0.0, screw.head_height_mm)
        return ((screw.thread_mm / 2, 0.0, -screw.length_mm, 0.0), head)

    def solid(self) -> cq.Solid:
        """Socket screw: head's seat at z = 0, head above, thread below (a plain cylinder). Set screws lie at z <= 0."""
        screw = self.entry
        thread = cylinder_z(screw.thread_mm / 2, 0, 0, -screw.length_mm, 0.0)
        if screw.head_height_mm == 0.0:
            depth = min(0.5 * screw.length_mm, screw.key_mm)
            return cut(thread, [hexagon_z(screw.key_mm, -depth, 1.0)], screw.name)
        head = cylinder_z(screw.head_diameter_mm / 2, 0, 0, 0.0, screw.head_height_mm)
        socket = hexagon_z(screw.key_mm, screw.head_height_mm / 2, screw.head_height_mm + 1.0)
        return cut(fuse([head, thread], screw.name), [socket], screw.name)


@dataclass(frozen=True)
class WaveSpring(PlainRing, BoughtPart):
    """The compressed spring as a plain ring from z = 0."""

    what = "wave spring"

    entry: PreloadSpringDims

    def ring(self) -> Ring:
        """As wide as it is."""
        return (self.entry.outer_radius, self.entry.inner_radius, 0.0, self.entry.height)


# Distance of a rope's mesh from the rod that it is drawn as, over the radius. A rope is no smooth rod: between six
# strands round a seventh are valleys of 0.4 radii.
ROD_MESH_RADII = 0.05


@dataclass(frozen=True)
class CableRod(Part):
    """Rod along ``pieces`` of a centre line, in the frame of the assembly at the path's drum angle; radius in mm."""

    pieces: tuple[Piece, ...]
    radius: float

    def solid(self) -> cq.Solid:
        """One sweep. Raises ``ValueError`` where the rod is thicker than a bend allows."""
        from mbcdm_cad.parts.rod import swept_rod

        return one_solid(cq.Shape.cast(swept_rod(self.pieces, self.radius)), "cable")
