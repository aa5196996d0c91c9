"""Make a drive from a validated siso_bevel design: radii of every cable, catalogue entries in place of names."""

from __future__ import annotations

from collections.abc import Mapping

from mbcdm_cad.design.drive import Sigmas
from mbcdm_cad.design.fieldpath import FieldPath
from mbcdm_cad.design.lookup import Catalogue
from mbcdm_cad.design.resolve import by_step, preload_N, shared_sigmas, shared_values
from mbcdm_cad.layouts.siso_bevel import drive as d
from mbcdm_cad.layouts.siso_bevel.design_file.schema import DirectDesign, DirectTransmission
from mbcdm_cad.parts.drum_sector.resolve import sector_values, terminal_angle_rad

_SIGN = {"-x": -1, "+x": 1}


def drive(design: DirectDesign, catalogue: Catalogue, sigmas: Mapping[FieldPath, float]) -> d.DirectDrive:
    """The drive of a valid design; its cables are in the order of their steps."""
    places = by_step(design.cables)
    pulleys = input_radii_mm(design.transmission)

    def radii(name: str) -> tuple[float, ...]:
        return tuple(sigmas.get(("transmission", name, design.cables[k].step - 1), 0.0) for k in places)

    return d.DirectDrive(
        **shared_values(design, catalogue),
        **sector_values(design, catalogue),
        # The cable stays in its plane; the reserve is given as an angle.
        helix_lead_mm=0.0,
        dead_turns=design.transmission.reserve_deg / 360.0,
        cables=tuple(
            d.DirectRun(
                name=cable.name,
                input_name=cable.input,
                drum_side=_SIGN[cable.drum_side],
                step=cable.step,
                input_radius_mm=pulleys[cable.step - 1],
                drum_radius_mm=design.transmission.drum_radii_mm[cable.step - 1],
                preload_N=preload_N(design, cable),
                terminal_angle_rad=terminal_angle_rad(cable),
            )
            for cable in (design.cables[k] for k in places)
        ),
        reserve_deg=design.transmission.reserve_deg,
        radii_explicit=design.transmission.input_to_drum is None,
        bearings=d.DirectBearings(
            drum=catalogue.bearing(design.drum.bearing),
            input_lower=catalogue.bearing(design.input_pulleys.lower_bearing),
            input_upper=catalogue.bearing(design.input_pulleys.upper_bearing),
        ),
        sigmas=Sigmas(
            **shared_sigmas(design, catalogue, sigmas, places),
            lengths_mm={"input_radius_mm": radii("input_radii_mm"), "drum_radius_mm": radii("drum_radii_mm")},
        ),
    )


def input_radii_mm(transmission: DirectTransmission) -> tuple[float, ...]:
    """Input pitch radii by step, from the ratio or as given; those from the ratio are rounded to 1e-9 mm."""
    if transmission.input_to_drum is None:
        return transmission.input_radii_mm or ()
    return tuple(round(radius / transmission.input_to_drum, 9) for radius in transmission.drum_radii_mm)
