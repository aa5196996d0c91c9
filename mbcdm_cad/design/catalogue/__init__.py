"""The package's catalogue: one JSON file per kind of bought-out part, and materials; the class of each kind.

JSON, because every start of the program reads several files, and JSON is parsed ten times as fast as YAML. Entries are
validated when they are looked up; a test validates them all."""

import json
from collections.abc import Callable, Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, get_args

from pydantic import Field

from mbcdm_cad.design import bought
from mbcdm_cad.design.fields import Block, EntryName

FOLDER = Path(__file__).parent


@cache
def package_entries(kind: str) -> dict[str, dict[str, Any]]:
    """The entries of one kind (a key of ``entries.KINDS``) by name, as plain data; do not change them."""
    with open(FOLDER / f"{kind}.json", encoding="utf-8") as file:
        entries: dict[str, dict[str, Any]] = json.load(file)
    return entries


def smallest_entry(kind: str, size: str, fits: Callable[[dict[str, Any]], bool]) -> str | None:
    """Name of the package's entry of a kind that has the least of the field ``size`` among those that fit."""
    found = [(entry[size], name) for name, entry in package_entries(kind).items() if fits(entry)]
    return min(found)[1] if found else None


class OwnEntries(Block):
    """Entries of the design's own, by kind and name; a name of the package's catalogue is overridden."""

    ropes: dict[EntryName, bought.CableSpec] = Field(default={}, max_length=64, description="ropes by name")
    terminations: dict[EntryName, bought.TerminationSpec] = Field(
        default={}, max_length=64, description="ways of ending a rope by name"
    )
    motors: dict[EntryName, bought.Motor] = Field(default={}, max_length=64, description="motors by name")
    gearheads: dict[EntryName, bought.Gearhead] = Field(default={}, max_length=64, description="gearheads by name")
    encoders: dict[EntryName, bought.Encoder] = Field(default={}, max_length=64, description="encoders by name")
    bearings: dict[EntryName, bought.Bearing] = Field(default={}, max_length=64, description="bearings by name")
    screws: dict[EntryName, bought.Screw] = Field(default={}, max_length=64, description="screws by name")
    inserts: dict[EntryName, bought.InsertSpec] = Field(
        default={}, max_length=64, description="heat-set inserts by name"
    )
    tensioners: dict[EntryName, bought.TensionerSpec] = Field(
        default={}, max_length=64, description="tensioners by name"
    )
    springs: dict[EntryName, bought.SpringSpec] = Field(
        default={}, max_length=64, description="springs of terminals by name"
    )
    materials: dict[EntryName, bought.Material] = Field(default={}, max_length=64, description="materials by name")


# The class of the entries of each kind.
KINDS: dict[str, type[bought.Entry]] = {
    kind: get_args(field.annotation)[1] for kind, field in OwnEntries.model_fields.items()
}


# What gives torque and speed of any motor; currents and pairs of poles go with a brushless one.
ELECTRICAL_FIELDS = ("torque_constant_mNm_A", "resistance_ohm", "voltage_V")
BRUSHLESS_FIELDS = ("continuous_current_A", "peak_current_A", "pole_pairs")
# The rated torque is lower than constant x current because of friction and saturation of the iron.
TORQUE_AGREEMENT = 0.25

_ORDERS: dict[type[bought.Entry], tuple[tuple[str, ...], ...]] = {
    bought.CableSpec: (("bend_ratio_minimum", "bend_ratio_desired"),),
    bought.TerminationSpec: (("smallest_mm", "largest_mm"),),
    bought.Gearhead: (
        ("rated_torque_mNm", "max_torque_mNm"),
        ("shaft_diameter_mm", "pilot_diameter_mm", "bolt_circle_mm", "diameter_mm"),
    ),
    bought.Motor: (
        ("continuous_current_A", "peak_current_A"),
        ("shaft_diameter_mm", "pilot_diameter_mm", "bolt_circle_mm", "diameter_mm"),
    ),
    bought.Encoder: (("bore_mm", "bolt_circle_mm", "diameter_mm"),),
    bought.Bearing: (("bore_mm", "inner_shoulder_mm", "outer_shoulder_mm", "outer_diameter_mm"),),
    bought.Screw: (("tap_drill_mm", "thread_mm", "clearance_mm"),),
    bought.InsertSpec: (("thread_mm", "hole_mm", "outside_mm"),),
    bought.SpringSpec: (("strip_mm", "solid_mm", "free_mm"), ("inside_mm", "outside_mm")),
    bought.TensionerSpec: (("thread_mm", "clearance_mm", "nut_across_flats_mm"),),
}


def entry_faults(entry: bought.Entry) -> Iterator[tuple[str, str, str, str, str]]:
    """Contradictions within one entry: field, problem, value, limit, remedy."""
    for names in entry_orders(entry):
        for small, large in pairwise(names):
            low, high = getattr(entry, small), getattr(entry, large)
            if low is not None and high is not None and low > high:
                yield small, f"larger than {large}", f"{low:g}", f"up to {high:g}", f"check {small} and {large}"
    if isinstance(entry, bought.Motor):
        yield from _motor_faults(entry)
    if isinstance(entry, bought.CableSpec):
        nominal = 0.7854 * entry.diameter_mm**2
        if entry.metallic_area_mm2 > nominal:
            yield (
                "metallic_area_mm2",
                "larger than the rope's own circle",
                f"{entry.metallic_area_mm2:g} mm2",
                f"up to {nominal:.4g} mm2",
                "a 7x7 rope has about 0.475 d^2",
            )


def _motor_faults(entry: bought.Motor) -> Iterator[tuple[str, str, str, str, str]]:
    """Problems if electrical values are incomplete, or if continuous torque and current contradict each other."""
    brushless = [name for name in BRUSHLESS_FIELDS if getattr(entry, name) is not None]
    asked = (*ELECTRICAL_FIELDS, *(BRUSHLESS_FIELDS if brushless else ()))
    given = [name for name in (*asked, "no_load_current_A") if getattr(entry, name) is not None]
    missing = [name for name in asked if getattr(entry, name) is None]
    if missing and given:
        yield given[0], "given without all that goes with it", "", ", ".join(missing), "give all of them, or none"
    constant, current = entry.torque_constant_mNm_A, entry.continuous_current_A
    if constant is None or current is None:
        return
    torque = constant * current
    if abs(entry.rated_torque_mNm / torque - 1.0) > TORQUE_AGREEMENT:
        yield (
            "rated_torque_mNm",
            "not what the continuous current gives",
            f"{entry.rated_torque_mNm:g} mN m",
            f"within {TORQUE_AGREEMENT:.0%} of {torque:.4g} mN m, torque constant x current",
            "check torque_constant_mNm_A and continuous_current_A: both between two terminals",
        )


def entry_orders(entry: bought.Entry) -> tuple[tuple[str, ...], ...]:
    """Fields of a catalogue entry that must not decrease in this order."""
    return _ORDERS.get(type(entry), ())
