"""Effect of the parts' tolerances on each gap between moving parts: one closed formula for each gap, without a layout.

Each function gives the contributions; with the nominal margin they make a
:class:`~mbcdm_cad.model.tolerance.StackUp`. Lengths in mm. Parts are assumed to be made to the fits of
:mod:`mbcdm_cad.parts.fits` and to the design's block ``making``. Run-out counts half its reading on each radius, play
half its size to either side; the drum's bearings have no play, because a spring presses them apart.
"""

from math import radians, tan, tau

from mbcdm_cad.layouts.miso_bevel.cable_path import fleet_angle_deg, winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.model.tolerance import Contribution
from mbcdm_cad.parts.drum_sector.design import END_PLAY_MM
from mbcdm_cad.parts.making import axial_play_mm, body_accuracy, land_band_mm, rope_band_mm

_NEWTON_STEPS = 12


def guide_wall_contributions(drive: BevelDrive, cable: BevelRun) -> tuple[Contribution, ...]:
    """Contributions to the gap from a cable's flank to the walls of its step of the guide, along z."""
    drum, guide, frame = (body_accuracy(drive, part) for part in ("drum", "passed", "frame"))
    return (
        Contribution("radius of the drum's land", land_band_mm(drive, cable.drum_radius_mm, "drum")),
        Contribution("run-out of the drum", drum.run_out_mm, 0.5),
        Contribution("place of the guide's shelf over the drum's axis", frame.position_mm),
        Contribution("place of the walls on the guide", guide.position_mm),
        Contribution("axial play of the guide's bearings", axial_play_mm(drive), 0.5),
        # The centre line lies half a rope over the drum's surface, the flank half a rope beside it.
        Contribution("rope's diameter", rope_band_mm(drive), 1.0),
    )


def self_clearance(drive: BevelDrive, cable: BevelRun) -> tuple[float, tuple[Contribution, ...]]:
    """Gap of the leaving span to the turn wound before it, fully wound, and its contributions.

    Near the contact the previous turn lies r a^2/2 inside the tangent and lead - c a above the span, a the angle back
    from the contact, c = lead/2 pi + r tan(fleet angle): D^2 = (r a^2/2)^2 + (lead - c a)^2, least where r^2 a^3 = 2 c
    (lead - c a) (derived). At the minimum the change of a has no effect to first order. Raises ``ValueError`` if there
    is no free span.
    """
    r, lead = cable.input_radius_mm, drive.helix_lead_mm
    slope, span = tan(radians(fleet_angle_deg(drive, cable))), winding(drive, cable).free_span_mm
    c = lead / tau + r * slope
    a = (2.0 * c * lead / r**2) ** (1.0 / 3.0)
    for _ in range(_NEWTON_STEPS):
        a -= (r**2 * a**3 - 2.0 * c * (lead - c * a)) / (3.0 * r**2 * a**2 + 2.0 * c**2)
    above = lead - c * a
    distance = ((r * a**2 / 2.0) ** 2 + above**2) ** 0.5
    per_slope = -above * r * a / distance
    per_radius = (r * a**4 / 4.0 - above * slope * a) / distance
    pulley, guide, frame = (body_accuracy(drive, part) for part in ("pulley", "passed", "frame"))
    heights = 1.0 / span
    return distance - drive.cable.diameter_mm, (
        Contribution("rope's diameter", rope_band_mm(drive), per_radius / 2.0 - 1.0),
        Contribution("radius of the input pulley", land_band_mm(drive, r, "pulley"), per_radius),
        Contribution("run-out of the input pulley", pulley.run_out_mm, per_radius / 2.0),
        Contribution("end play of the input pulley", END_PLAY_MM, per_slope * heights / 2.0),
        Contribution("height of the guide's step over the pulley's", guide.position_mm, per_slope * heights),
        Contribution("centre distance", frame.position_mm, -per_slope * slope * drive.centre_distance_mm / span**2),
    )


def pair_path_contributions(drive: BevelDrive, pair: tuple[BevelRun, BevelRun]) -> tuple[Contribution, ...]:
    """Contributions to the length by which the two cables of an input differ at the end of travel.

    A cable's path changes by theta (dr_o - i dr_m). A thicker rope changes both radii by half of its excess, and the
    ratios of the pair by different shares since their radii differ.
    """
    half, shift = radians(drive.half_travel_deg), 0.0
    found: list[Contribution] = []
    for sign, c in zip((1.0, -1.0), pair, strict=True):
        ratio = c.drum_radius_mm / c.input_radius_mm
        found += [
            Contribution(f"drum radius of {c.name}", land_band_mm(drive, c.drum_radius_mm, "drum"), half),
            Contribution(f"input radius of {c.name}", land_band_mm(drive, c.input_radius_mm, "pulley"), half * ratio),
        ]
        shift += sign * half * (1.0 - ratio) / 2.0
    return (*found, Contribution("rope's diameter", rope_band_mm(drive), shift))
