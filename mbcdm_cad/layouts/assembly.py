"""What the bills of layouts share, and the order of assembly, from the template ``assembly.md.j2`` of a layout.

Each line that begins with ``1.`` begins a step. Lines that begin with ``+`` name the items of the bill that join in it,
in their order: ``#`` stands for all numbers, ``@`` for each input in turn. A name that the bill does not have is an
error, so that a part that is renamed is renamed here too.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from mbcdm_cad.parts.bill import ALONG_Y, AssemblyStep, BillBuilder, Placement, cable_item
from mbcdm_cad.parts.drum_sector.items import add_preload_spring
from mbcdm_cad.parts.input_pulley.items import train_words
from mbcdm_cad.parts.turned import Pin

if TYPE_CHECKING:
    from mbcdm_cad.layouts.sector import SectorLayout


def add_drum_bearings(b: BillBuilder, lay: SectorLayout) -> None:
    """Both bearings of the drum's shaft with their spring."""
    ring, bearing, shaft = lay.drive.material("bearing-steel"), lay.drive.bearings.drum, lay.drum_shaft
    b.bearing("drum_bearing_rear", bearing, ring, Placement.translation(0.0, shaft.rear_bearing_y, 0.0) @ ALONG_Y)
    add_preload_spring(b, lay.drive, lay.preload_spring)
    b.bearing("drum_bearing_front", bearing, ring, Placement.translation(0.0, shaft.front_bearing_y, 0.0) @ ALONG_Y)


def add_stop_pin(b: BillBuilder, lay: SectorLayout, y_mm: float) -> None:
    """Pin in the frame from ``y_mm`` on, through the slot of the sector; none of a drum that turns further."""
    frame = lay.frame
    if lay.drive.stopped:
        pin = Pin(frame.stop_pin_radius, lay.drum.web_end_y + 0.5 - y_mm)
        place = Placement.translation(0.0, y_mm, frame.stop_pin_z) @ ALONG_Y
        b.add("stop_pin", pin, material=lay.drive.material("steel"), place=place)


def steps(layout: SectorLayout, **more: Any) -> tuple[AssemblyStep, ...]:
    """Steps with the sizes of this design. Raises ``LookupError`` for an item that the bill does not have."""
    drive = layout.drive
    figures = {"layout": layout, "drive": drive, "plan": layout.tensioning, **more}
    text = _render(type(layout).__module__.rpartition(".")[0])(
        figures, key=lambda screw: f"{drive.screw(screw).key_mm:g} mm key"
    )
    names = tuple(item.name for item in layout.bill().items)
    return tuple(_step(part, drive.input_names, names) for part in re.split(r"^1\. ", text, flags=re.M)[1:])


@lru_cache
def _render(package: str) -> Callable[..., str]:
    """The template of a layout's package, beside those that layouts share: text for its figures."""
    import jinja2

    loaders = [jinja2.PackageLoader(name, ".") for name in (package, __package__ or "")]
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader(loaders), undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "g": "{:g}".format,
        "each": lambda values, words, between=", ": between.join(words.format(value) for value in values),
        "cable_item": cable_item,
        "train": train_words,
    }
    return environment.get_template("assembly.md.j2").render


def _step(part: str, inputs: tuple[str, ...], names: tuple[str, ...]) -> AssemblyStep:
    words, items = list[str](), list[str]()
    for line in part.splitlines():
        if line.startswith("+ "):
            items += (item for name in line.split()[1:] for item in _named(name, inputs, names))
        elif line.strip():
            words.append(line.strip())
    return AssemblyStep(" ".join(words), tuple(items))


def _named(name: str, inputs: tuple[str, ...], names: tuple[str, ...]) -> Iterator[str]:
    for one in [name.replace("@", of) for of in inputs] if "@" in name else [name]:
        pattern = re.compile(re.escape(one).replace(r"\#", r"\d+"))
        found = [item for item in names if pattern.fullmatch(item)]
        if not found:
            raise LookupError(f"the order of assembly has {one}, which the bill has not")
        yield from found
