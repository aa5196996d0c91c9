"""What making costs: tolerances of the parts, from the fits and the design's block ``making``, and prices.

The price of a drive is that of the material of its made parts and of the parts that are bought, by the catalogue.
"""

import re
from collections.abc import Callable
from dataclasses import replace
from math import sqrt
from typing import Literal

from mbcdm_cad.design.blocks import Making
from mbcdm_cad.design.bought import CableSpec, Entry, Material
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.model.tolerance import Tolerances
from mbcdm_cad.parts.bill import CABLE, Bill, Item
from mbcdm_cad.parts.fits import FITS, radius_band_mm
from mbcdm_cad.parts.sheet import Linear, Sheet, Table, mm3

# What has a material of its own; passed: the body that cables pass on the way to the drum, where there is one.
Body = Literal["drum", "passed", "pulley", "frame"]

# Axial over radial play of a deep-groove bearing (bearing makers: 8 to 15, the closer the osculation the less).
AXIAL_OVER_RADIAL = 10.0
# Error of a preload set by hand, over the preload (estimate).
PRELOAD_SHARE = 0.05
# Run-out and place, plus or minus, that a printer holds, mm (estimate: printing services state 0.1 to 0.3).
PRINTED_MM = 0.1


def _printed(drive: Drive, body: Body) -> bool:
    found: Material | None = getattr(drive, f"{body}_material", None)
    return found is not None and found.printed


def accuracy(making: Making, printed: bool) -> Making:
    """The design's ``making`` for one part: run-out and place of a printed one are not below what a printer holds."""
    if not printed:
        return making
    run_out, place = (max(value, PRINTED_MM) for value in (making.run_out_mm, making.position_mm))
    return replace(making, run_out_mm=run_out, position_mm=place)


def body_accuracy(drive: Drive, body: Body) -> Making:
    """:func:`accuracy` of one body."""
    return accuracy(drive.making, _printed(drive, body))


def sheet_as_printed(sheet: Sheet, making: Making) -> Sheet:
    """The sheet of a printed part: what a printer holds, with bores and journals cut after printing to their fits.

    Lands have the printer's class, frames the run-out and place of ``making`` as :func:`accuracy` gives it for a
    printed part; roughnesses are left out.
    """
    turned, printed = FITS["land"].code, FITS["printed_land"].code

    def fit(code: str) -> str:
        return printed if code == turned else code

    def rows(table: Table) -> Table:
        return replace(table, rows=tuple(tuple(map(fit, row)) for row in table.rows))

    place, codes = mm3(making.position_mm), {fit(line.code) for line in sheet.fits} - {""}
    notes = [re.sub(r"within 0\.02", f"within {place}", _as_printed(note)) for note in sheet.notes]
    made = ["Printed."]
    if printed in codes:
        made.append("Lands as printed.")
    if any(code[0].isupper() for code in codes):
        made.append("Bores with a fit are printed smaller, then reamed or bored to it.")
    if any(code[0].islower() for code in codes - {printed}):
        made.append("Journals are printed larger, then turned to their fit.")
    return replace(
        sheet,
        dimensions=tuple(replace(d, fit=fit(d.fit)) if isinstance(d, Linear) else d for d in sheet.dimensions),
        tolerances=tuple(
            replace(t, value_mm=making.run_out_mm if t.characteristic == "run-out" else making.position_mm)
            for t in sheet.tolerances
        ),
        tables=tuple(map(rows, sheet.tables)),
        fits=tuple(replace(line, code=fit(line.code)) for line in sheet.fits),
        notes=(*filter(None, notes), " ".join(made)),
    )


def _as_printed(note: str) -> str:
    """The note without what it says of roughness and milling."""
    kept = []
    note = note.replace("Milled from one block.", "One piece.")
    for sentence in re.split(r"(?<=\.) (?=[A-Z+(])", note):
        if not re.search(r"\bRa \d", sentence):
            kept.append(sentence)
        elif rest := [
            part for part in re.split(r"[,;] ", sentence.rstrip(".")) if not re.search(r"\bRa \d|ground", part)
        ]:
            kept.append(", ".join(rest)[:1].upper() + ", ".join(rest)[1:] + ".")
    return " ".join(kept)


def rope_band_mm(drive: Drive) -> float:
    """Plus or minus on the rope's diameter."""
    return drive.making.rope_diameter_share * drive.cable.diameter_mm


def land_band_mm(drive: Drive, pitch_radius_mm: float, body: Body) -> float:
    """Plus or minus on the radius of the surface of a body that carries a cable at ``pitch_radius_mm``."""
    role = "printed_land" if _printed(drive, body) else "land"
    return radius_band_mm(pitch_radius_mm - drive.cable.diameter_mm / 2, role)


def axial_play_mm(drive: Drive) -> float:
    """Axial play of a bearing that carries no preload, from one side to the other."""
    return AXIAL_OVER_RADIAL * drive.making.bearing_play_mm


def model_tolerances(drive: Drive) -> Tolerances:
    """Standard deviations for the transmission error, of parts that lie anywhere within their tolerances.

    A point anywhere in a disc of radius e has e/2 in each component, a size anywhere in +-t has t/sqrt(3).
    """

    def eccentricity_m(body: Body) -> float:
        return body_accuracy(drive, body).run_out_mm / 4.0 * 1e-3

    drum = max(land_band_mm(drive, c.drum_radius_mm, "drum") for c in drive.cables) / sqrt(3.0) * 1e-3
    pulley = max(land_band_mm(drive, c.input_radius_mm, "pulley") for c in drive.cables) / sqrt(3.0) * 1e-3
    preload = PRELOAD_SHARE * sum(c.preload_N for c in drive.cables) / len(drive.cables)
    return Tolerances(
        drum_eccentricity_m=eccentricity_m("drum"),
        passed_eccentricity_m=eccentricity_m("passed"),
        input_eccentricity_m=eccentricity_m("pulley"),
        drum_radius_m=drum,
        input_radius_m=pulley,
        preload_N=preload,
    )


class NoPriceError(Exception):
    """Raised where entries have no price; the text names them."""


def material_cost_EUR(bill: Bill) -> float:
    """Material in the made parts, waste and work left out. Raises :class:`NoPriceError`."""

    def cost(item: Item) -> float:
        return bill.volumes_mm3[item.part] * item.material.density_g_cm3 * 1e-6 * _price_EUR(item.material)

    return _sum([item for item in bill.items if item.part in bill.volumes_mm3], cost)


def bought_cost_EUR(bill: Bill, rope: CableSpec) -> float:
    """Bought parts that have an entry in the catalogue, and the rope; dowels and springs have none and count nothing.

    Raises :class:`NoPriceError`.
    """

    def cost(item: Item) -> float:
        if item.name.startswith(CABLE):
            return (item.mass_g or 0.0) / rope.mass_g_m * _price_EUR(rope)
        entry = getattr(bill.parts[item.part].part, "entry", None)
        return _price_EUR(entry) if isinstance(entry, Entry) else 0.0

    return _sum([item for item in bill.items if item.kind == "bought"], cost)


def _sum(items: list[Item], cost: Callable[[Item], float]) -> float:
    """The sum over all items. Raises :class:`NoPriceError` with every entry that has no price."""
    found, missing = 0.0, dict[str, None]()
    for item in items:
        try:
            found += cost(item)
        except NoPriceError as error:
            missing[str(error)] = None
    if missing:
        raise NoPriceError(f"no price_EUR in the catalogue for {', '.join(missing)}; give entries of your own with one")
    return found


def _price_EUR(entry: Entry) -> float:
    if entry.price_EUR is None:
        raise NoPriceError(entry.name)
    return entry.price_EUR
