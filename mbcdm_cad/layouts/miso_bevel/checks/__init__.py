"""The checks of this layout; the families in the order in which they run and are shown."""

from mbcdm_cad.checks import drum_sector, fixings, motors, springs, strength, structure, terminals
from mbcdm_cad.checks.comparison import Check, Family, families
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.input_pulley import pulley_checks
from mbcdm_cad.checks.transfer import transfer_checks
from mbcdm_cad.layouts.bevel_transfer import wrap_checks
from mbcdm_cad.layouts.miso_bevel.checks import support_fits, support_walls
from mbcdm_cad.layouts.miso_bevel.checks.room import ENVELOPE, SWEEPS
from mbcdm_cad.layouts.miso_bevel.checks.spans import SPANS, STACKS, stacks
from mbcdm_cad.layouts.miso_bevel.checks.transmission import BEARINGS, BENDING, GUIDE_FITS, RATIOS, SURFACES

__all__ = ["CHECKS", "FAMILIES", "stacks"]

_WIDER = (
    up("transmission.input_radii_mm"),
    down("transmission.ratios.input_to_guide"),
    up("all radii of transmission"),
)
# First the checks of the mechanism, then those of the parts.
FAMILIES = families(
    Family("Eq. (1) row by row, equal total ratio of both inputs, and the tension that a difference causes", RATIOS),
    Family(
        "Pitch radii and surface radii: the surface is cut at r - d/2, which must be a radius that can be machined",
        SURFACES,
    ),
    Family("Bend ratio D/d of the cable: on the pulleys, and at the stop inside the input pulley", BENDING),
    Family(
        "The transfer point: four step planes on one pitch line, lands wide enough, "
        "guide and drum close but not touching",
        transfer_checks("guide", "keep r_o/r_g equal for all steps, as transmission.ratios does"),
    ),
    Family(
        "Free spans between input pulleys and guide: distance, fleet angle, and gap between a span and its last turn.",
        SPANS,
    ),
    Family(
        "Gaps against the sum of the tolerances of the parts: a gap smaller than this sum may vanish in a built drive.",
        STACKS,
    ),
    Family(
        "Wrap on the drum over the travel: more than zero, less than a turn, and compared with the model's slip zones.",
        wrap_checks("guide"),
    ),
    strength,
    motors,
    Family(
        "Bearing loads against static ratings, and the deflection at the gearhead that the pulley's own bearings leave",
        BEARINGS,
    ),
    fixings,
    Family(
        "Input pulley, its stops and its coupling: bores, walls, and room for the parts on and around it",
        pulley_checks(_WIDER),
    ),
    Family("Guide pulley and its axle: bearings inside, walls round them, bending of the axle", GUIDE_FITS),
    drum_sector,
    structure,
    terminals,
    springs,
    support_walls,
    support_fits,
    Family(
        "Gaps between turning and fixed parts: the drum with its terminals and the drives, the collars and their space",
        SWEEPS,
    ),
    Family("Box and mass against their targets: from the layout, before anything is drawn", ENVELOPE),
)
CHECKS: tuple[Check, ...] = tuple(check for family in FAMILIES for check in family.checks)
