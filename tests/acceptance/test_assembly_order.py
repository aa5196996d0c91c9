"""The reported order of assembly, tested on solids: every part can be inserted, every screw reached with its key."""

from collections.abc import Iterator, Sequence
from fnmatch import fnmatch
from math import sqrt
from typing import NamedTuple

import cadquery as cq
import numpy as np
import pytest
from numpy.typing import NDArray

from mbcdm_cad.design.bought import Screw
from mbcdm_cad.layouts.loader import load_design, load_text
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.cable_path import FREE
from mbcdm_cad.layouts.miso_bevel.drive import bevel
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bill import CABLE, AssemblyStep, cable_item
from mbcdm_cad.parts.bodies import CableRod
from mbcdm_cad.workshop.kernel import kernel_shape, location
from tests.support.reference import ABOVE, ROOT

pytestmark = pytest.mark.slow

OVERLAP_MM3 = 0.02
KEY_LENGTH_MM = 50.0
FAR_MM = 100.0
# Where the parts are looked at on their way: densely at first, where everything is tight.
ON_THE_WAY_MM = (0.2, 1.0, 2.0, 3.5, 5.0, 7.0, 9.0, 12.0, 16.0, 20.0, 25.0, 30.0, 40.0, 50.0, 70.0, FAR_MM)
Vector = NDArray[np.float64]


class Move(NamedTuple):
    """Items that move together and the legs (mm) of their way out of the assembly; ``axis``: each along its own."""

    patterns: tuple[str, ...]
    legs: tuple[tuple[float, float, float], ...] = ()
    axis: bool = False


def moves(dims: BevelLayout) -> tuple[Move, ...]:
    """How the items of each step leave it again, in the order in which they came."""
    return above(dims) if dims.drive.motors_above else below(dims)


def above(dims: BevelLayout) -> tuple[Move, ...]:
    """With motors above: drives, collars and their bearings are mounted on the top plate on the bench."""
    front, up = ((0, FAR_MM, 0),), ((0, 0, FAR_MM),)
    on_plate = ("top_plate", "gearhead_*", "motor_*", "collar_*", "input_bearing_lower_*")
    instead = (
        Move(("encoder_left", "encoder_right"), front),
        Move(("encoder_screw_*",), axis=True),
        Move(("input_bearing_upper_*",), up),
        Move(on_plate, up),
    )
    # Terminals that have the frame behind them with the drum centred are inserted with the drum turned.
    instead = (*instead, Move(("terminal_*", "nut_*")))
    same = [m for m in below(dims) if not any(matches(name, m) for name in INSTEAD)]
    return (*instead, *same)


# Items that join in another way with motors above.
INSTEAD = (
    "terminal_cable_1",
    "gearhead_left",
    "gearhead_screw_left_1",
    "collar_left",
    "input_bearing_lower_left",
    "top_plate",
)


def bench_moves(dims: BevelLayout) -> tuple[Move, ...]:
    """How what is mounted on the top plate with motors above leaves it again, on the bench."""
    v, gear = dims.levels.from_gearhead, dims.drive.gearhead
    front, up, down = ((0, FAR_MM, 0),), ((0, 0, FAR_MM),), ((0, 0, -FAR_MM),)
    over_shaft = v.motor_shelf_bottom_z + gear.shaft_length_mm - dims.collar.bottom_z + 0.05
    out_of_hole = dims.drive.screw(gear.screw).length_mm + 0.05
    return (
        Move(("top_plate",)),
        Move(("gearhead_left", "gearhead_right", "motor_*"), up),
        Move(("gearhead_screw_*",), ((0, 0, -out_of_hole), *front)),
        Move(("collar_*",), ((0, 0, -over_shaft), *front)),
        Move(("input_bearing_lower_*",), down),
    )


def below(dims: BevelLayout) -> tuple[Move, ...]:
    """With motors below."""
    v, gear = dims.levels, dims.drive.gearhead
    screw = dims.drive.screw(gear.screw)
    front, back, up, down = ((0, FAR_MM, 0),), ((0, -FAR_MM, 0),), ((0, 0, FAR_MM),), ((0, 0, -FAR_MM),)
    over_shaft = v.motor_shelf_bottom_z + gear.shaft_length_mm - dims.collar.bottom_z + 0.05
    out_of_hole = screw.length_mm + 0.05
    return (
        Move(("frame",)),
        Move(("drum_bearing_front",), front),
        Move(("drum_preload_spring",), back),
        Move(("drum_bearing_rear", "drum_shaft", "drum_encoder"), back),
        Move(("drum_encoder_screw_*",), axis=True),
        Move(("gearhead_left", "gearhead_right", "motor_*"), down),
        Move(("gearhead_screw_*",), ((0, 0, out_of_hole), *front)),
        Move(("collar_*",), ((0, 0, over_shaft), *front)),
        Move(("input_bearing_lower_*",), up),
        Move(("input_pulley_*", "stop_cable_*"), up),
        Move(("guide_axle",), up),
        Move(("axle_set_screw",), axis=True),
        Move(("guide", "guide_bearing_*", "guide_spacer"), up),
        Move(("dowel_*",), up),
        Move(("top_plate", "input_bearing_upper_*", "encoder_*"), up),
        Move(("plate_screw_*",), axis=True),
        Move(("drum",), front),
        Move(("stop_pin",), front),
        Move(("hub_set_screw_*",), axis=True),
        Move(("terminal_*", "nut_*"), back),
    )


Solids = dict[str, cq.Solid]


def drawn(dims: BevelLayout) -> Solids:
    """Each part but the cables, by its name."""
    return {name: spec.part.solid() for name, spec in bill(dims).parts.items() if not name.startswith(CABLE)}


def box_of(shape: cq.Shape) -> Vector:
    """Its least and its largest corner."""
    box = shape.BoundingBox()
    return np.array(((box.xmin, box.ymin, box.zmin), (box.xmax, box.ymax, box.zmax)))


class Workshop:
    """Solids of the reference design, and what stands in place so far."""

    def __init__(self, dims: BevelLayout, solids: Solids, drum_deg: float = 0.0) -> None:
        b = bill(dims, drum_deg)
        self.dims = dims
        self.items = {item.name: item for item in b.items}
        self.screws = {
            i.name: s for i in b.items if isinstance(s := getattr(b.parts[i.part].part, "entry", None), Screw)
        }
        self.shapes = {
            i.name: cq.Shape.cast(kernel_shape(solids[i.part]).Moved(location(i.location)))
            for i in b.items
            if i.part in solids
        }
        radius = dims.drive.cable.diameter_mm / 2 - 0.005
        # What is wound on the pulleys moves with them, what lies on the drum is not there yet.
        self.shapes |= {
            cable_item(p.cable.name): CableRod(p.only(FREE).line, radius).solid() for p in dims.cable_paths(0.0)
        }
        self.boxes = {name: box_of(shape) for name, shape in self.shapes.items()}
        self.placed: list[str] = []

    def axis(self, name: str) -> Vector:
        """The way out of a screw's hole."""
        return self.items[name].location.rotation[:, 2]

    def hits(self, shape: cq.Shape, box: Vector, shift: Vector, others: Sequence[str]) -> Iterator[tuple[str, float]]:
        """What a shape with this box would share volume with if it were moved by ``shift``."""
        low, high = box + shift
        near = [n for n in others if (low <= self.boxes[n][1]).all() and (self.boxes[n][0] <= high).all()]
        moved = shape.translate(cq.Vector(*shift)) if near else shape
        for name in near:
            volume = moved.intersect(self.shapes[name]).Volume()
            if volume > OVERLAP_MM3:
                yield name, volume

    def hits_rod(self, radius: float, at: Vector, along: Vector, others: Sequence[str]) -> Iterator[tuple[str, float]]:
        """As :meth:`hits`, of a straight key or the way of a head."""
        rod = cq.Solid.makeCylinder(radius, KEY_LENGTH_MM, cq.Vector(*at), cq.Vector(*along))
        yield from self.hits(rod, box_of(rod), np.zeros(3), others)

    def on_the_way(self, name: str, legs: Sequence[Vector], others: Sequence[str]) -> Iterator[str]:
        start = np.zeros(3)
        for leg in legs:
            length = float(np.linalg.norm(leg))
            for along in (*(s for s in ON_THE_WAY_MM if s < length), length):
                shift = start + leg * (along / length)
                for other, volume in self.hits(self.shapes[name], self.boxes[name], shift, others):
                    yield f"{name}, {shift.round(2)} mm out of place, meets {other}: {volume:.3f} mm^3"
            start = start + leg

    def key(self, name: str, others: Sequence[str]) -> Iterator[str]:
        """The straight key of a screw, as thick as over its corners, from the screw's head outwards."""
        screw, place = self.screws[name], self.items[name].location
        at = place.shift_mm + self.axis(name) * (screw.head_height_mm + 0.05)
        for other, volume in self.hits_rod(screw.key_mm / sqrt(3), at, self.axis(name), others):
            yield f"key of {name} meets {other}: {volume:.3f} mm^3"

    def mounting(self) -> Iterator[str]:
        f, screw = self.dims.frame, self.dims.mounting
        seat = screw.seat_mm(self.dims.mount_washers) / 2
        for x, z in f.mounts:
            for radius, what in ((seat, "head"), (screw.key_mm / sqrt(3), "key")):
                at, along = np.array((x, f.mount_seat_y, z)), np.array((0.0, 1.0, 0.0))
                for other, volume in self.hits_rod(radius, at, along, self.placed):
                    yield f"{what} of the mounting screw at x {x:.2f}, z {z:.2f} meets {other}: {volume:.3f} mm^3"


def matches(name: str, move: Move) -> bool:
    return any(fnmatch(name, pattern) for pattern in move.patterns)


def step_faults(shop: Workshop, step: AssemblyStep, ways: Sequence[Move]) -> Iterator[str]:
    """What stands in the way of one step's items and keys; afterwards they are in place."""
    solid = [name for name in step.items if not name.startswith(CABLE)]
    left = list(solid)
    # With motors above, what the top plate carries is mounted on the bench.
    bench = solid if "top_plate" in solid and "gearhead_left" in solid else []
    if bench:
        yield from bench_faults(shop, bench)
    for move in ways:
        together = [name for name in left if matches(name, move)]
        left = [name for name in left if name not in together]
        for name in together:
            legs = (shop.axis(name) * FAR_MM,) if move.axis else tuple(np.array(leg, dtype=float) for leg in move.legs)
            yield from shop.on_the_way(name, legs, shop.placed)
        shop.placed += together
    assert not left, f"no way in is stated for {left}"
    for name in solid:
        if name in shop.screws and not name.startswith("collar_screw") and not bench:
            # The encoders of motors below are screwed to the top plate on the bench.
            plate = name.startswith("encoder_screw") and "top_plate" in solid
            around = [n for n in step.items if not n.startswith("dowel")] if plate else shop.placed
            yield from shop.key(name, [n for n in around if n != name])
    collars_there = any(name.startswith("collar") for name in shop.placed)
    if collars_there and any(name.startswith(("input_pulley", "plate_screw")) for name in solid):
        for name in shop.placed:
            if name.startswith("collar_screw"):
                yield from shop.key(name, [n for n in shop.placed if n != name])


def bench_faults(shop: Workshop, items: Sequence[str]) -> Iterator[str]:
    """What stands in the way of what is mounted on the top plate on the bench."""
    there: list[str] = []
    for move in bench_moves(shop.dims):
        together = [name for name in items if matches(name, move) and name not in there]
        for name in together:
            legs = [np.array(leg, dtype=float) for leg in move.legs]
            found = list(shop.on_the_way(name, legs, there))
            if found and name.startswith("gearhead_screw"):
                # Of three screws one may be behind the gearhead's shaft, and comes in beside it.
                gear = shop.dims.drive.gearhead
                aside = (gear.shaft_diameter_mm + shop.screws[name].head_diameter_mm) / 2 + 0.3
                ways = ([legs[0], np.array((side * aside, 0.0, 0.0)), *legs[1:]] for side in (1, -1))
                found = min((list(shop.on_the_way(name, way, there)) for way in ways), key=len)
            yield from found
        there += together
        for name in together:
            if name.startswith("gearhead_screw"):
                yield from shop.key(name, [n for n in there if n != name])
    assert sorted(there) == sorted(items)


def faults(shop: Workshop, order: Sequence[AssemblyStep]) -> Iterator[str]:
    ways = moves(shop.dims)
    for step in order:
        yield from step_faults(shop, step, ways)
        if step.text.startswith("Bolt the frame"):
            yield from shop.mounting()
        if step.text.startswith("Lead each cable") or step.text.startswith("Set the guide axle"):
            moved = next(n for n in ("drum", "guide") if n in step.items)
            way = np.array((0.0, FAR_MM, 0.0) if moved == "drum" else (0.0, 0.0, FAR_MM))
            cables = [name for name in shop.shapes if name.startswith(CABLE)]
            yield from shop.on_the_way(moved, (way,), cables)


@pytest.fixture(scope="module")
def dims() -> BevelLayout:
    return BevelLayout(load_design(ROOT / "params" / "mbcdm.yaml").drive)


@pytest.fixture(scope="module")
def solids(dims: BevelLayout) -> Solids:
    return drawn(dims)


def test_reference_goes_together_in_the_order_reported(dims: BevelLayout, solids: Solids) -> None:
    found = list(faults(Workshop(dims, solids), dims.assembly_order))
    assert not found, "\n".join(found)


def turned_faults(dims: BevelLayout, solids: Solids, order: Sequence[AssemblyStep]) -> Iterator[str]:
    """What stands in the way of terminals on their way in from behind, with the drum where the order says."""
    text = next(step.text for step in order if "terminal_cable_1" in step.items)
    half = dims.drive.half_travel_deg
    for cable in dims.drive.cables:
        angle = cable.drum_side * half if "turn the drum" in text and cable.name in text else 0.0
        shop = Workshop(dims, solids, angle)
        there = [name for name in shop.shapes if not name.startswith(("terminal", "nut", CABLE))]
        for name in (f"terminal_{cable.name}", f"nut_{cable.name}_1", f"nut_{cable.name}_2"):
            yield from shop.on_the_way(name, [np.array((0.0, -FAR_MM, 0.0))], there)


@pytest.fixture(scope="module")
def raised() -> BevelLayout:
    return BevelLayout(bevel(load_text(ABOVE).drive))


@pytest.fixture(scope="module")
def raised_solids(raised: BevelLayout) -> Solids:
    return drawn(raised)


@pytest.mark.parametrize("name", ["dims", "raised"])
def test_every_item_joins_in_exactly_one_step(request: pytest.FixtureRequest, name: str) -> None:
    layout: BevelLayout = request.getfixturevalue(name)
    joined = [name for step in layout.assembly_order for name in step.items]
    assert sorted(joined) == sorted(item.name for item in bill(layout).items)


def test_motors_above_go_together_in_the_order_reported(raised: BevelLayout, raised_solids: Solids) -> None:
    order = raised.assembly_order
    found = [*faults(Workshop(raised, raised_solids), order), *turned_faults(raised, raised_solids, order)]
    assert not found, "\n".join(found)


def test_bearings_first_would_hide_the_gearheads_screws(raised: BevelLayout, raised_solids: Solids) -> None:
    """The test sees a key that a bearing stands in the way of."""
    shop = Workshop(raised, raised_solids)
    found = list(shop.key("gearhead_screw_left_1", ["top_plate", "input_bearing_lower_left"]))
    assert any("input_bearing_lower_left" in line for line in found), found


def test_drum_first_would_hide_the_collars_screws(dims: BevelLayout, solids: Solids) -> None:
    """The test sees what an order that does not work runs into."""
    order = dims.assembly_order
    drum = next(k for k, step in enumerate(order) if "drum" in step.items)
    pulleys = next(k for k, step in enumerate(order) if "input_pulley_left" in step.items)
    swapped = (*order[:pulleys], order[drum], *order[pulleys:drum])
    found = faults(Workshop(dims, solids), swapped)
    assert any(line.startswith("key of collar_screw_left meets drum") for line in found)
