"""Screws and fits, and what a drawing says of them. No kernel here.

ISO metric threads: pitches (ISO 261, coarse), basic dimensions (ISO 724), tap drills (ISO 2306); joints. Also the
screws that hold a frame on what it is mounted on: socket heads lie on washers where the frame is printed, or the frame
has their threads, cut or in brass inserts. Sizes of ISO 4762 (heads, keys), ISO 273 medium (clearance holes) and ISO
7089 (washers). Lengths depend on the base, so that these screws are no parts of the drive.

Limits of size after ISO 286 for nominal sizes from 1 to 500 mm, and the fits that the parts of a drive use: standard
tolerances and fundamental deviations are the printed values of ISO 286-1:2010 tables 1 to 4 (micrometres); the
deviations of holes K to P follow by the rule of clause 4.3.2.3 of ISO 286-1: ES = -ei + (IT_n - IT_n-1) above 3 mm.
Checked against limits printed in ISO 286-2.

Geometric tolerances (ISO 1101) and the datums that they refer to (ISO 5459), as plain data of a sheet."""

import re
from bisect import bisect_left
from dataclasses import dataclass
from math import cos, inf, pi, radians, sin, sqrt
from typing import Literal

from mbcdm_cad.design.bought import InsertSpec, Material

# Coarse pitch and drill for tapping, mm, by nominal diameter.
_COARSE_MM = {
    1.0: (0.25, 0.75),
    1.2: (0.25, 0.95),
    1.4: (0.3, 1.1),
    1.6: (0.35, 1.25),
    2.0: (0.4, 1.6),
    2.5: (0.45, 2.05),
    3.0: (0.5, 2.5),
    4.0: (0.7, 3.3),
    5.0: (0.8, 4.2),
    6.0: (1.0, 5.0),
    8.0: (1.25, 6.8),
    10.0: (1.5, 8.5),
    12.0: (1.75, 10.2),
    16.0: (2.0, 14.0),
    20.0: (2.5, 17.5),
}
# Height of the fundamental triangle over the pitch.
_TRIANGLE = sqrt(3.0) / 2.0
# Screws of property class 8.8, tightened to seven tenths of their yield (usual values).
SCREW_YIELD_MPA = 640.0
TIGHTENED_SHARE = 0.7
# Shear strength over yield stress (von Mises).
SHEAR_SHARE = 0.577
# Share of a thread's cylinder that is sheared when it strips (usual for ISO threads).
THREAD_SHARE = 0.75
# Share of the strength of its thread that a screw may use: metal, and plastic under a lasting force, which creeps
# (estimate for PA12 and PLA).
METAL_SHARE, PLASTIC_SHARE = 0.7, 0.4
# Stress that the face of a brass insert bears (estimate for CuZn39Pb3, its yield).
BRASS_MPA = 250.0
# Clearance holes of ISO 273, medium, mm.
CLEARANCE_MM = {2.0: 2.4, 2.5: 2.9, 3.0: 3.4, 4.0: 4.5, 5.0: 5.5, 6.0: 6.6}
# Tolerance class of inside threads (ISO 965-1, usual).
THREAD_CLASS = "6H"
# A bottoming tap cuts no full thread on its last turns.
TAP_LEAD_PITCHES = 2.0


@dataclass(frozen=True)
class Thread:
    """An ISO metric coarse thread. Lengths in mm."""

    nominal_mm: float
    pitch_mm: float
    tap_drill_mm: float

    @property
    def name(self) -> str:
        """Designation, such as M2.5."""
        return f"M{self.nominal_mm:g}"

    @property
    def pitch_diameter_mm(self) -> float:
        """d2 = d - 2 (3/8) H (ISO 724)."""
        return self.nominal_mm - 0.75 * _TRIANGLE * self.pitch_mm

    @property
    def root_diameter_mm(self) -> float:
        """d3 = d - 2 (17/24) H, of the screw (ISO 68-1 with a round root)."""
        return self.nominal_mm - 17.0 / 12.0 * _TRIANGLE * self.pitch_mm

    @property
    def stress_area_mm2(self) -> float:
        """A_s = pi/4 ((d2 + d3) / 2)^2 (ISO 898-1)."""
        return 0.7853981633974483 * ((self.pitch_diameter_mm + self.root_diameter_mm) / 2.0) ** 2

    def full_thread_mm(self, drilled_mm: float) -> float:
        """Depth of full thread in a blind hole drilled to ``drilled_mm``."""
        return max(0.0, drilled_mm - TAP_LEAD_PITCHES * self.pitch_mm)


def thread(nominal_mm: float) -> Thread:
    """The coarse thread of a nominal diameter. Raises ``ValueError`` naming the sizes there are."""
    found = next((item for item in _COARSE_MM.items() if abs(item[0] - nominal_mm) < 1e-9), None)
    if found is None:
        sizes = ", ".join(f"{d:g}" for d in _COARSE_MM)
        raise ValueError(f"thread M{nominal_mm:g}: not a coarse thread of the table; choose one of {sizes} mm")
    return Thread(found[0], *found[1])


def clamp_force_N(nominal_mm: float) -> float:
    """Force of a tightened screw: seven tenths of yield over its stress area."""
    return TIGHTENED_SHARE * SCREW_YIELD_MPA * thread(nominal_mm).stress_area_mm2


@dataclass(frozen=True)
class ScrewHold:
    """What a tightened screw does for a joint, N: its force, what its thread bears pulled, and the part across."""

    clamp_N: float
    pull_N: float
    across_N: float = inf

    def slips_N(self, friction: float) -> float:
        """Force across at which the joint slips at this screw, or its insert moves in the plastic."""
        return min(friction * self.clamp_N, self.across_N)


def screw_hold(thread_mm: float, material: Material, insert: InsertSpec | None, engaged_mm: float) -> ScrewHold:
    """A screw whose thread is cut in a part, or in a brass insert flush with the face on which the other part lies.

    That part then presses on the brass round its clearance hole, which must be smaller than the insert: nothing that
    the screw tightens creeps. The plastic holds the insert where it is, and bears what pulls the joint open.
    """
    share = PLASTIC_SHARE if material.printed else METAL_SHARE
    across, along = (insert.outside_mm, insert.length_mm) if insert else (thread_mm, engaged_mm)
    strips = share * pi * across * along * THREAD_SHARE * SHEAR_SHARE * material.yield_MPa
    if insert is None:
        holds = min(clamp_force_N(thread_mm), strips)
        return ScrewHold(holds, holds)
    # The body between the knurls is what is sure to lie under the other part.
    ring = pi / 4.0 * max(insert.hole_mm**2 - CLEARANCE_MM[thread_mm] ** 2, 0.0)
    clamp = min(clamp_force_N(thread_mm), BRASS_MPA * ring)
    return ScrewHold(clamp, min(clamp, strips), share * material.yield_MPa * across * along)


@dataclass(frozen=True)
class MountScrew:
    """A screw with its washer. Lengths in mm."""

    thread_mm: float
    hole_mm: float
    head_mm: float
    head_height_mm: float
    key_mm: float
    washer_mm: float
    washer_height_mm: float

    @property
    def name(self) -> str:
        """Designation, such as M4."""
        return f"M{self.thread_mm:g}"

    def seat_mm(self, printed: bool) -> float:
        """Diameter that presses the frame: the head, or the washer under it."""
        return self.washer_mm if printed else self.head_mm

    def height_mm(self, printed: bool) -> float:
        """Height of the head over the frame."""
        return self.head_height_mm + (self.washer_height_mm if printed else 0.0)

    def words(self, printed: bool) -> str:
        """For instructions: ``M4 on washers``."""
        return f"{self.name} on washers" if printed else self.name


@dataclass(frozen=True)
class MountThread:
    """Thread of a mounting screw in the frame: how deep the screw may reach, and its insert where it has one."""

    depth_mm: float
    insert: InsertSpec | None


MOUNT_SCREWS = {
    screw.name: screw
    for screw in (
        MountScrew(3.0, 3.4, 5.5, 3.0, 2.5, 7.0, 0.5),
        MountScrew(4.0, 4.5, 7.0, 4.0, 3.0, 9.0, 0.8),
        MountScrew(5.0, 5.5, 8.5, 5.0, 4.0, 10.0, 1.0),
        MountScrew(6.0, 6.6, 10.0, 6.0, 5.0, 12.0, 1.6),
    )
}


SMALLEST_MM, LARGEST_MM = 1.0, 500.0
# Upper ends of the ranges of nominal sizes; a size that is an end belongs to the range below it.
_RANGES_MM = (3.0, 6.0, 10.0, 18.0, 30.0, 50.0, 80.0, 120.0, 180.0, 250.0, 315.0, 400.0, 500.0)
# Standard tolerances IT5 to IT13, one column a range.
_TOLERANCES_UM = {
    4: (3, 4, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20),
    5: (4, 5, 6, 8, 9, 11, 13, 15, 18, 20, 23, 25, 27),
    6: (6, 8, 9, 11, 13, 16, 19, 22, 25, 29, 32, 36, 40),
    7: (10, 12, 15, 18, 21, 25, 30, 35, 40, 46, 52, 57, 63),
    8: (14, 18, 22, 27, 33, 39, 46, 54, 63, 72, 81, 89, 97),
    9: (25, 30, 36, 43, 52, 62, 74, 87, 100, 115, 130, 140, 155),
    10: (40, 48, 58, 70, 84, 100, 120, 140, 160, 185, 210, 230, 250),
    11: (60, 75, 90, 110, 130, 160, 190, 220, 250, 290, 320, 360, 400),
    12: (100, 120, 150, 180, 210, 250, 300, 350, 400, 460, 520, 570, 630),
    13: (140, 180, 220, 270, 330, 390, 460, 540, 630, 720, 810, 890, 970),
}
# Upper deviation es of shafts d to h, lower deviation ei of shafts k to p.
_ES_UM = {
    "d": (-20, -30, -40, -50, -65, -80, -100, -120, -145, -170, -190, -210, -230),
    "e": (-14, -20, -25, -32, -40, -50, -60, -72, -85, -100, -110, -125, -135),
    "f": (-6, -10, -13, -16, -20, -25, -30, -36, -43, -50, -56, -62, -68),
    "g": (-2, -4, -5, -6, -7, -9, -10, -12, -14, -15, -17, -18, -20),
    "h": (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
}
_EI_UM = {
    "k": (0, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5),  # grades 4 to 7; 0 in all others
    "m": (2, 4, 6, 7, 8, 9, 11, 13, 15, 17, 20, 21, 23),
    "n": (4, 8, 10, 12, 15, 17, 20, 23, 27, 31, 34, 37, 40),
    "p": (6, 12, 15, 18, 22, 26, 32, 37, 43, 50, 56, 62, 68),
}
# Holes J have upper deviations of their own.
_J_ES_UM = {
    6: (2, 5, 5, 6, 8, 10, 13, 16, 18, 22, 25, 29, 33),
    7: (4, 6, 8, 10, 12, 14, 18, 22, 26, 30, 36, 39, 43),
    8: (6, 10, 12, 15, 20, 24, 28, 34, 41, 47, 55, 60, 66),
}
_CODE = re.compile(r"(JS|js|[DEFGHJKMNP]|[defghkmnp])(\d{1,2})")


@dataclass(frozen=True)
class SizeLimits:
    """Limits of a size in mm: nominal and the two deviations from it."""

    nominal_mm: float
    upper_mm: float
    lower_mm: float

    @property
    def largest_mm(self) -> float:
        """Upper limit of size."""
        return self.nominal_mm + self.upper_mm

    @property
    def smallest_mm(self) -> float:
        """Lower limit of size."""
        return self.nominal_mm + self.lower_mm


def limits(nominal_mm: float, code: str) -> SizeLimits:
    """Limits of ``nominal_mm`` for a tolerance class such as ``H7`` (hole) or ``h6`` (shaft).

    Raises ``ValueError`` with value, limit and remedy for a size outside 1 to 500 mm or a class that is not known.
    """
    if not SMALLEST_MM <= nominal_mm <= LARGEST_MM:
        raise ValueError(
            f"fit {code}: nominal size {nominal_mm:g} mm is outside {SMALLEST_MM:g} to {LARGEST_MM:g} mm; "
            "give its limits as numbers instead"
        )
    found = _CODE.fullmatch(code)
    grade = int(found.group(2)) if found else 0
    if found is None or grade not in _TOLERANCES_UM:
        raise ValueError(f"fit {code}: not a known tolerance class; use a letter D to P and a grade 5 to 13, as in H7")
    upper, lower = _deviations_um(found.group(1), grade, bisect_left(_RANGES_MM, nominal_mm))
    return SizeLimits(nominal_mm, upper / 1e3, lower / 1e3)


def _deviations_um(letter: str, grade: int, column: int) -> tuple[float, float]:
    """Upper and lower deviation, um."""
    tolerance = _TOLERANCES_UM[grade][column]
    if letter in ("js", "JS"):
        # Odd tolerances of IT7 to IT11 are rounded down to whole micrometres.
        half = (tolerance - tolerance % 2) / 2 if 7 <= grade <= 11 else tolerance / 2
        return half, -half
    if letter in _ES_UM:
        upper = _ES_UM[letter][column]
        return upper, upper - tolerance
    if letter in _EI_UM:
        lower = 0 if letter == "k" and not 4 <= grade <= 7 else _EI_UM[letter][column]
        return lower + tolerance, lower
    if letter.lower() in _ES_UM:
        lower = -_ES_UM[letter.lower()][column]
        return lower + tolerance, lower
    upper = _hole_upper_um(letter, grade, column)
    return upper, upper - tolerance


def _hole_upper_um(letter: str, grade: int, column: int) -> int:
    """ES of holes J to P."""
    if letter == "J":
        if grade not in _J_ES_UM:
            raise ValueError(f"fit J{grade}: ISO 286 has J6, J7 and J8 only; use JS{grade}")
        return _J_ES_UM[grade][column]
    ei = 0 if letter == "K" and grade > 8 else _EI_UM[letter.lower()][column]
    # Rule of ISO 286 for equal fits of hole and shaft with one letter: K, M, N up to IT8, P up to IT7.
    step_applies = column > 0 and grade <= (7 if letter == "P" else 8)
    if (letter, grade, column) == ("M", 6, _RANGES_MM.index(315.0)):
        return -9  # the only value of the standard's table that differs from the rule
    if letter == "N" and grade > 8:
        return -_EI_UM["n"][0] if column == 0 else 0
    return -ei + (_TOLERANCES_UM[grade][column] - _TOLERANCES_UM[grade - 1][column] if step_applies else 0)


@dataclass(frozen=True)
class RoleFit:
    """The tolerance class chosen for one role, with the reason and where the recommendation comes from."""

    code: str
    reason: str
    source: str


_BEARING_MAKERS = "rolling bearing makers' tables for radial ball bearings (SKF, 'Shaft and housing fits')"
_PINS = "ISO 2338 and common practice for dowels"

# On the input pulleys and the drum's shaft the inner ring rotates relative to the load, on the guide the outer ring.
FITS = {
    "idler_seat": RoleFit("N7", "outer ring turns against the load: it must not creep", _BEARING_MAKERS),
    "idler_axle": RoleFit(
        "h6", "inner ring stands still against the load, and slides on for assembly", _BEARING_MAKERS
    ),
    "spacer_bore": RoleFit("H7", "slides on the axle h6", "ISO 286 hole-basis practice"),
    "input_journal": RoleFit("js6", "inner ring turns against a light load; up to 17 mm js", _BEARING_MAKERS),
    "input_seat": RoleFit("H7", "outer ring stands still against the load", _BEARING_MAKERS),
    "drum_shaft": RoleFit(
        "h5", "inner ring turns under a light load, but the front ring is pushed on", _BEARING_MAKERS
    ),
    "drum_seat": RoleFit(
        "H6", "outer rings stand still, the rear one slides under its spring with the least play", _BEARING_MAKERS
    ),
    "drum_bore": RoleFit(
        "H7", "hub slides on the shaft h5 and is held by its set screws", "ISO 286 hole-basis practice"
    ),
    "axle_bore": RoleFit("H7", "axle h6 is put in by hand", "ISO 286 hole-basis practice"),
    "gear_shaft_bore": RoleFit(
        "H7", "slides on the gearhead's shaft; the collar closes it", "ISO 286 hole-basis practice"
    ),
    "pilot": RoleFit("H8", "spigot of the gearhead centres, its screws hold", "ISO 286 hole-basis practice"),
    "collar_bore": RoleFit("H7", "slides on the slit journal and closes it", "ISO 286 hole-basis practice"),
    "land": RoleFit("js7", "the land's radius sets the ratio: both signs alike", "tolerance of the ratio"),
    "printed_land": RoleFit(
        "js12", "as printed: some 0.1 mm on 20 mm, 0.2 mm on 150 mm", "estimate: printing services"
    ),
    "pin": RoleFit("m6", "parallel pin", _PINS),
    "pin_press": RoleFit("H7", "pin m6 stays in this part", _PINS),
    "pin_slide": RoleFit("G7", "pin m6 comes out of this part by hand", _PINS),
}


def radius_band_mm(radius_mm: float, role: str) -> float:
    """Half the tolerance of a radius turned to the fit of ``role``, mm; beyond the table its nearest size is used."""
    diameter = min(max(2.0 * radius_mm, SMALLEST_MM), LARGEST_MM)
    size = limits(diameter, FITS[role].code)
    return (size.upper_mm - size.lower_mm) / 4.0


Vector = tuple[float, float, float]
Characteristic = Literal["run-out", "perpendicularity", "parallelism", "coaxiality"]


@dataclass(frozen=True)
class Datum:
    """A plane face that tolerances refer to: a point of it in a view, and its letter.

    The axis of a cylinder is a datum by the field ``datum`` of its diameter instead.
    """

    view: str
    at: Vector
    letter: str


@dataclass(frozen=True)
class GeometricTolerance:
    """A tolerance of ``value_mm`` on the face at a point of a view.

    ``datums``: the letters that it refers to, ``("D-E",)`` for a common datum of two. ``count``: of how many equal
    features; ``at`` is on one of them, ``others`` one point on each of the rest. ``axis``: it holds for the axis of the
    cylinder there, within a cylinder of ``value_mm``; ``of``: the letter of those holes in the table of holes.
    """

    view: str
    at: Vector
    characteristic: Characteristic
    value_mm: float
    datums: tuple[str, ...]
    others: tuple[Vector, ...] = ()
    axis: bool = False
    of: str = ""

    @property
    def places(self) -> tuple[Vector, ...]:
        """A point on each feature that it holds for."""
        return (self.at, *self.others)


# Letters of the drum's axis and of the face on which heads and plates rest; holes have the letters from A on.
_BESIDE_RAD = radians(20.0)
DRUM_AXIS, REST = "S", "T"
# Two seats of one shaft that are bored in one setting, a bore that is square or parallel to them, and faces, mm.
ONE_AXIS_MM, TO_AXIS_MM, SHOULDER_MM, FACE_MM = 0.005, 0.02, 0.01, 0.02


def one_axis(view: str, seats: tuple[Vector, ...], datum: str) -> GeometricTolerance:
    """The seats at a point of their walls are on their common axis, the ``datum``."""
    return GeometricTolerance(view, seats[0], "coaxiality", ONE_AXIS_MM, (datum,), seats[1:], axis=True)


def square(view: str, at: Vector, datum: str, of: str, others: tuple[Vector, ...] = ()) -> GeometricTolerance:
    """The axis of the bore at a point of its wall is square to the axis ``datum``; ``of`` is the bore's letter."""
    return GeometricTolerance(view, at, "perpendicularity", TO_AXIS_MM, (datum,), others, axis=True, of=of)


def shoulder_place(seat_mm: float, shoulder_mm: float) -> tuple[float, float]:
    """A point of the shoulder of a seat round the origin, beside the holes that are often on its X axis."""
    middle = (seat_mm + shoulder_mm) / 2.0
    return middle * cos(_BESIDE_RAD), middle * sin(_BESIDE_RAD)


def level(view: str, at: Vector, value_mm: float, others: tuple[Vector, ...] = ()) -> GeometricTolerance:
    """The face at a point is parallel to the face on which the part rests."""
    return GeometricTolerance(view, at, "parallelism", value_mm, (REST,), others)
