"""Rules within one entry of the catalogue, the package's or a design's own."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from mbcdm_cad.design.entries import (
    BearingEntry,
    EncoderEntry,
    Entry,
    GearheadEntry,
    InsertEntry,
    RopeEntry,
    ScrewEntry,
    TensionerEntry,
    TerminationEntry,
)

_ORDERS: dict[type[Entry], tuple[tuple[str, ...], ...]] = {
    RopeEntry: (("bend_ratio_minimum", "bend_ratio_desired"),),
    TerminationEntry: (("smallest_mm", "largest_mm"),),
    GearheadEntry: (
        ("rated_torque_mNm", "max_torque_mNm"),
        ("shaft_diameter_mm", "pilot_diameter_mm", "bolt_circle_mm", "diameter_mm"),
    ),
    EncoderEntry: (("bore_mm", "bolt_circle_mm", "diameter_mm"),),
    BearingEntry: (("bore_mm", "inner_shoulder_mm", "outer_shoulder_mm", "outer_diameter_mm"),),
    ScrewEntry: (("tap_drill_mm", "thread_mm", "clearance_mm"),),
    InsertEntry: (("thread_mm", "hole_mm", "outside_mm"),),
    TensionerEntry: (("thread_mm", "clearance_mm", "nut_across_flats_mm"),),
}


def entry_faults(entry: Entry) -> Iterator[tuple[str, str, str, str, str]]:
    """What of one entry contradicts itself: field, what, value, limit, remedy."""
    for names in entry_orders(entry):
        for small, large in pairwise(names):
            low, high = getattr(entry, small), getattr(entry, large)
            if low > high:
                yield small, f"larger than {large}", f"{low:g}", f"up to {high:g}", f"check {small} and {large}"
    if isinstance(entry, RopeEntry):
        nominal = 0.7854 * entry.diameter_mm**2
        if entry.metallic_area_mm2 > nominal:
            yield (
                "metallic_area_mm2",
                "larger than the rope's own circle",
                f"{entry.metallic_area_mm2:g} mm2",
                f"up to {nominal:.4g} mm2",
                "a 7x7 rope has about 0.475 d^2",
            )


def entry_orders(entry: Entry) -> tuple[tuple[str, ...], ...]:
    """Fields of a catalogue entry that must not decrease in this order."""
    return _ORDERS.get(type(entry), ())
