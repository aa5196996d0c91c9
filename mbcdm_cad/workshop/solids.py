"""Parts and the assembly as cadquery objects, for scripts and notebooks."""

import cadquery as cq

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.workshop.kernel import location
from mbcdm_cad.workshop.store import drawn


def part_names(drive: Drive) -> tuple[str, ...]:
    """Names of all parts, as their files have them. Raises ``MbcdmError`` where the dimensions have no solution."""
    return tuple(_bill(drive).parts)


def part_solid(drive: Drive, name: str) -> cq.Solid:
    """One part in its own frame, in mm. Raises ``MbcdmError`` for a name that no part has."""
    parts = _bill(drive).parts
    if name not in parts:
        raise MbcdmError(f"{name}: no such part; {did_you_mean(name, parts)}")
    solid: cq.Solid = parts[name].part.solid()
    return solid


def assembled(drive: Drive, angle_deg: float) -> cq.Assembly:
    """All parts in their places with the drum at ``angle_deg``, a sub-assembly for each group that moves together.

    Parts come from the cache if it has them. Raises ``MbcdmError`` for an angle beyond the travel.
    """
    items, parts = drawn(drive, angle_deg, Cache(cache_folder()), lambda name: None)
    shapes = {name: cq.Shape.cast(part.solid()) for name, part in parts.items()}
    # cadquery requires names that are unique in the whole tree, but the drum is a part in a group of the same name.
    groups = {item.group: cq.Assembly(name=f"{item.group}_group") for item in items}
    for item in items:
        place = cq.Location(location(item.location))
        groups[item.group].add(shapes[item.part], loc=place, name=item.name, color=cq.Color(*item.material.colour, 1.0))
    whole = cq.Assembly(name=f"{drive.name}_assembly")
    for group in groups.values():
        whole.add(group)
    return whole


def _bill(drive: Drive):  # type: ignore[no-untyped-def]  # a configuration's own class
    try:
        return layout_of(drive).bill()
    except NoFigureError as error:
        raise MbcdmError(f"{drive.name}: {error}; 'mbcdm check' says more") from None
