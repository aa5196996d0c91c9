"""Sizing rules of siso_bevel, in the order of the power flow; many evaluate checks on a trial drive (trial_sizing)."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from math import ceil
from typing import Any

from mbcdm_cad.design.paths import at
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import Freedom
from mbcdm_cad.layouts import common_rules, head_dims
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.bevel_sizing import GUESSES, RADII, TransferKnown, land_edge, outer_face, transfer_gap
from mbcdm_cad.layouts.common_rules import SCHEMA_VERSION, half_travel, missing_travel, needed
from mbcdm_cad.layouts.head_basis import LIMITS, METALS, ROPE_LIMITS, TRAIN, rope, taut_preload, taut_rope
from mbcdm_cad.layouts.head_parts import PARTS
from mbcdm_cad.layouts.open_ratio import SizingRules
from mbcdm_cad.layouts.siso_bevel.checks import LEAST_RESERVE_DEG, highest_ratio
from mbcdm_cad.layouts.siso_bevel.design_file import REFERENCE, DirectDrive
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.stiff_sizing import SHARED, walls
from mbcdm_cad.parts.fits import MOUNT_SCREWS
from mbcdm_cad.sizing import Found, Rule, constant, rounded_up, rule

# Wrap that stays on the input, and estimated angle of the stop's slot before it is known, deg.
RESERVE_DEG, SLOT_DEG = 18.0, 8.0
# Walls of a milled part and of a printed one, mm (estimate: the modulus of filament is about twenty times smaller).
BACK_MM, RIB_MM = (3.0, 6.0), (5.0, 8.0)
_STEPS_TRIED = 24
# Reserves that are tried, the usual one first: a ratio that the file states may leave less of the turn.
RESERVES_DEG = (RESERVE_DEG, 17.0, 16.0, LEAST_RESERVE_DEG)


@rule(
    at.transmission.input_to_drum,
    "the highest with which travel and reserve fit on one turn of the input",
    "input_under_turn",
    lambda given: not given.has(at.transmission.input_radii_mm),
)
def _ratio(given: "DirectKnown") -> Found:
    """The highest ratio at which the travel, the reserve and the stop's slot stay within a turn of the input."""
    field, reserve = at.transmission.input_to_drum, given.get(at.transmission.reserve_deg, RESERVE_DEG)
    most = (360.0 - reserve - SLOT_DEG) / (2 * given[at.travel.half_angle_deg])
    with suppress(ValueError, NoFigureError):
        # The pulley of so high a ratio may be too small for the stop of a thick rope: then the checks alone limit it.
        drive = given.trial(field, 1.0).drive
        assert isinstance(drive, DirectDrive)
        most = highest_ratio(drive)
    return given.moved(field, most, -0.05, ("input_under_turn", "drum_sweep", "bearing_seats", "bend_ratio"))


@rule(
    at.transmission.reserve_deg,
    "usual wrap that never unwinds, or less if one turn of the input leaves less",
    "input_reserve",
)
def _reserve(given: "DirectKnown") -> Found:
    return given.first(at.transmission.reserve_deg, RESERVES_DEG, ("input_under_turn",))


@rule(at.transmission.drum_radii_mm, "step 1 as stated; step 2 the smallest that the lands allow", "land_width")
def drum_radii(given: "DirectKnown") -> Found:
    """The smallest radius of step 2 that the lands at the transfer allow."""
    first, rise = given[at.transmission.drum_radius_mm], 0.1 * given.d_mm * given.ratio
    pairs = [[first, round(first + (4 + k) * rise, 2)] for k in range(_STEPS_TRIED)]
    checks = ("radii_rise", "land_width", "land_edge", "bodies_clear", "transfer_gap", "stop_pocket_floor")
    return given.first(at.transmission.drum_radii_mm, pairs, checks)


@rule(at.support.side_wall_mm, "usual walls, thick enough for the motor head's screws", "flange")
def _side_wall(given: "DirectKnown") -> Found:
    return given.moved(at.support.side_wall_mm, head_dims.side_wall(given), 0.1, ("flange", "collar_space", "walls"))


@rule(at.support.back_plate_mm, "usual thickness for making it in its material", "walls")
def back_plate(given: "DirectKnown") -> float:
    return rounded_up(max(head_dims.either(given, "support", BACK_MM), given.wall_mm("support")), 0.1)


@rule(at.support.rib_mm, "usual thickness, or less for the height of its pockets", "pockets")
def rib(given: "DirectKnown") -> Found:
    """The usual thickness, or less if the pockets of a small drum else have no height."""
    least = given.wall_mm("support")
    usual = max(head_dims.either(given, "support", RIB_MM), least)
    tried = [round(usual - 0.5 * k, 2) for k in range(ceil((usual - least) / 0.5))]
    return given.first(at.support.rib_mm, [*tried, least], ("pockets", "mounts"))


@rule(
    at.support.back_y_mm,
    "nearest plane with space for the pulley and between the drum's bearings",
    "drum_bearing_spacing",
)
def back(given: "DirectKnown") -> Found:
    start = -given.drum_mm / given.ratio
    checks = ("drum_bearing_spacing", "boss", "pockets", "pulley_room", "encoder_room")
    return given.moved(at.support.back_y_mm, start, -0.5, checks)


TRANSFER = (land_edge, transfer_gap, drum_radii)
FRAME = (
    head_dims.motor_shelf,
    back_plate,
    rib,
    head_dims.bearing_shelf,
    head_dims.encoder_shelf,
    head_dims.coupling_space,
    _side_wall,
)
DRUM = head_dims.drum_rules(outer_face)


class DirectKnown(TransferKnown):
    """Adds the values of an input at the drum."""

    layout = DirectLayout
    asked = (
        at.travel.half_angle_deg,
        at.loads.peak_torque_Nm,
        at.transmission.input_to_drum,
        at.rope.type,
        at.rope.preload_N,
        at.drive.motor,
        at.drive.gearhead,
    )
    own_checks: Mapping[str, tuple[str, ...]] = {at.input_pulleys.lower_bearing: ("bearing_seats",)}

    @property
    def before_drum_mm(self) -> list[float]:
        """Pitch radii of the input."""
        return [radius / self.ratio for radius in self[RADII]]

    @property
    def has_ratio(self) -> bool:
        """See the base class."""
        return any(self.has(field) for field in (at.transmission.input_to_drum, at.transmission.input_radii_mm))

    @property
    def ratio(self) -> float:
        """Drum radius over input radius."""
        if self.has(at.transmission.input_to_drum):
            return float(self[at.transmission.input_to_drum])
        return float(self[at.transmission.drum_radii_mm][0] / self[at.transmission.input_radii_mm][0])


RULES: tuple[Rule, ...] = (
    half_travel,
    SCHEMA_VERSION,
    constant("inputs", REFERENCE.inputs, "one", "the configuration"),
    constant("cables", REFERENCE.cables, "one cable for each sense of the drum", "the configuration"),
    *LIMITS,
    *METALS,
    rope(taut_rope),
    *ROPE_LIMITS,
    Rule(at.rope.preload_N, "twice the preload that keeps both cables taut at peak torque", "no_slack", taut_preload),
    _ratio,
    *TRAIN,
    *TRANSFER,
    _reserve,
    *PARTS,
    *FRAME,
    head_dims.mount_screw(MOUNT_SCREWS, "mounts"),
    *DRUM,
    back,
)
DERIVED = tuple(rule.field for rule in (*TRANSFER, *FRAME, *DRUM, back) if rule.field != at.drum.windows)
STIFFENERS = (*SHARED, *walls("back_plate", "rib", "side_wall"))


# What ``mbcdm solve`` may change besides the derived dimensions.
FREEDOMS: tuple[Freedom, ...] = (
    *common_rules.PARTS,
    Freedom(at.support.mount_screw, words=tuple(MOUNT_SCREWS)),
    Freedom(at.transmission.input_to_drum, 0.5, 1.0),
    # Only the second radius changes: the first is a requirement.
    Freedom(at.transmission.drum_radii_mm, 0.5, 3.0, instead=common_rules.first_radius),
)


def _first_guesses(given: DirectKnown) -> dict[str, Any]:
    """Values of a drive of medium size, for fields that the first pass does not know yet."""
    radius_mm = given.drum_mm
    return {
        **GUESSES,
        # An open ratio is found with the reserve open too: a guess of it would exclude the highest ratios.
        **({at.transmission.reserve_deg: RESERVE_DEG} if given.has(at.transmission.input_to_drum) else {}),
        at.transmission.drum_radii_mm: [radius_mm, 1.06 * radius_mm],
        at.drum.sector_half_angle_deg: 90.0,
        at.drum.rim_inner_radius_mm: 0.8 * radius_mm,
        at.drum.outer_face_y_mm: 40.0,
        at.drum.hub_face_y_mm: 60.0,
        at.support.back_plate_mm: 4.0,
        at.support.rib_mm: 5.0,
    }


def _missing(given: DirectKnown) -> Iterator[Broken]:
    yield from missing_travel(given, "travel each way from the centred drum")
    if not given.has(at.loads.peak_torque_Nm):
        yield needed(at.loads.peak_torque_Nm, "add peak_torque_Nm: 0.98 (torque to hold both ways, N m)")
    if not any(given.has(f"transmission.{name}") for name in ("drum_radii_mm", "drum_radius_mm")):
        yield needed(at.transmission.drum_radius_mm, "add drum_radius_mm: 58.0 (drum pitch radius of step 1)")
    elif given.has(at.transmission.input_radii_mm) and not given.has(at.transmission.drum_radii_mm):
        yield needed(at.transmission.drum_radii_mm, "add the drum's radii, because those of the input are given")


size = SizingRules(DirectKnown, (), RULES, STIFFENERS, _first_guesses, _missing)
