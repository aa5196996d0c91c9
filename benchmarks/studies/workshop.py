"""Requirements of the workshop, tested on the solids: take-up, drawings, files for a printer, tables of holes."""

import io
import random
import re
from collections.abc import Iterator
from math import atan2, cos, degrees, sin
from typing import Any

import cadquery as cq
import trimesh

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.drawings.draw import PartFacts, draw_sheet
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.parts.bill import CABLE, Bill, Placement
from mbcdm_cad.parts.milled import cylinder
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.sheet import Linear, Sheet
from mbcdm_cad.workshop.export.files import threemf_bytes
from mbcdm_cad.workshop.kernel import location
from mbcdm_cad.workshop.meshing import drawn_part, mesh_solid
from mbcdm_cad.workshop.prints import RoundHole, round_holes, with_wider_holes
from tests.support.drawing_reader import dimensions, document, texts_on_texts, texts_outside
from tests.support.rebuilt import LARGE, OTHERS, SMALL, pulley

Failures = Iterator[tuple[str, str]]
# Solids that touch share nothing; this is what booleans leave of a touch.
TOUCH_MM3 = 1e-3
# Printed decimals, by the volume of the part: that of a nut feels them most.
VOLUME_ERROR = 2e-3
MESH_MM = 0.02
# Words of the kernel that no message to a user may hold.
KERNEL = re.compile(r"StdFail|BRep|TopoDS|Standard_|gp_|Geom_|OCP")


def take_up(dims: Any, solids: dict[str, cq.Solid]) -> Failures:
    """Terminals move over their whole way in the drum, with thread under both nuts, and the way is long enough."""
    drive, drum = dims.drive, solids["drum"]

    def common(a: cq.Shape, b: cq.Shape) -> float:
        return abs(a.intersect(b).Volume())

    for path, t in zip(dims.cable_paths(0.0), dims.drum.tensioners, strict=True):
        turn = degrees(atan2(t.side * cos(t.anchor_rad), -sin(t.anchor_rad)))

        def there(solid: cq.Shape, s: float, t: Any = t, turn: float = turn) -> cq.Shape:
            x, z = t.at(s)
            place = Placement.translation(x, t.y_mm, z) @ Placement.about((0.0, 1.0, 0.0), turn)
            return solid.moved(cq.Location(location(place @ Placement.about((0.0, 0.0, 1.0), 90.0))))

        height = drive.tensioner.nut_height_mm
        bore = there(cylinder(drive.tensioner.thread_mm / 2, (0, 0, 0), (0, 0, 1), 2 * height), t.lug_end)
        for n in range(2):
            if common(there(solids["nut"], t.lug_end + n * height), drum) > TOUCH_MM3:
                yield "take-up", f"nut {n + 1} of {t.cable_name} stands in the drum"
        for share in (0.0, 0.5, 1.0):
            terminal = there(solids["terminal"], share * t.travel)
            if (shared := common(terminal, drum)) > TOUCH_MM3:
                yield "take-up", f"terminal of {t.cable_name} drawn in {share:.0%}: {shared:.4f} mm3 in the drum"
            if share != 0.5 and (filled := common(terminal, bore) / bore.Volume()) < 0.999:
                yield "take-up", f"{t.cable_name} drawn in {share:.0%}: thread under {filled:.1%} of both nuts"
        rope, length = drive.cable, path.length_mm
        stretch = path.cable.preload_N * length / rope.axial_stiffness_N
        needed = stretch + rope.bedding_in_share * length + 2 * drive.cut_tolerance_mm
        if t.travel < needed:
            yield "take-up", f"{t.cable_name}: way {t.travel:.3f} mm, needed {needed:.3f}"


def drawing(name: str, sheet: Sheet, shown: cq.Solid, drive: Drive) -> Failures:
    """Sound DXF, no text on another or off the paper, and the part that it makes is the part."""
    doc = document(draw_sheet(sheet, shown, PartFacts("random", "metal", 1.0, "0", drive.making.position_mm))["dxf"])
    audit = doc.audit()
    if audit.errors or audit.fixes:
        yield "drawing", f"{name}: audit finds {audit.errors or audit.fixes}"
    if over := texts_on_texts(doc):
        yield "drawing", f"{name}: texts on each other {over[:3]}"
    if outside := texts_outside(doc):
        yield "drawing", f"{name}: texts off the paper {outside[:3]}"
    known = {**SMALL, **LARGE, **OTHERS.get(drive.configuration, {})}
    rebuild = pulley if name.startswith("input_pulley") else known.get(name)
    if rebuild is None:
        yield "drawing", f"{name}: no rule to make it from its sheet"
        return
    try:
        off = rebuild(doc, dimensions(doc)) / shown.Volume() - 1.0
    except Exception as error:  # the kernel raises what it likes
        yield "drawing", f"{name}: not to be made from its sheet: {type(error).__name__}: {error}"
        return
    if abs(off) > VOLUME_ERROR:
        yield "drawing", f"{name}: made from its sheet, its volume is {off:+.2%} off"


def printed(name: str, solid: cq.Solid, wider_mm: float) -> Failures:
    """The 3MF read back by another program: millimetres, name, watertight, volume."""
    shown = cq.Shape.cast(with_wider_holes(name, solid.wrapped, wider_mm)) if wider_mm else solid
    data = threemf_bytes(name, mesh_solid(name, shown.wrapped, MESH_MM))
    scene = trimesh.load(io.BytesIO(data), file_type="3mf")
    assert isinstance(scene, trimesh.Scene)
    (found,) = scene.geometry.values()
    if scene.units not in ("mm", "millimeter", "millimeters") or name not in str(list(scene.graph.nodes)):
        yield "print", f"{name}: unit {scene.units}, nodes {list(scene.graph.nodes)}"
    if not found.is_watertight or abs(found.volume / shown.Volume() - 1.0) > 0.01:
        yield "print", f"{name}: watertight {found.is_watertight}, volume {found.volume:.2f} of {shown.Volume():.2f}"


def _through(hole: RoundHole, place: tuple[float, float, float]) -> float:
    """Distance of a point from a hole's axis."""
    away = cq.Vector(*place) - cq.Vector(*hole.foot_mm)
    along = cq.Vector(*hole.direction)
    return float((away - along * away.dot(along)).Length)


def holes(name: str, sheet: Sheet, solid: cq.Solid) -> Failures:
    """Each hole of the table is in the solid; each bore of the solid is in the table or a diameter of the sheet."""
    walls, whole = round_holes(solid.wrapped, 0.05), round_holes(solid.wrapped)
    wanted = []
    for group in sheet.holes:
        bore = group.counterbore
        wanted += [(r, p) for p in group.places for r in (group.diameter / 2, *((bore[0] / 2,) if bore else ()))]

    def same(hole: RoundHole, radius: float, place: tuple[float, float, float]) -> bool:
        return abs(hole.radius_mm - radius) < 1e-3 and _through(hole, place) < 2e-3

    for radius, place in wanted:
        if not any(same(hole, radius, place) for hole in walls):
            yield "holes", f"{name}: the table's hole of {2 * radius:g} mm at {place} is not in the solid"
    said = [d.value / 2 for d in sheet.dimensions if isinstance(d, Linear) and d.prefix.strip("2x ") in ("%%c", "M")]
    for hole in whole:
        if not any(same(hole, *one) for one in wanted) and not any(abs(hole.radius_mm - r) < 1e-3 for r in said):
            yield "holes", f"{name}: bore of {2 * hole.radius_mm:g} mm at {hole.foot_mm} is not on the sheet"


def workshop(dims: Any, bill: Bill, solids: dict[str, cq.Solid], undrawn: tuple[str, ...] = ()) -> Failures:
    """All of it, for each made part but the drawings of those ``undrawn``; ``solids`` by part."""
    drive = dims.drive
    yield from take_up(dims, {**solids, "nut": bill.parts["nut"].part.solid()})
    for name, item in {item.part: item for item in bill.items if item.kind == "made"}.items():
        spec, solid = bill.parts[name], solids[name]
        if not isinstance(spec.part, MadePart):
            yield "drawing", f"{name}: has no sheet"
            continue
        sheet = spec.part.sheet(name)
        simple = spec.part.in_views()
        shown = solid if simple == spec.part else simple.solid()
        if name not in undrawn:
            yield from drawing(name, sheet, shown, drive)
        yield from printed(name, solid, drive.printing.hole_allowance_mm if item.material.printed else 0.0)
        yield from holes(name, sheet, shown)


# Fields that a forced build may be given any value for.
FORCED = (
    *(("drum", name) for name in ("hub_diameter_mm", "web_thickness_mm", "rim_inner_radius_mm", "hub_face_y_mm")),
    *(("drum", name) for name in ("sector_half_angle_deg", "outer_face_y_mm", "shaft_bore_mm")),
    *(("support", name) for name in ("back_plate_mm", "side_wall_mm", "motor_shelf_mm", "bearing_shelf_mm")),
    *(("support", name) for name in ("top_plate_mm", "rib_mm", "coupling_space_mm")),
    *(("clearances", name) for name in ("transfer_gap_mm", "land_edge_mm", "running_mm")),
)


def forced(data: dict[str, Any], drive: Drive, seed: int) -> tuple[dict[str, Any], str]:
    """The design with two of its sizes 0.3 to 3 times as large, as somebody might force it; what was changed."""
    rng, changed, words = random.Random(seed), dict(data), []
    for block, field in rng.sample(FORCED, 2):
        value = round(getattr(getattr(drive, block), field) * 10 ** rng.uniform(-0.5, 0.5), 3)
        changed[block] = {**changed.get(block, {}), field: value}
        words.append(f"{block}.{field} {value}")
    return changed, ", ".join(words)


def forced_parts(drive: Drive, what: str) -> Failures:
    """All parts of a forced design are drawn, or refused with words for the user: never the kernel's."""
    try:
        dims = layout_of(drive)
        bill = dims.bill()
    except Exception as error:
        if not isinstance(error, MbcdmError):
            yield "forced", f"{what}: layout: {type(error).__name__}: {error}"
        return
    material = {item.part: item.material for item in bill.items}
    for name, spec in bill.parts.items():
        if name.startswith(CABLE):
            continue
        try:
            drawn_part(spec, material[name], 0.05)
        except MbcdmError as error:
            if KERNEL.search(str(error)) or name not in str(error):
                yield "forced", f"{what}: {name}: {error}"
        except Exception as error:
            yield "forced", f"{what}: {name}: {type(error).__name__}: {error}"


def at_rest(bill: Bill) -> dict[str, cq.Solid]:
    """Solids of all made parts of a bill."""
    made = dict.fromkeys(item.part for item in bill.items if item.kind == "made")
    return {name: bill.parts[name].part.solid() for name in made}
