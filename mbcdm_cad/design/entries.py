"""Schema of the catalogue: one class per kind of entry, the same for the package's data files and a design's own.

Field names and meaning follow the dataclasses of :mod:`mbcdm_cad.design.drive`, to which entries are converted.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from mbcdm_cad.design.fields import Block, EntryName, Integer, Number, Text


def _field(meaning: str, unit: str, uncertain: bool = False, **bounds: Any) -> Any:
    extra: dict[str, Any] = {"unit": unit} | ({"uncertain": True} if uncertain else {})
    return Field(..., description=meaning, json_schema_extra=extra, **bounds)


def _maybe(meaning: str, unit: str, **bounds: Any) -> Any:
    """A field that an entry may leave out."""
    return Field(None, description=meaning, json_schema_extra={"unit": unit}, **bounds)


def _with_default(default: float, meaning: str, unit: str, **bounds: Any) -> Any:
    """A figure that an entry may leave out, with the value it then has."""
    return Field(default, description=meaning, json_schema_extra={"unit": unit}, **bounds)


class Entry(Block):
    """Anything in the catalogue."""

    source: Text = _field("source of the values; says 'estimate' for a value that is estimated", "-")


class RopeEntry(Entry):
    """A rope. Its modulus always comes with the area to which it refers."""

    construction: Literal["7x7", "7x19", "1x19", "braid"] = _field("strands x wires, or braid for fibre", "-")
    diameter_mm: Number = _field("nominal diameter", "mm", uncertain=True, ge=0.2, le=5.0)
    metallic_area_mm2: Number = _field("cross-section of all wires or fibres", "mm2", uncertain=True, gt=0.0, le=20.0)
    modulus_GPa: Number = _field("effective tensile modulus of the rope", "GPa", uncertain=True, ge=1.0, le=250.0)
    modulus_area: Literal["metallic", "nominal"] = _field("area the modulus refers to: wires, or pi d^2 / 4", "-")
    breaking_load_N: Number = _field("minimum breaking load", "N", ge=10.0, le=50000.0)
    mass_g_m: Number = _field("mass per length", "g/m", gt=0.0, le=200.0)
    bedding_in_share: Number = Field(
        0.003,
        description="permanent stretch in the first runs under load, over the length (constructional stretch)",
        json_schema_extra={"unit": "-"},
        ge=0.0,
        le=0.05,
    )
    creep_per_decade: Number = _with_default(
        0.0, "strain a decade of time, extrapolated to the breaking load; none for wire", "-", ge=0.0, le=0.1
    )
    creep_per_year: Number = _with_default(
        0.0, "steady strain a year at 0.3 of the breaking load and 20 degrees C", "-", ge=0.0, le=1.0
    )
    creep_load_exponent: Number = _with_default(1.0, "power of the load in the steady creep", "-", ge=1.0, le=20.0)
    creep_activation_kJ_mol: Number = _with_default(
        0.0, "activation energy of the steady creep", "kJ/mol", ge=0.0, le=500.0
    )
    bend_ratio_minimum: Number = _field("smallest D/d that the maker allows", "-", ge=1.0, le=200.0)
    bend_ratio_desired: Number = _field("D/d that the maker recommends", "-", ge=1.0, le=200.0)
    material: EntryName = _field("material of the wires", "-")


class TerminationEntry(Entry):
    """A way to make the ends of a rope: a terminal's sleeve at one end, a stop at the other."""

    constructions: tuple[Literal["7x7", "7x19", "1x19", "braid"], ...] = _field(
        "constructions of rope for which it is made", "-", min_length=1, max_length=4
    )
    smallest_mm: Number = _field("thinnest rope for which it is made", "mm", ge=0.1, le=20.0)
    largest_mm: Number = _field("thickest rope for which it is made", "mm", ge=0.1, le=20.0)
    strength_share: Number = _field("strength of the end divided by the rope's breaking load", "-", gt=0.0, le=1.0)
    sleeve_ratio: Number = _field(
        "smallest diameter of the terminal's sleeve divided by the rope's", "-", ge=1.1, le=10.0
    )
    grip_ratio: Number = _field(
        "smallest length of rope in the sleeve divided by the rope's diameter", "-", ge=0.5, le=30.0
    )
    stop_radius_ratio: Number = _field("radius of the stop over the rope's diameter", "-", ge=0.6, le=5.0)
    stop_length_ratio: Number = _field("length of the stop over the rope's diameter", "-", ge=0.5, le=20.0)


class MotorEntry(Entry):
    """A motor. A motor with a shaft and a mounting face can be used without a gearhead.

    Torque constant and resistance are those between two terminals (60 / (2 pi Kv), phase to phase).
    """

    diameter_mm: Number = _field("body diameter", "mm", ge=3.0, le=400.0)
    length_mm: Number = _field("body length", "mm", ge=3.0, le=300.0)
    rated_torque_mNm: Number = _field("continuous torque", "mN m", uncertain=True, gt=0.0, le=100000.0)
    rotor_inertia_g_cm2: Number = _field("rotor inertia", "g cm2", gt=0.0, le=1e6)
    mass_g: Number = _field("mass", "g", gt=0.0, le=50000.0)
    torque_constant_mNm_A: Number | None = _maybe("torque over current, 60 / (2 pi Kv)", "mN m/A", gt=0.0, le=1e5)
    resistance_ohm: Number | None = _maybe("resistance between two terminals", "ohm", gt=0.0, le=1000.0)
    continuous_current_A: Number | None = _maybe("continuous current", "A", gt=0.0, le=1000.0)
    peak_current_A: Number | None = _maybe("largest current for a short time", "A", gt=0.0, le=5000.0)
    voltage_V: Number | None = _maybe("voltage that the motor is made for", "V", gt=0.0, le=1000.0)
    pole_pairs: Integer | None = _maybe("pairs of magnet poles", "-", ge=1, le=100)
    radial_load_N: Number | None = _maybe("radial load that the shaft can take", "N", gt=0.0, le=10000.0)
    shaft_diameter_mm: Number | None = _maybe("shaft diameter", "mm", ge=1.0, le=40.0)
    shaft_length_mm: Number | None = _maybe("shaft length from the face", "mm", ge=1.0, le=80.0)
    pilot_diameter_mm: Number | None = _maybe("centring boss diameter", "mm", ge=1.0, le=200.0)
    pilot_height_mm: Number | None = _maybe("centring boss height", "mm", ge=0.1, le=10.0)
    bolt_circle_mm: Number | None = _maybe("diameter of the screws' circle on the face", "mm", ge=2.0, le=300.0)
    screw: EntryName | None = _maybe("screw that holds it at the face", "-")
    screw_count: Integer | None = _maybe("number of those screws", "-", ge=2, le=12)


class GearheadEntry(Entry):
    """A gearhead: body, output shaft and face pattern."""

    ratio: Number = _field("reduction", "-", ge=1.0, le=10000.0)
    efficiency: Number = _field("efficiency at rated torque", "-", gt=0.0, le=1.0)
    rated_torque_mNm: Number = _field("continuous output torque", "mN m", gt=0.0, le=1e6)
    max_torque_mNm: Number = _field("intermittent output torque", "mN m", gt=0.0, le=1e6)
    radial_load_N: Number = _field("radial load that the output shaft can take", "N", gt=0.0, le=10000.0)
    diameter_mm: Number = _field("body diameter", "mm", ge=3.0, le=100.0)
    length_mm: Number = _field("body length", "mm", ge=3.0, le=200.0)
    shaft_diameter_mm: Number = _field("output shaft diameter", "mm", ge=1.0, le=20.0)
    shaft_length_mm: Number = _field("output shaft length from the face", "mm", ge=1.0, le=60.0)
    pilot_diameter_mm: Number = _field("centring boss diameter", "mm", ge=1.0, le=60.0)
    pilot_height_mm: Number = _field("centring boss height", "mm", ge=0.1, le=10.0)
    bolt_circle_mm: Number = _field("diameter of the screws' circle on the face", "mm", ge=2.0, le=90.0)
    screw: EntryName = _field("screw that holds it at the face", "-")
    screw_count: Integer = _field("number of those screws", "-", ge=1, le=12)
    mass_g: Number = _field("mass", "g", gt=0.0, le=5000.0)


class EncoderEntry(Entry):
    """An encoder housing on a shaft."""

    resolution_urad: Number = _field("resolution", "urad", gt=0.0, le=100000.0)
    diameter_mm: Number = _field("housing diameter", "mm", ge=3.0, le=100.0)
    length_mm: Number = _field("housing length", "mm", ge=1.0, le=100.0)
    bore_mm: Number = _field("bore of the hub", "mm", ge=0.5, le=60.0)
    bolt_circle_mm: Number = _field("diameter of the screws' circle", "mm", ge=2.0, le=90.0)
    screw: EntryName = _field("screw that holds the housing", "-")
    screw_count: Integer = _field("number of those screws", "-", ge=1, le=12)
    mass_g: Number = _field("mass", "g", gt=0.0, le=1000.0)


class BearingEntry(Entry):
    """A deep-groove ball bearing."""

    bore_mm: Number = _field("bore d", "mm", ge=1.0, le=60.0)
    outer_diameter_mm: Number = _field("outside diameter D", "mm", ge=2.0, le=100.0)
    width_mm: Number = _field("width B", "mm", ge=0.5, le=30.0)
    inner_shoulder_mm: Number = _field("shoulder diameter d_a at the inner ring", "mm", ge=1.0, le=100.0)
    outer_shoulder_mm: Number = _field("shoulder diameter D_a at the outer ring", "mm", ge=1.0, le=100.0)
    static_rating_N: Number = _field("static load rating C0", "N", gt=0.0, le=100000.0)
    mass_g: Number = _field("mass", "g", gt=0.0, le=2000.0)


class ScrewEntry(Entry):
    """A socket-head cap screw, or a set screw (head sizes 0)."""

    thread_mm: Number = _field("nominal thread diameter", "mm", ge=0.5, le=12.0)
    tap_drill_mm: Number = _field("tapping drill", "mm", ge=0.3, le=12.0)
    clearance_mm: Number = _field("clearance hole", "mm", ge=0.5, le=15.0)
    length_mm: Number = _field("length below the head", "mm", ge=1.0, le=100.0)
    head_diameter_mm: Number = _field("head diameter", "mm", ge=0.0, le=25.0)
    head_height_mm: Number = _field("head height", "mm", ge=0.0, le=15.0)
    key_mm: Number = _field("hexagon socket across flats", "mm", ge=0.3, le=12.0)
    mass_g: Number = _field("mass", "g", gt=0.0, le=200.0)


class InsertEntry(Entry):
    """A knurled brass bush with an inside thread, set with heat into a hole of a printed part."""

    thread_mm: Number = _field("nominal thread diameter", "mm", ge=1.0, le=12.0)
    hole_mm: Number = _field("diameter of the hole that it is set into", "mm", ge=1.0, le=20.0)
    outside_mm: Number = _field("diameter over the knurls", "mm", ge=1.0, le=20.0)
    length_mm: Number = _field("length", "mm", ge=1.0, le=40.0)
    wall_mm: Number = _field("least wall of plastic round the hole", "mm", ge=0.2, le=20.0)
    mass_g: Number = _field("mass", "g", gt=0.0, le=100.0)


class TensionerEntry(Entry):
    """A threaded terminal swaged on the cable, with nut and lock nut."""

    thread_mm: Number = _field("nominal thread diameter", "mm", ge=0.5, le=12.0)
    clearance_mm: Number = _field("clearance hole in the lug", "mm", ge=0.5, le=15.0)
    stress_area_mm2: Number = _field("tensile stress area of the thread", "mm2", gt=0.0, le=100.0)
    pitch_mm: Number = _field("pitch of the thread", "mm", gt=0.0, le=3.0)
    nut_across_flats_mm: Number = _field("nut across flats", "mm", ge=1.0, le=25.0)
    nut_height_mm: Number = _field("nut height", "mm", ge=0.3, le=15.0)
    swage_diameter_mm: Number = _field("diameter of the swaged sleeve", "mm", ge=0.5, le=20.0)
    swage_flats_mm: Number = _field(
        "across the two flats of the sleeve, which keep it from turning", "mm", ge=0.4, le=20.0
    )
    swage_length_mm: Number = _field("length of the swaged sleeve", "mm", ge=0.5, le=50.0)
    lug_thickness_mm: Number = _field("thickness of the drum's lug along the stud", "mm", ge=0.5, le=20.0)
    stud_length_mm: Number = _field(
        "length from the front of the sleeve to the end of the stud", "mm", ge=2.0, le=100.0
    )
    material: EntryName = _field("material of stud, sleeve and nuts", "-")


Fraction = Annotated[Number, Field(ge=0.0, le=1.0)]


class MaterialEntry(Entry):
    """A material and the limits of its process."""

    density_g_cm3: Number = _field("density", "g/cm3", ge=0.1, le=25.0)
    youngs_modulus_GPa: Number = _field("Young's modulus", "GPa", ge=0.01, le=1000.0)
    poisson_ratio: Number = _field("Poisson's ratio", "-", ge=0.0, lt=0.5)
    yield_MPa: Number = _field("yield strength", "MPa", ge=1.0, le=5000.0)
    process: Literal["milled", "turned", "printed", "sintered", "bought"] = _field(
        "process by which parts are made; printed: from filament, sintered: from powder", "-"
    )
    min_wall_mm: Number = _field("thinnest wall that can be made", "mm", ge=0.0, le=10.0)
    min_internal_radius_mm: Number = _field("smallest internal corner radius", "mm", ge=0.0, le=10.0)
    colour: tuple[Fraction, Fraction, Fraction] = _field("linear red, green, blue", "-")


KINDS: dict[str, type[Entry]] = {
    "ropes": RopeEntry,
    "terminations": TerminationEntry,
    "motors": MotorEntry,
    "gearheads": GearheadEntry,
    "encoders": EncoderEntry,
    "bearings": BearingEntry,
    "screws": ScrewEntry,
    "inserts": InsertEntry,
    "tensioners": TensionerEntry,
    "materials": MaterialEntry,
}


class OwnEntries(Block):
    """Entries of the design's own, by kind and name; a name of the package's catalogue is overridden."""

    ropes: dict[EntryName, RopeEntry] = Field(default={}, max_length=64, description="ropes by name")
    terminations: dict[EntryName, TerminationEntry] = Field(
        default={}, max_length=64, description="ways of ending a rope by name"
    )
    motors: dict[EntryName, MotorEntry] = Field(default={}, max_length=64, description="motors by name")
    gearheads: dict[EntryName, GearheadEntry] = Field(default={}, max_length=64, description="gearheads by name")
    encoders: dict[EntryName, EncoderEntry] = Field(default={}, max_length=64, description="encoders by name")
    bearings: dict[EntryName, BearingEntry] = Field(default={}, max_length=64, description="bearings by name")
    screws: dict[EntryName, ScrewEntry] = Field(default={}, max_length=64, description="screws by name")
    inserts: dict[EntryName, InsertEntry] = Field(default={}, max_length=64, description="heat-set inserts by name")
    tensioners: dict[EntryName, TensionerEntry] = Field(default={}, max_length=64, description="tensioners by name")
    materials: dict[EntryName, MaterialEntry] = Field(default={}, max_length=64, description="materials by name")
