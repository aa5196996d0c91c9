"""Parts made from their drawings alone: for each part a function from its drawing to its volume."""

from collections.abc import Callable
from math import pi

import cadquery as cq
import numpy as np
from ezdxf.document import Drawing

from tests.support.drawing_reader import MissingDimensionError, ReadDimension, table, view
from tests.support.drum_from_drawing import (
    boxed_plate,
    collar,
    drum,
    motor_head,
    one,
    slot_tools,
    top_plate,
    turned_volume,
)
from tests.support.frame_from_drawing import column, frame, star, yoke

# Points nearer than this on the paper are one.
_ON_PAPER_MM = 0.05

Rebuild = Callable[[Drawing, list[ReadDimension]], float]


def turned(doc: Drawing, dims: list[ReadDimension]) -> float:
    return turned_volume([d for d in dims if d.view == "main"], view(doc, "main"))


def _terminal(doc: Drawing, dims: list[ReadDimension]) -> float:
    """Turned body less the two segments that the flats take from the sleeve, its chamfer included."""
    flat = one(dims, "end", suffix="flats").value / 2
    main = [d for d in dims if d.view == "main"]
    swage = max(d.value for d in main if d.prefix == "Ø") / 2
    lengths = sorted(d.value for d in main if d.across and "45" not in d.suffix)
    chamfer = next(d.value for d in main if "45" in d.suffix)
    radii = np.maximum(np.minimum(swage, swage - chamfer + np.linspace(0.0, lengths[1], 20001)), flat)
    segments = radii**2 * np.arccos(flat / radii) - flat * np.sqrt(radii**2 - flat**2)
    return turned(doc, dims) - 2 * float(segments.mean()) * lengths[1]


def _shaft(doc: Drawing, dims: list[ReadDimension]) -> float:
    """Turned body less the two segments of its flats; where they stand along the shaft must be said too."""
    over = one(dims, "flats", suffix="over flat")
    lengths = sorted((d for d in dims if d.view == "flats" and d.across), key=lambda d: d.count)
    if [d.count for d in lengths] != [1, 2] or over.count != 2:
        raise MissingDimensionError("length and place of two flats")
    radius = next(d.value for d in dims if d.view == "main" and d.prefix == "Ø" and d.count == 2) / 2
    flat = over.value - radius
    segment = radius**2 * np.arccos(flat / radius) - flat * np.sqrt(radius**2 - flat**2)
    return turned(doc, dims) - 2 * float(segment) * lengths[1].value


def _idler(doc: Drawing, dims: list[ReadDimension]) -> float:
    rows = table(doc, "Steps")[1:]
    lengths = sorted((d for d in dims if d.across), key=lambda d: d.value)
    bores = sorted((d for d in dims if d.prefix == "Ø"), key=lambda d: d.value)
    if len(lengths) != 2 or len(bores) != 2:
        raise MissingDimensionError(f"{len(lengths)} lengths, {len(bores)} bores")
    (seat, whole), (shoulder, bore) = lengths, bores
    assert seat.count == bore.count == 2
    ends = [0.0, *(float(row[3]) for row in rows[:-1]), whole.value]
    steps = sum(pi / 4 * float(row[1]) ** 2 * (b - a) for row, a, b in zip(rows, ends, ends[1:], strict=False))
    return steps - pi / 4 * (2 * seat.value * bore.value**2 + (whole.value - 2 * seat.value) * shoulder.value**2)


def _pulley(doc: Drawing, dims: list[ReadDimension]) -> float:
    """Turned body, then the slit and the slots; all lengths and diameters are there, each once."""
    turned(doc, dims)
    return pulley(doc, dims)


def pulley(doc: Drawing, dims: list[ReadDimension]) -> float:
    """The same by the dimensions alone: a slot that lies in the section breaks the outline that the other one reads."""
    main = [d for d in dims if d.view == "main"]
    chain = [d.value for d in sorted((d for d in main if d.across and d.start[1] < 0), key=lambda d: d.start[0])]
    whole = max(chain)
    chain.remove(whole)
    places = [0.0]
    for length in chain:
        places.append(places[-1] + length)
    places.append(whole)
    # Diameters in the order of their places along the axis; the bore's stands on the end face.
    bore, *radii = [d.value / 2 for d in sorted((d for d in main if d.prefix == "Ø"), key=lambda d: d.start[0])]
    # The bore's depth ends on the bore's outline, the slit's on that of the journal.
    level = next(abs(d.start[1]) for d in main if d.prefix == "Ø" and d.value / 2 == bore)
    depths = [d for d in main if d.across and d.start[1] > 0 and "45" not in d.suffix]
    (blind,) = (d.value for d in depths if abs(d.end[1] - level) < _ON_PAPER_MM)
    (slit_depth,) = (d.value for d in depths if abs(d.end[1] - level) >= _ON_PAPER_MM)
    chamfer = next(d.value for d in main if "45" in d.suffix)
    outline = [(0.0, 0.0), (radii[0] - chamfer, 0.0), (radii[0], chamfer)]
    for inner, outer, at in zip(radii[:-1], radii[1:], places[1:-1], strict=True):
        outline += [(inner, at), (outer, at)]
    outline += [(radii[-1], whole - chamfer), (radii[-1] - chamfer, whole), (0.0, whole)]
    solid = cq.Workplane("XZ").polyline(outline).close().revolve(360.0, (0, 0), (0, 1)).val()
    assert isinstance(solid, cq.Shape)
    slit = one(dims, "lower end").value
    reach = radii[0] + 1.0
    tools = [
        cq.Solid.makeCylinder(bore, blind, cq.Vector(0, 0, 0)),
        cq.Solid.makeBox(2 * reach, slit, slit_depth, cq.Vector(-reach, -slit / 2, 0.0)),
        *slot_tools(doc, {"lower": places[2], "upper": places[4]}, {"lower": -1.0, "upper": 1.0}),
        *_rings(doc, reach + max(radii)),
    ]
    for tool in tools:
        solid = solid.cut(tool)
    return float(solid.Volume())


def _rings(doc: Drawing, reach: float) -> list[cq.Shape]:
    """Half a ring for each turn of the grooves of the table, as the section along X shows them."""
    try:
        rows = {row[0]: row[1:] for row in table(doc, "Helical grooves")}
    except MissingDimensionError:
        return []
    tools: list[cq.Shape] = []
    for n in range(len(rows["lead"])):
        root, floor, first, last, start, turns = (
            float(rows[head][n])
            for head in (
                "root Ø",
                "radius of the floor",
                "middle of the groove at one end, from the lower end",
                "middle of the groove at its other end, from the lower end",
                "there at deg from X (seen from +Z, anticlockwise)",
                "turns",
            )
        )
        sense = 1.0 if (rows["hand of the helix"][n] == "right") == (last > first) else -1.0
        for side in (0.0, 180.0):
            # Turns from the groove's start to where it passes this side for the first time.
            there = (sense * (side - start) / 360.0) % 1.0
            while there <= turns:
                at = cq.Vector(0, 0, first + (last - first) * there / turns)
                ring = cq.Solid.makeTorus(root / 2 + floor, floor, at, cq.Vector(0, 0, 1))
                low = cq.Vector(0.0 if side == 0.0 else -reach, -reach, at.z - 2 * floor)
                tools.append(ring.intersect(cq.Solid.makeBox(reach, 2 * reach, 4 * floor, low)))
                there += 1.0
    return tools


def plate(doc: Drawing, dims: list[ReadDimension]) -> cq.Shape:
    """A top plate, or one with coupling boxes, which has holes from its motor shelves."""
    boxed = any(row[-1] == "motor shelf" for row in table(doc, "Holes")[1:])
    return boxed_plate(doc, dims) if boxed else top_plate(doc, dims)


# Small parts; the two below them take seconds each.
SMALL: dict[str, Rebuild] = {
    **dict.fromkeys(("guide_axle", "guide_spacer", "stop_pin", "stop"), turned),
    "drum_shaft": _shaft,
    "terminal": _terminal,
    "guide": _idler,
    "input_pulley_left": _pulley,
    "input_pulley_right": _pulley,
    "top_plate": lambda doc, dims: float(plate(doc, dims).Volume()),
    "collar": lambda doc, dims: float(collar(doc, dims).Volume()),
}
LARGE: dict[str, Rebuild] = {
    "frame": lambda doc, dims: float(frame(doc, dims).Volume()),
    "drum": lambda doc, dims: float(drum(doc, dims).Volume()),
}


def _head(doc: Drawing, dims: list[ReadDimension]) -> float:
    return float(motor_head(doc, dims).Volume())


# Parts that differ from those above, by configuration.
OTHERS: dict[str, dict[str, Rebuild]] = {
    "siso_bevel": {"frame": lambda doc, dims: float(column(doc, dims).Volume()), "motor_head": _head},
    "siso_spur": {"frame": lambda doc, dims: float(yoke(doc, dims).Volume()), "motor_head": _head},
    "miso_spur": {"frame": lambda doc, dims: float(star(doc, dims).Volume()), "motor_head": _head},
}
