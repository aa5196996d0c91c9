"""Cost of a drive by the prices of the catalogue: material of the made parts, and the parts that are bought."""

from __future__ import annotations

from collections.abc import Callable

from mbcdm_cad.design.bought import CableSpec, Entry
from mbcdm_cad.parts.bill import CABLE, Bill
from mbcdm_cad.parts.item import Item


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
