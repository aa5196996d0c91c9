"""Mass, centre of gravity and inertia of every item and of the whole, with the uncertainty from estimates."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.parts.bill import CABLE, Bill, Item
from mbcdm_cad.parts.part import BoughtPart, StandardPart
from mbcdm_cad.workshop.interference import bodies
from mbcdm_cad.workshop.mass import MassProperties, combined, item_mass
from mbcdm_cad.workshop.store import StoredPart

# One sigma of a mass that the catalogue calls an estimate, of one with a maker's figure, and of a machined part
# (density of the alloy and machining tolerances). Parts of one kind have the same error, different kinds independent
# ones.
ESTIMATE_SIGMA = 0.10
CATALOGUE_SIGMA = 0.02
MADE_SIGMA = 0.01
_MASS = re.compile(r"\bmass\b|\d\s?g\b(?!/cm3)", re.IGNORECASE)


@dataclass(frozen=True)
class BillLine:
    """One line of the bill of materials: all items of one part."""

    part: str
    count: int
    kind: str
    material: str
    each_g: float
    total_g: float
    sigma_g: float
    source: str


@dataclass(frozen=True)
class ReflectedInertias:
    """Moments of inertia of the moving parts, g mm^2: reflected to the drum's axis, and to one motor's shaft.

    ``passed_at_drum`` are those of bodies that cables pass; ``input_shafts`` are each input's about its own axis,
    without its rotor.
    """

    drum_group: float
    passed_at_drum: dict[str, float]
    inputs_at_drum: float
    rotors_at_drum: float
    at_drum_without_rotors: float
    at_drum: float
    at_motor: float
    input_shafts: tuple[float, ...]

    def to_dict(self) -> dict[str, Any]:
        """As the report holds it, a key ``NAME_at_drum`` for each body that cables pass."""
        plain = asdict(self)
        return {**{f"{name}_at_drum": value for name, value in plain.pop("passed_at_drum").items()}, **plain}


def _source(item: Item, parts_list: Bill, drive: Drive) -> str:
    if item.kind == "made":
        return f"volume x {item.material.density_g_cm3:g} g/cm^3 ({item.material.source})"
    if item.name.startswith(CABLE):
        return drive.cable.source
    body = parts_list.parts[item.part].part
    if isinstance(body, StandardPart):
        return f"{body.designation}; volume x {item.material.density_g_cm3:g} g/cm^3 ({item.material.source})"
    return body.entry.source if isinstance(body, BoughtPart) else ""


def mass_is_estimated(source: str) -> bool:
    """Whether a catalogue entry's source calls its mass an estimate.

    The clause about the mass (with this word, or a figure in g) decides; without one, the whole text.
    """
    clauses = re.split(r";|\.\s", source)
    of_mass = [clause for clause in clauses if _MASS.search(clause)]
    return any("estimate" in clause.lower() for clause in of_mass or clauses)


def bill_lines(centred: Bill, parts: Mapping[str, StoredPart], drive: Drive) -> tuple[BillLine, ...]:
    """Bill of materials, heaviest line first."""
    by_part: dict[str, list[Item]] = {}
    for item in centred.items:
        by_part.setdefault(item.part, []).append(item)
    lines = []
    for part, items in by_part.items():
        first = items[0]
        each = item_mass(first, parts[part].files.shape).mass_g
        source = _source(first, centred, drive)
        total, estimated = each * len(items), mass_is_estimated(source)
        lines.append(
            BillLine(
                part,
                len(items),
                first.kind,
                first.material.name,
                each,
                total,
                total * (MADE_SIGMA if first.kind == "made" else ESTIMATE_SIGMA if estimated else CATALOGUE_SIGMA),
                source,
            )
        )
    return tuple(sorted(lines, key=lambda line: (-line.total_g, line.part)))


def total_sigma_g(lines: tuple[BillLine, ...]) -> float:
    """One sigma of the total mass, g; the errors of different kinds of parts are independent."""
    return float(np.sqrt(sum(line.sigma_g**2 for line in lines)))


def masses_by_item(centred: Bill, parts: Mapping[str, StoredPart]) -> dict[str, MassProperties]:
    """Mass properties of every item at its place."""
    return {item.name: item_mass(item, parts[item.part].files.shape) for item in centred.items}


def inertias(layout: Layout, centred: Bill, by_item: Mapping[str, MassProperties]) -> ReflectedInertias:
    """Inertia reflected to the drum's axis: each moving group times the square of its ratio to the drum.

    Cables are left out (2 g, moving with the rims); the rotors turn i_c x gearhead times faster than the drum.
    """
    drive = layout.drive
    groups: dict[str, list[MassProperties]] = {}
    for item in centred.items:
        groups.setdefault(item.group, []).append(by_item[item.name])
    drum = rotors = 0.0
    passed: dict[str, float] = {}
    inputs = 0.0
    shafts = []
    for body in layout.moving_bodies:
        own = combined(groups[body.name]).about_axis(body.axis, body.origin_mm)
        at_drum = own * body.turns_per_drum**2
        if body.kind == "drum":
            drum = own
        elif body.kind == "passed":
            passed[body.name] = at_drum
        elif body.kind == "stage":
            inputs += at_drum
        else:
            # kg m^2 to g mm^2.
            rotor = drive.rotor_at_input_kg_m2 * 1e9
            inputs += at_drum
            rotors += rotor * body.turns_per_drum**2
            shafts.append(own)
    first = drive.cables[0]
    motor_ratio = first.drum_radius_mm / first.input_radius_mm * drive.reduction.ratio
    without = drum + sum(passed.values()) + inputs
    everything = without + rotors
    return ReflectedInertias(
        drum, passed, inputs, rotors, without, everything, everything / motor_ratio**2, tuple(shafts)
    )


Box = tuple[NDArray[np.float64], NDArray[np.float64]]


def cable_boxes_mm(layout: Layout, drum_angles_deg: Sequence[float]) -> list[Box]:
    """Lowest and highest corner of all cables at each drum angle, from their centre lines and radius."""
    own, boxes = layout.drive.cable.diameter_mm, []
    for angle in drum_angles_deg:
        paths = layout.all_cable_paths(np.radians(angle))
        points = [(path.sample(0.25), (path.diameter_mm or own) / 2) for path in paths]
        low = np.min([at.min(axis=0) - radius for at, radius in points], axis=0)
        boxes.append((low, np.max([at.max(axis=0) + radius for at, radius in points], axis=0)))
    return boxes


def boxes_mm(
    layout: Layout,
    centred: Bill,
    parts: Mapping[str, StoredPart],
    drum_angles_deg: Sequence[float],
    cables: Sequence[Box],
) -> list[Box]:
    """Lowest and highest corner (x, y, z) of everything at each drum angle; ``cables`` from :func:`cable_boxes_mm`.

    Solids from their meshes (within the mesh tolerance), those of a body turned together.
    """
    items = {item.name: item for item in centred.items}
    boxes = list(cables)
    for group in bodies(layout.moving_bodies, centred):
        placed = [items[name].location.apply(parts[items[name].part].files.mesh.points_mm) for name in group.items]
        if not placed:
            continue
        points = np.ascontiguousarray(np.concatenate(placed).T)  # in rows, which are searched several times as fast
        low, high = points.min(axis=1), points.max(axis=1)
        for k, angle in enumerate(drum_angles_deg):
            if group.ratio:
                motion = group.at(angle)
                turned = motion.rotation @ points + motion.shift_mm[:, None]
                low, high = turned.min(axis=1), turned.max(axis=1)
            boxes[k] = np.minimum(boxes[k][0], low), np.maximum(boxes[k][1], high)
    return boxes
