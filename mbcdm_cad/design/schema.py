"""Schema of the design file: every field with type, bounds, unit, source and a line of meaning.

Fields keep the units in their names (mm, degrees, N, N m, g). ``source`` speaks of the reference value, the one that
``mbcdm init`` writes. What cannot be said field by field is in :mod:`mbcdm_cad.design.rules`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.entries import OwnEntries, RopeEntry
from mbcdm_cad.design.fields import Block, CheckId, EntryName, Integer, Number, Slug, Text, choice, quantity

PAPER = "paper"  # the journal paper of the mechanism, whose tables and sections the sources name
ESTIMATE = "estimate"
DERIVED = "derived from Tables 1 and 2"

Radius = Annotated[Number, Field(ge=0.5, le=500.0)]
Side = Literal["-x", "+x"]


class Travel(Block):
    """How far the drum turns."""

    half_angle_deg: Number = quantity(
        "travel each way from the centred drum",
        unit="deg",
        source="needed by the wrap left at both ends",
        reference=35.0,
        ge=1.0,
        le=120.0,
    )
    stop_clearance_deg: Number = quantity(
        "how much later the hard stops engage",
        unit="deg",
        source="stops between 35.0 and 35.5",
        reference=0.25,
        ge=0.0,
        le=5.0,
    )


class Ratios(Block):
    """Reductions, large radius over small; every cable then satisfies Eq. (1) exactly."""

    input_to_guide: Number = quantity(
        "guide radius over input radius", unit="-", source="Table 2: 9/6", reference=1.5, ge=0.2, le=20.0
    )
    guide_to_drum: Number = quantity(
        "drum radius over guide radius", unit="-", source="Table 2: 54/9", reference=6.0, ge=0.5, le=50.0
    )


class Transmission(Block):
    """Pitch radii (to the cable's centre line), by step 1 to 4, and where the pulleys stand."""

    centre_distance_mm: Number = quantity(
        "input pulley axis to guide axis, L",
        unit="mm",
        uncertain=True,
        source="Table 2",
        reference=34.6,
        ge=2.0,
        le=500.0,
    )
    drum_radii_mm: tuple[Radius, ...] = quantity(
        "drum pitch radii r_o of steps 1 to 4",
        unit="mm",
        uncertain=True,
        source="Table 2",
        reference=[54.0, 57.6, 61.2, 64.8],
        min_length=4,
        max_length=4,
    )
    ratios: Ratios | None = quantity(
        "reductions that give guide and input radii; leave out when the radii are explicit",
        unit="-",
        source="Table 2",
        reference={},
        default=None,
    )
    guide_radii_mm: tuple[Radius, ...] | None = quantity(
        "explicit guide pitch radii r_g of steps 1 to 4, in place of ratios; Eq. (1) is then checked",
        unit="mm",
        uncertain=True,
        source="Table 2",
        example=[9.0, 9.6, 10.2, 10.8],
        default=None,
        min_length=4,
        max_length=4,
    )
    input_radii_mm: tuple[Radius, ...] | None = quantity(
        "explicit input pitch radii r_m of steps 1 to 4, in place of ratios",
        unit="mm",
        uncertain=True,
        source="Table 2",
        example=[6.0, 6.4, 6.8, 7.2],
        default=None,
        min_length=4,
        max_length=4,
    )


class Input(Block):
    """An input pulley with its own motor."""

    name: Slug = choice("name, used in part names", source="Fig. 2")
    side: Side = choice("side of the guide on which it stands, at x = -L or +L", source="Fig. 2")


class Cable(Block):
    """A cable from an input pulley over the guide to the drum."""

    name: Slug = choice("name, used in part names", source="Fig. 2")
    input: Slug = choice("the input pulley it is anchored on", source="Table 2")
    step: Integer = choice("step of guide and drum it runs on, 1 the smallest", source="Table 2", ge=1, le=4)
    drum_side: Side = choice("where it runs on the drum from the transfer point", source="Fig. 2")
    preload_N: Number | None = quantity(
        "preload of this cable alone, in place of the rope's",
        unit="N",
        uncertain=True,
        source="section 5.3",
        default=None,
        ge=0.1,
        le=20000.0,
    )


class Rope(Block):
    """The rope of all cables: a catalogue type, or all values inline."""

    type: EntryName | None = choice(
        "catalogue rope; leave out when inline is given", source="Table 1", reference="FF-081", default=None
    )
    inline: RopeEntry | None = choice(
        "a rope written out in place of type, with all fields of a catalogue rope",
        source="-",
        example={**package_entries("ropes")["FF-081"], "source": "where these figures come from"},
        default=None,
    )
    modulus_GPa: Number | None = quantity(
        "effective modulus in place of the catalogue's",
        unit="GPa",
        uncertain=True,
        source="calibrated: 0.33 mrad at 70 N and 0.91 N m read as the swing at a reversal; the paper prints no E",
        reference=54.0,
        default=None,
        ge=1.0,
        le=250.0,
    )
    modulus_area: Literal["metallic", "nominal"] | None = choice(
        "area that modulus_GPa refers to: metallic (the wires) or nominal (pi d^2 / 4)",
        source="goes with modulus_GPa",
        reference="metallic",
        default=None,
    )
    friction_coefficient: Number = quantity(
        "rope on pulley, mu", unit="-", uncertain=True, source="section 4.2", reference=0.15, ge=0.01, le=1.0
    )
    preload_N: Number = quantity(
        "tension of each cable with the drum centred and unloaded",
        unit="N",
        uncertain=True,
        source="section 5.3",
        reference=70.0,
        ge=0.1,
        le=20000.0,
    )
    helix_lead_mm: Number = quantity(
        "axial advance per turn on the input pulley, above the rope's diameter",
        unit="mm",
        source=f"{DERIVED}: 0.860 to 0.884 clears itself and keeps the fleet angle",
        reference=0.87,
        ge=0.2,
        le=10.0,
    )
    dead_turns: Number = quantity(
        "turns that stay on the input pulley at the unwound end",
        unit="-",
        source=ESTIMATE,
        reference=1.0,
        ge=0.0,
        le=10.0,
    )


class Clearances(Block):
    """Gaps between finished surfaces."""

    transfer_gap_mm: Number = quantity(
        "guide step 1 surface to the drum's inner face; under half a rope, so that none slips in",
        unit="mm",
        source=DERIVED,
        reference=0.155,
        ge=0.01,
        le=5.0,
    )
    land_edge_mm: Number = quantity(
        "edge of a drum land to the next cable's contact line",
        unit="mm",
        source=DERIVED,
        reference=0.15,
        ge=0.0,
        le=5.0,
    )
    running_mm: Number = quantity(
        "any moving solid to any fixed one, elsewhere", unit="mm", source=ESTIMATE, reference=0.25, ge=0.01, le=5.0
    )


class DriveTrain(Block):
    """Motor, gearhead and encoders, from the catalogue."""

    motor: EntryName = choice("motor of each input", source="section 4.1", reference="motor-2.9mNm-15")
    gearhead: EntryName = choice("gearhead of each input", source="section 4.1", reference="gearhead-76-16")
    encoder: EntryName = choice(
        "encoder on each input pulley, above the top plate", source="section 5", reference="encoder-17"
    )
    drum_encoder: EntryName = choice("encoder on the drum shaft", source="section 4.1", reference="encoder-24-ring")


class Drum(Block):
    """Drum sector with web, hub and tensioners; y is along the drum axis from the guide's axis."""

    material: EntryName = choice("material of the sector", source=ESTIMATE, reference="aluminium-7075")
    sector_half_angle_deg: Number = quantity(
        "half angle of the sector, from the transfer point",
        unit="deg",
        source="derived from the 126 mm box: 77.1 to 79.2",
        reference=78.1,
        ge=20.0,
        le=175.0,
    )
    rim_inner_radius_mm: Number = quantity(
        "inner radius of the rim that carries the lands", unit="mm", source=ESTIMATE, reference=47.0, ge=2.0, le=500.0
    )
    outer_face_y_mm: Number = quantity(
        "outer face of the rim", unit="mm", source=ESTIMATE, reference=13.0, ge=0.0, le=200.0
    )
    web_thickness_mm: Number = quantity(
        "web between rim and hub", unit="mm", source=ESTIMATE, reference=2.0, ge=0.3, le=50.0
    )
    hub_diameter_mm: Number = quantity(
        "hub outside diameter", unit="mm", source=ESTIMATE, reference=20.0, ge=2.0, le=200.0
    )
    hub_face_y_mm: Number = quantity(
        "face of the hub, where the output is taken",
        unit="mm",
        source="derived from the 34.8 mm box",
        reference=20.8,
        ge=0.0,
        le=300.0,
    )
    bearing: EntryName = choice("both bearings of the drum shaft", source=ESTIMATE, reference="618/8")
    shaft_bore_mm: Number = quantity(
        "bore of the drum shaft, 0 for a solid one", unit="mm", source=ESTIMATE, reference=4.0, ge=0.0, le=100.0
    )
    shaft_material: EntryName = choice("material of the drum shaft", source=ESTIMATE, reference="steel")
    tensioner: EntryName = choice("tensioner of each cable", source="section 4.1: turnbuckles", reference="M1.6")


class Guide(Block):
    """Guide pulley, an idler on a fixed axle."""

    material: EntryName = choice("material of the pulley", source=ESTIMATE, reference="aluminium-7075")
    bearing: EntryName = choice("both bearings inside the pulley", source=ESTIMATE, reference="618/4")
    axle_material: EntryName = choice("material of the axle", source=ESTIMATE, reference="steel")


class InputPulleys(Block):
    """Input pulleys, carried by a bearing at both ends."""

    material: EntryName = choice("material of both pulleys", source=ESTIMATE, reference="steel")
    lower_bearing: EntryName = choice("bearing towards the gearhead", source=ESTIMATE, reference="618/5")
    upper_bearing: EntryName = choice("bearing in the top plate", source=ESTIMATE, reference="618/4")


class Support(Block):
    """Frame: back plate, side walls, shelves, ribs and the separate top plate."""

    material: EntryName = choice("material of frame and top plate", source=ESTIMATE, reference="aluminium-7075")
    back_y_mm: Number = quantity(
        "outer face of the back plate",
        unit="mm",
        source="derived from the 34.8 mm box",
        reference=-14.0,
        ge=-200.0,
        le=-1.0,
    )
    back_plate_mm: Number = quantity(
        "back plate thickness", unit="mm", source="held by limits.frame_windup_max_mrad", reference=5.0, ge=0.3, le=50.0
    )
    side_wall_mm: Number = quantity(
        "side wall thickness",
        unit="mm",
        source="heads of the top plate's screws, with walls",
        reference=5.8,
        ge=0.3,
        le=50.0,
    )
    motor_shelf_mm: Number = quantity(
        "shelf that carries the gearheads",
        unit="mm",
        source="gearhead screws engage one diameter; held by limits.frame_windup_max_mrad",
        reference=4.0,
        ge=0.5,
        le=50.0,
    )
    coupling_space_mm: Number = quantity(
        "height between the shelves: coupling collar, gearhead screws and the tools for both",
        unit="mm",
        source=ESTIMATE,
        reference=9.6,
        ge=2.0,
        le=100.0,
    )
    bearing_shelf_mm: Number = quantity(
        "shelf of the input pulleys' lower bearings", unit="mm", source=ESTIMATE, reference=4.0, ge=0.5, le=50.0
    )
    top_plate_mm: Number = quantity("top plate thickness", unit="mm", source=ESTIMATE, reference=3.6, ge=0.5, le=50.0)
    rib_mm: Number = quantity(
        "rib thickness", unit="mm", source="held by limits.frame_windup_max_mrad", reference=7.0, ge=0.3, le=50.0
    )


class Loads(Block):
    """External torques on the drum that the design is judged at."""

    test_torque_Nm: Number = quantity(
        "torque of the backlash test",
        unit="N m",
        uncertain=True,
        source="section 5.3",
        reference=0.91,
        gt=0.0,
        le=1000.0,
    )
    peak_torque_Nm: Number = quantity(
        "torque the design must hold both ways",
        unit="N m",
        source="with equal preloads both directions hold 3.19 at most; section 5.1 measured 3.3, perhaps in one only",
        reference=3.15,
        gt=0.0,
        le=1000.0,
    )


class Limits(Block):
    """Limits of this design that the checks hold it against."""

    bend_ratio_min: Number = quantity(
        "smallest D/d on any pulley; the rope's own minimum is a warning",
        unit="-",
        source="Table 1",
        reference=14.8,
        ge=1.0,
        le=200.0,
    )
    fleet_angle_max_deg: Number = quantity(
        "largest fleet angle on a smooth pulley",
        unit="deg",
        source="usual limit for smooth drums",
        reference=1.5,
        gt=0.0,
        le=20.0,
    )
    tension_safety_factor: Number = quantity(
        "breaking load over largest tension", unit="-", source="rope makers: 5 to 10", reference=5.0, ge=1.0, le=100.0
    )
    preload_share_max: Number = quantity(
        "preload over breaking load", unit="-", source="rope makers: under half", reference=0.5, gt=0.0, le=1.0
    )
    frame_windup_max_mrad: Number = quantity(
        "turning of the drum by the frame's deflection at the test torque",
        unit="mrad",
        source="a choice: a seventh of the cables' own turn there, 0.162 mrad",
        reference=0.0232,
        gt=0.0,
        le=100.0,
    )


class Targets(Block):
    """What mass and box should come to."""

    mass_g: Number = quantity("mass of the whole", unit="g", source="section 4.1", reference=350.0, gt=0.0, le=1e6)
    mass_tolerance_g: Number = quantity(
        "how far it may differ", unit="g", source="project goal", reference=10.0, gt=0.0, le=1e6
    )
    prototype_mass_g: Number = quantity(
        "measured mass of the prototype, for comparison", unit="g", source="section 5", reference=342.0, gt=0.0, le=1e6
    )
    envelope_mm: tuple[Radius, Radius, Radius] = quantity(
        "box with the drum centred, X, Z, Y", unit="mm", source="section 4.1", reference=[126.0, 97.0, 34.8]
    )
    envelope_tolerance_mm: Number = quantity(
        "how far each side may differ", unit="mm", source="project goal", reference=0.5, gt=0.0, le=100.0
    )


class Export(Block):
    """Settings of the files written."""

    mesh_tolerance_mm: Number = quantity(
        "largest distance of a mesh from its surface",
        unit="mm",
        source="project goal",
        reference=0.01,
        ge=0.001,
        le=1.0,
    )


class Waiver(Block):
    """A check that may fail, with the reason, which the report prints."""

    check: CheckId = choice("id of the check", source="-")
    reason: Text = choice("why it is accepted", source="-")


class AsBuiltValue(Block):
    """One figure of an effect that was found on the built drive, in the SI unit that its name ends in."""

    name: EntryName = choice("name of the figure", source="-")
    value: Number = choice("what was found", source="-", ge=-1e6, le=1e6)
    low: Number | None = choice("lower end of its 95 % interval", source="-", default=None, ge=-1e6, le=1e6)
    high: Number | None = choice("upper end of its 95 % interval", source="-", default=None, ge=-1e6, le=1e6)


class AsBuilt(Block):
    """An effect that the built drive was found to have, written by 'mbcdm loop --apply'."""

    name: Slug = choice("name of the effect, as in docs/loop.md", source="-")
    form: Text = choice("which physical form of it", source="-")
    stage: Slug | None = choice("the shaft that it sits on", source="-", default=None)
    cables: tuple[Slug, ...] = choice("the cables that have it; all where none is named", source="-", default=())
    values: tuple[AsBuiltValue, ...] = choice(
        "its figures: {name: share, value: 0.12, low: 0.11, high: 0.13}",
        source="-",
        example=[{"name": "share", "value": 0.12, "low": 0.11, "high": 0.13}],
        min_length=1,
        max_length=8,
    )
    source: Text | None = choice("the measured run that it was found in", source="-", default=None)


REFERENCE_INPUTS = [{"name": "left", "side": "-x"}, {"name": "right", "side": "+x"}]
REFERENCE_CABLES = [
    {"name": "cable_1", "input": "left", "step": 1, "drum_side": "+x"},
    {"name": "cable_2", "input": "left", "step": 2, "drum_side": "-x"},
    {"name": "cable_3", "input": "right", "step": 3, "drum_side": "-x"},
    {"name": "cable_4", "input": "right", "step": 4, "drum_side": "+x"},
]


class Design(Block):
    """A cable drive."""

    schema_version: Annotated[Integer, Field(ge=1, le=1)] = choice(
        "version of this file's layout", source="-", reference=1
    )
    name: Slug = choice("name of the design and of its output folder: a-z, 0-9, _ and -", source="-", reference="mbcdm")
    configuration: Literal["miso_bevel"] = choice(
        "layout: miso_bevel is (d) of Fig. 1, two inputs and a bevel transfer", source="Fig. 1", reference="miso_bevel"
    )
    travel: Travel
    transmission: Transmission
    inputs: tuple[Input, ...] = choice(
        "input pulleys, one on each side", source="Fig. 2", reference=REFERENCE_INPUTS, min_length=1, max_length=8
    )
    cables: tuple[Cable, ...] = choice(
        "cables: which input each runs from and which way round the drum; preload_N may be given for each",
        source="Table 2 and Fig. 2",
        reference=REFERENCE_CABLES,
        min_length=1,
        max_length=16,
    )
    rope: Rope
    clearances: Clearances
    drive: DriveTrain
    drum: Drum
    guide: Guide
    input_pulleys: InputPulleys
    support: Support
    loads: Loads
    limits: Limits
    targets: Targets
    export: Export
    waivers: tuple[Waiver, ...] = choice(
        "checks that may fail: {check: ID, reason: WHY}", source="-", reference=[], default=(), max_length=64
    )
    as_built: tuple[AsBuilt, ...] = choice(
        "effects that the built drive was found to have, written by 'mbcdm loop --apply'",
        source="-",
        reference=[],
        default=(),
        max_length=32,
    )
    catalogue: OwnEntries = Field(
        default=OwnEntries.model_construct(),
        description="entries of this design's own, by kind and name; they override the package's",
        json_schema_extra={"unit": "-", "source": "-", "examples": [{}], "in_reference": True},
    )
