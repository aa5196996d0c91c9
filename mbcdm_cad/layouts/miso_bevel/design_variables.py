"""Parameters of this configuration's designs that a remedy may change."""

from __future__ import annotations

from dataclasses import replace

from mbcdm_cad.checks.design_variables import ALL_RADII, SHARED, DesignVariable, by_path, field, radii
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive


def _input_ratio(drive: BevelDrive, value: float) -> BevelDrive:
    return replace(drive, cables=tuple(replace(c, input_radius_mm=c.guide_radius_mm / value) for c in drive.cables))


def _radii_explicit(drive: BevelDrive) -> bool:
    return drive.radii_explicit


def _all_radii(drive: BevelDrive) -> tuple[str, str]:
    return (ALL_RADII, "") if drive.radii_explicit else ("transmission.drum_radii_mm", " (the others follow)")


def _first_drum_mm(drive: BevelDrive) -> float:
    return drive.cables[0].drum_radius_mm


def _total_ratio(drive: BevelDrive) -> float:
    return drive.cables[0].drum_radius_mm / drive.cables[0].input_radius_mm


_DRUM = (
    "sector_half_angle_deg",
    "rim_inner_radius_mm",
    "outer_face_y_mm",
    "web_thickness_mm",
    "hub_diameter_mm",
    "hub_face_y_mm",
    "shaft_bore_mm",
)
_SUPPORT = (
    "back_y_mm",
    "back_plate_mm",
    "side_wall_mm",
    "motor_shelf_mm",
    "coupling_space_mm",
    "bearing_shelf_mm",
    "top_plate_mm",
    "rib_mm",
)
VARIABLES: dict[str, DesignVariable] = by_path(
    (
        *SHARED,
        field("transmission.centre_distance_mm", "centre_distance_mm"),
        field("transmission.input_setback_mm", "input_setback_mm"),
        radii(ALL_RADII, ("drum_radius_mm", "guide_radius_mm", "input_radius_mm"))._replace(
            shown=_all_radii, short=("transmission.drum_radius_mm", _first_drum_mm)
        ),
        radii("transmission.input_radii_mm", ("input_radius_mm",))._replace(applies=_radii_explicit),
        radii("transmission.guide_radii_mm", ("guide_radius_mm",))._replace(applies=_radii_explicit),
        DesignVariable(
            "transmission.ratios.input_to_guide",
            lambda drive: drive.cables[0].guide_radius_mm / drive.cables[0].input_radius_mm,
            _input_ratio,
            applies=lambda drive: not drive.radii_explicit,
            asked=True,
            short=("transmission.ratio", _total_ratio),
        ),
        field("rope.helix_lead_mm", "helix_lead_mm"),
        field("rope.dead_turns", "dead_turns"),
        field("clearances.transfer_gap_mm"),
        field("clearances.land_edge_mm"),
        *(field(f"drum.{name}") for name in _DRUM),
        *(field(f"support.{name}") for name in _SUPPORT),
    )
)
