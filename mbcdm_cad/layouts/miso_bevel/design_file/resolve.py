"""Make a drive from a validated miso_bevel design: radii of every cable, catalogue entries in place of names."""

from __future__ import annotations

from collections.abc import Mapping

from mbcdm_cad.design.drive import Sigmas
from mbcdm_cad.design.fieldpath import FieldPath
from mbcdm_cad.design.lookup import Catalogue
from mbcdm_cad.design.resolve import by_step, preload_N, shared_sigmas, shared_values
from mbcdm_cad.layouts.miso_bevel import drive as d
from mbcdm_cad.layouts.miso_bevel.design_file.schema import BevelDesign, Transmission
from mbcdm_cad.parts.drum_sector.resolve import sector_values, terminal_angle_rad

_SIGN = {"-x": -1, "+x": 1}


def drive(design: BevelDesign, catalogue: Catalogue, sigmas: Mapping[FieldPath, float]) -> d.BevelDrive:
    """The drive of a valid design; its cables are in the order of their steps."""
    drum, guide, pulleys = design.drum, design.guide, design.input_pulleys
    return d.BevelDrive(
        **shared_values(design, catalogue) | sector_values(design, catalogue),
        helix_lead_mm=design.rope.helix_lead_mm,
        dead_turns=design.rope.dead_turns,
        cables=_cables(design),
        input_sides=tuple(_SIGN[item.side] for item in design.inputs),
        centre_distance_mm=design.transmission.centre_distance_mm,
        input_setback_mm=design.transmission.input_setback_mm,
        motors_above=design.drive.motor_side == "above",
        radii_explicit=design.transmission.ratios is None,
        bearings=d.Bearings(
            drum=catalogue.bearing(drum.bearing),
            guide=catalogue.bearing(guide.bearing),
            input_lower=catalogue.bearing(pulleys.lower_bearing),
            input_upper=catalogue.bearing(pulleys.upper_bearing),
        ),
        guide_material=catalogue.material(guide.material),
        axle_material=catalogue.material(guide.axle_material),
        sigmas=_sigmas(design, catalogue, sigmas),
    )


def pitch_radii_mm(transmission: Transmission) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Guide and input pitch radii by step, from the ratios or as given.

    Radii from ratios are rounded to 1e-9 mm, so that 57.6/6 reads 9.6 in reports and not 9.600000000000001.
    """
    if transmission.ratios is None:
        return transmission.guide_radii_mm or (), transmission.input_radii_mm or ()
    ratios = transmission.ratios
    guide = tuple(round(radius / ratios.guide_to_drum, 9) for radius in transmission.drum_radii_mm)
    return guide, tuple(round(radius / ratios.input_to_guide, 9) for radius in guide)


def _cables(design: BevelDesign) -> tuple[d.BevelRun, ...]:
    guide, pulley = pitch_radii_mm(design.transmission)
    sides = {item.name: _SIGN[item.side] for item in design.inputs}
    return tuple(
        d.BevelRun(
            name=cable.name,
            input_name=cable.input,
            input_side=sides[cable.input],
            drum_side=_SIGN[cable.drum_side],
            step=cable.step,
            input_radius_mm=pulley[cable.step - 1],
            guide_radius_mm=guide[cable.step - 1],
            drum_radius_mm=design.transmission.drum_radii_mm[cable.step - 1],
            preload_N=preload_N(design, cable),
            terminal_angle_rad=terminal_angle_rad(cable),
        )
        for cable in (design.cables[k] for k in by_step(design.cables))
    )


def _sigmas(design: BevelDesign, catalogue: Catalogue, given: Mapping[FieldPath, float]) -> Sigmas:
    places = by_step(design.cables)

    def radii(name: str) -> tuple[float, ...]:
        return tuple(given.get(("transmission", name, design.cables[k].step - 1), 0.0) for k in places)

    lengths: dict[str, float | tuple[float, ...]] = {
        "input_radius_mm": radii("input_radii_mm"),
        "guide_radius_mm": radii("guide_radii_mm"),
        "drum_radius_mm": radii("drum_radii_mm"),
        "centre_distance_mm": given.get(("transmission", "centre_distance_mm"), 0.0),
    }
    return Sigmas(**shared_sigmas(design, catalogue, given, places), lengths_mm=lengths)
