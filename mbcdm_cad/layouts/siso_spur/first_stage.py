"""A first cable stage before the input: its drive, and what it is to the second stage.

The first stage is a whole drive of this layout. The shaft of its drum stands out behind its frame and turns the input
of the second stage, on whose motor head the boss of that frame is screwed, as a gearhead would be. To the second stage
it is a gearhead with the ratio, losses and stiffness of that drive (:class:`CableStageOutput`).
"""

from __future__ import annotations

import copy
import json
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import asdict, replace
from functools import cached_property, partial, reduce
from importlib import import_module
from math import ceil, floor, pi, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mbcdm_cad.checks.drum_sector import STOP_WINDOW_DEG
from mbcdm_cad.design.bought import FIRST_STAGE, NO_ENCODER, NO_GEARHEAD, CableStageOutput
from mbcdm_cad.design.catalogue import KINDS, OwnEntries
from mbcdm_cad.design.loader import DesignFile
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import SizedValue, SizingError
from mbcdm_cad.design.yamltree import FieldPath
from mbcdm_cad.errors import InputError, shortened
from mbcdm_cad.layouts.base import Attachment, NoFigureError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.parts.bill import CABLE, FIXED, AssemblyStep, BillBuilder, MovingBody, PartSpec, Placement
from mbcdm_cad.routes.curves import CablePath, carried

if TYPE_CHECKING:
    from mbcdm_cad.layouts.sector import SectorLayout
    from mbcdm_cad.layouts.siso_spur.drive import SpurDrive

if TYPE_CHECKING:
    from mbcdm_cad.checks.comparison import Check


# Largest half of the first drum's travel that rules ask for: above 120 degrees it is a whole drum, wider, and the
# terminals of a small one take much of its circle.
MOST_TRAVEL_DEG = 90.0
# Ratio of the second stage where the file states none, and the step to which a rule rounds it down.
USUAL_RATIO, RATIO_STEP = 4.0, 0.05
# Torque of the first drum over the peak torque by the ratio of the second stage, for what that stage loses: two usual
# preloads bent round ten diameters, and its bearings (estimate; the check motor_torque_forward counts them).
LOSSES = 1.12
# Length of the shaft that stands out: motor shelf with the heads of the screws on it, and the clamp collar, or the
# shaft's diameter where that is longer (choice).
SHELF_MM, COLLAR_MM = 8.0, 10.0
# Blocks of the first stage that follow from the file, or have no place in it.
NOT_ITS_OWN = (
    "schema_version",
    "name",
    "configuration",
    "travel",
    "stage",
    "idlers",
    "first_stage",
    "printing",
    "making",
    "catalogue",
    "waivers",
    "as_built",
    "export",
)
# Drives and sizings that are kept, by the words of their files.
_KEPT = 32


class FirstStage(NamedTuple):
    """The drive of a first stage, what it is to the second one, and the values that rules gave it."""

    drive: SpurDrive
    output: CableStageOutput
    sized: tuple[SizedValue, ...]


# Value of a field by its dotted name; None where it is open.
Get = Callable[[str], Any]
_found: OrderedDict[str, FirstStage | SizingError] = OrderedDict()


def of_design(design: Any) -> FirstStage | None:
    """The first stage of a valid design. Raises ``SizingError`` with what is wrong in its block."""
    return None if design.first_stage is None else of_data(_fields(design))


def _fields(design: Any) -> Get:
    """The values of a design by their dotted names."""
    return lambda field: reduce(lambda block, name: getattr(block, name, None), field.split("."), design)


def of_data(get: Get) -> FirstStage:
    """The first stage of a file whose fields are being filled. Raises as :func:`of_design`."""
    return first_stage(words(get))


def last_ratio(get: Get) -> float:
    """Drum radius over input radius of the second stage."""
    stated = get("transmission.input_to_drum")
    return float(stated or get("transmission.drum_radius_mm") / get("transmission.input_radius_mm"))


def turned_deg(get: Get) -> float:
    """Half the way of the drum of the second stage, up to its stops."""
    stop = get("travel.stop_clearance_deg")
    return float(get("travel.half_angle_deg") + (STOP_WINDOW_DEG / 2 if stop is None else stop))


def split_ratio(get: Get) -> float:
    """Ratio of the second stage: the root of the whole, or less where the first drum would turn too far.

    Compliance and lash of the first stage count with the square and the first power of one over this ratio, so that it
    should be high; as much in each stage as in the other gives the smallest pulleys.
    """
    total, first = (get(f"first_stage.{name}") for name in ("total_ratio", "ratio"))
    most = floor(MOST_TRAVEL_DEG / turned_deg(get) / RATIO_STEP) * RATIO_STEP
    if total is not None and first is not None:
        return float(total / first)
    wanted = USUAL_RATIO if total is None else ceil(sqrt(total) / RATIO_STEP - 1e-9) * RATIO_STEP
    return round(max(min(wanted, most), 1.0), 9)


def words(get: Get) -> dict[str, Any]:
    """The design file of the first stage as plain data, from the fields of the whole.

    Raises ``SizingError`` for words that it cannot have.
    """
    ratio = last_ratio(get)
    own = OwnEntries.model_validate(get("catalogue") or {})
    whole, stated = get("first_stage"), get("first_stage.ratio")
    given = copy.deepcopy((whole.get("design") if isinstance(whole, dict) else whole.design) or {})
    for name in given:
        if name in NOT_ITS_OWN:
            raise SizingError(
                Broken(
                    ("first_stage", "design", name),
                    "follows from the file, or has no place in a first stage",
                    shortened(given[name]),
                    "",
                    "remove it",
                )
            )
    if (given.get("transmission") or {}).get("spans") == "open":
        place = ("first_stage", "design", "transmission", "spans")
        raise SizingError(
            Broken(place, "the input of a first stage turns against its drum", "open", "crossed", "remove it")
        )
    torque = LOSSES / ratio if get("limits.losses") != "paper" else 1.0 / ratio
    loads = {
        "peak_torque_Nm": _digits(get("loads.peak_torque_Nm") * torque),
        "test_torque_Nm": _digits(get("loads.test_torque_Nm") / ratio),
    }
    for name, factor in (("continuous_torque_Nm", torque), ("speed_deg_s", ratio)):
        if get(f"loads.{name}") is not None:
            loads[name] = _digits(get(f"loads.{name}") * factor)
    lasting = {n: get(f"targets.{n}") for n in ("life_cycles", "life_h") if get(f"targets.{n}") is not None}
    train = {
        name: get(f"drive.{name}")
        for name in ("motor", "gearhead", "bus_voltage_V")
        if get(f"drive.{name}") is not None
    }
    found: dict[str, Any] = {
        "name": FIRST_STAGE,
        "configuration": "siso_spur",
        "travel": {"half_angle_deg": _digits(ratio * turned_deg(get))},
        "transmission": {} if stated is None else {"input_to_drum": float(stated)},
        "loads": loads,
        "targets": lasting,
        "limits": {"losses": get("limits.losses") or "counted"},
        "drive": {**train, "encoder": NO_ENCODER, "drum_encoder": NO_ENCODER},
        "drum": {"material": get("drum.material"), "shaft_end_mm": SHELF_MM + COLLAR_MM},
        "support": {"material": get("support.material")},
        "printing": {"nozzle_mm": get("printing.nozzle_mm") or 0.4, "threads": get("printing.threads") or "cut"},
        "catalogue": {kind: {name: _entry(e) for name, e in getattr(own, kind).items()} for kind in KINDS},
    }
    for block, fields in given.items():
        if isinstance(fields, dict) and isinstance(found.get(block), dict):
            found[block] = {**found[block], **fields}
        else:
            found[block] = fields
    return found


def _digits(value: float) -> float:
    """Nine digits, so that fields that are equal but for rounding give the same drive."""
    return float(f"{value:.9g}")


def _entry(entry: Any) -> dict[str, Any]:
    values = json.loads(json.dumps(asdict(entry)))
    return {name: value for name, value in values.items() if name != "name" and value is not None}


def first_stage(file: dict[str, Any]) -> FirstStage:
    """The drive of a first stage by its words; kept, since one sizing asks for it some hundred times."""
    key = json.dumps(file, sort_keys=True)
    if key not in _found:
        try:
            made = _found[key] = _made(file)
            # The same file with the motor that its rules chose.
            train = {**file["drive"], "motor": made.drive.motor.name, "gearhead": gearhead_word(made.drive)}
            _found[json.dumps({**file, "drive": train}, sort_keys=True)] = made
        except SizingError as error:
            _found[key] = error
        while len(_found) > _KEPT:
            _found.popitem(last=False)
    _found.move_to_end(key)
    found = _found[key]
    if isinstance(found, SizingError):
        raise found
    return found


def _made(file: dict[str, Any]) -> FirstStage:
    from mbcdm_cad.design.loader import resolved
    from mbcdm_cad.design.yamltree import Tree

    # By its name, as it needs this module.
    files: DesignFile = import_module("mbcdm_cad.layouts.siso_spur.design_file").DESIGN_FILE

    def made(file: dict[str, Any]) -> FirstStage:
        try:
            design = resolved(Tree(copy.deepcopy(file), {}), Path(FIRST_STAGE), files)
        except InputError as error:
            raise SizingError(*(_told(p.field, p.what, p.value, p.limit, p.remedy) for p in error.problems)) from None
        drive: Any = design.drive
        return FirstStage(drive, output_of(drive), design.sized)

    found = made(file)
    longer = SHELF_MM + found.output.shaft_diameter_mm
    if longer <= file["drum"]["shaft_end_mm"] or file["drum"]["shaft_end_mm"] != SHELF_MM + COLLAR_MM:
        return found
    return made({**file, "drum": {**file["drum"], "shaft_end_mm": longer}})


def gearhead_word(first: SpurDrive) -> str:
    """What a design file calls the gearhead of a first stage: none where a servo's own gears turn its input."""
    return NO_GEARHEAD if first.servo is not None else first.gearhead.name


def _told(field: str, what: str, value: str, limit: str, remedy: str) -> Broken:
    """A fault in the first stage's file, at the place of the whole file that it comes from."""
    block = field.partition(".")[0]
    if field == "travel.half_angle_deg":
        return Broken(
            ("first_stage",),
            "the drum of the first stage turns by the ratio of the second stage times the travel",
            f"{value} deg each way",
            limit,
            "lower transmission.input_to_drum, which raises first_stage.ratio, or lower the travel",
        )
    if block in ("loads", "drive", "catalogue"):
        return Broken(("first_stage",), f"{field} of the first stage: {what}", value, limit, remedy)
    path: FieldPath = ("first_stage", "design", *field.split("."))
    return Broken(path, what, value, limit, remedy)


def output_of(first: SpurDrive) -> CableStageOutput:
    """What a first stage is to the second one, in place of a gearhead.

    Figures that do not exist for it are 0: its own checks then fail with the reason.
    """
    from mbcdm_cad.layouts.siso_spur.support import FLANGE_SCREW, FLANGE_SCREWS, boss_flange
    from mbcdm_cad.layouts.structure import lash_rad
    from mbcdm_cad.model.si import ModelError
    from mbcdm_cad.parts.boss import BEARING_WALL_MM

    layout: Any = layout_of(first)
    flange, bearing = boss_flange(first), first.bearings.drum
    assert flange is not None
    peak = first.loads.peak_torque_Nm
    share = idle = 0.0
    stiffness: float | None = None
    with suppress(NoFigureError, ModelError, ValueError):
        share, idle = losses_of(layout)
        stiffness = 1e6 / urad_Nm(layout)
    levels = layout.levels
    # Without a place for them the second stage is sized for a boss as short as one bearing.
    near, far = 0.0, bearing.width_mm
    with suppress(NoFigureError):
        near, far = layout.drum_bearings_mm
    return CableStageOutput(
        name=FIRST_STAGE,
        source="the first stage of this file",
        ratio=first.total_ratio * first.reduction.ratio,
        efficiency=1.0 / (1.0 + share),
        rated_torque_mNm=peak * 1e3,
        max_torque_mNm=peak * 1e3,
        # Across the axis the front bearing decides; half its static rating (estimate).
        radial_load_N=bearing.static_rating_N / 2,
        bearing_span_mm=far - near,
        stiffness_Nm_rad=stiffness,
        diameter_mm=2 * flange.radius,
        length_mm=max(levels.hub_face_y, levels.encoder_top_z) - levels.back_y,
        shaft_diameter_mm=bearing.bore_mm,
        shaft_length_mm=first.drum.shaft_end_mm,
        pilot_diameter_mm=bearing.outer_diameter_mm + 2 * BEARING_WALL_MM,
        pilot_height_mm=flange.pilot,
        bolt_circle_mm=2 * max((x**2 + z**2) ** 0.5 for x, z in flange.screws),
        screw=FLANGE_SCREW,
        screw_count=FLANGE_SCREWS,
        mass_g=0.0,
        idle_torque_Nm=idle,
        lash_rad=lash_rad(first, motors_held=True),
    )


def losses_of(layout: SectorLayout) -> tuple[float, float]:
    """Loss of a drive over its output torque, and its loss without load, N m at its drum; the motor's own left out.

    The worse of both directions, from its losses at the peak torque and at a hundredth of it.
    """
    from mbcdm_cad.model.losses import MOTOR

    peak = layout.drive.loads.peak_torque_Nm
    train = layout.losses.with_drive(layout.loads.si)
    found = []
    for sense in (1.0, -1.0):
        moving = train.moving(sense * peak * np.array([0.01, 1.0]), 1)
        light, full = np.sum([x.torque_Nm for x in moving.losses if x.kind != MOTOR], axis=0)
        share = (full - light) / (0.99 * peak)
        found.append((float(share), float(full - share * peak)))
    return max(found, key=lambda pair: pair[0] * peak + pair[1])


def urad_Nm(layout: SectorLayout) -> float:
    """Turn of the end of the drum's shaft per N m there, the motor held: cables, all parts before, and that shaft."""
    from mbcdm_cad.layouts.structure import structure_of

    structure, shaft = structure_of(layout), layout.drum_shaft
    before = sum(cause.urad_Nm for cause in structure.causes if cause.at_encoder)
    return structure.cables_urad_Nm + before + shaft_urad_Nm(layout, shaft.flat_y - shaft.y_start)


def shaft_urad_Nm(layout: SectorLayout, length_mm: float) -> float:
    """Twist of the drum's shaft per N m over a length: 32 L / (pi G (D^4 - d^4))."""
    shaft, metal = layout.drum_shaft, layout.drive.shaft_material
    shear_MPa = metal.youngs_modulus_GPa * 1e3 / (2.0 * (1.0 + metal.poisson_ratio))
    polar_mm4 = pi / 2.0 * (shaft.radius**4 - shaft.bore_radius**4)
    return 1e9 * length_mm / (shear_MPa * polar_mm4)


def broken_first_stage(design: Any) -> Iterator[Broken]:
    """Rules of the block, and what is wrong in the file of the first stage."""
    block = design.first_stage
    if block is None:
        return
    for name in ("stage", "idlers"):
        if getattr(design, name) is not None:
            yield Broken((name,), "not beside first_stage", "", f"no {name}", "remove it, or remove first_stage")
            return
    if design.input_pulleys.overhung:
        what = "the first stage's shaft turns an input in bearings"
        remedy = "leave it out; first_stage.design may have it"
        yield Broken(("input_pulleys", "carried_by"), what, "motor", "bearings", remedy)
        return
    last = last_ratio(_fields(design))
    if block.total_ratio and block.ratio and abs(block.ratio * last / block.total_ratio - 1.0) > 1e-3:
        yield Broken(
            ("first_stage", "total_ratio"),
            "not the product of both ratios",
            f"{block.total_ratio:g}",
            f"{block.ratio:g} x {last:g} = {block.ratio * last:.6g}",
            "remove one of the three",
        )
        return
    try:
        of_design(design)
    except SizingError as error:
        yield from error.broken


# Begins the names of what belongs to the first stage.
FIRST = "first_"
# Beginnings of the names of parts that are the same in both stages.
_STANDARD = ("screw_", "insert_", "bearing_")


class FirstStageUnit(Attachment):
    """Stands back to back with the second stage, its drum's axis the input's, its input turned away from the drum."""

    block = "first_stage"

    @cached_property
    def unit(self) -> Any:
        """See the base class."""
        first = self.layout.drive.first_stage
        assert first is not None
        return type(self.layout)(first)

    @cached_property
    def place(self) -> Placement:
        """Where it stands: its boss on the motor shelf."""
        lay = self.layout
        y = lay.levels.motor_shelf_bottom_z + self.unit.levels.back_y
        return Placement.translation(0.0, y, lay.drive.centre_distance_mm) @ Placement.about((0.0, 0.0, 1.0), 180.0)

    @property
    def _bodies(self) -> dict[str, str]:
        """The bodies of the whole drive with which those of the first stage turn."""
        name, inputs = self.layout.drive.input_names[0], self.unit.drive.input_names
        return {"drum": f"input_{name}", **{f"input_{i}": f"driver_{name}" for i in inputs}}

    @property
    def checks(self) -> tuple[Check, ...]:
        """See the base class."""
        found: tuple[Check, ...] = self.layout.module("checks.stage").checks_of_first(self.unit)
        return found

    @property
    def passing_deg(self) -> Iterator[float]:
        """See the base class."""
        return (angle / self.layout.drive.total_ratio for angle in self.unit.passing_deg)

    def moving_bodies(self, body: MovingBody) -> Iterator[MovingBody]:
        """Its input, about +Y as it stands back to back."""
        if body.kind != "input":
            return
        drive, first = self.layout.drive, self.unit.drive
        turns = drive.drum_radius_mm * first.drum_radius_mm, drive.input_radius_mm * first.input_radius_mm
        at = (0.0, 0.0, drive.centre_distance_mm + first.centre_distance_mm)
        yield MovingBody(f"driver_{drive.input_names[0]}", "stage", at, (0.0, 1.0, 0.0), *turns)

    def add_items(self, b: BillBuilder, drum_angle_deg: float) -> None:
        """All its parts, their names with ``first_`` before them; its drum turns with the input."""
        own, groups = self.unit.bill(drum_angle_deg * self.layout.drive.total_ratio), {FIXED: FIXED, **self._bodies}
        for item in own.items:
            stem, what = first_name(item.part), own.parts[item.part]
            b.parts.setdefault(stem, PartSpec(stem, what.part, what.drilled))
            at, group = self.place @ item.location, groups[item.group]
            b.items.append(replace(item, name=first_name(item.name), part=stem, location=at, group=group))

    def cable_paths(self, drum_angle_rad: float) -> Iterator[CablePath]:
        """See the base class."""
        first = self.unit
        carry = partial(carried, rotation=self.place.rotation, shift_mm=self.place.shift_mm)
        for path in first.cable_paths(drum_angle_rad * self.layout.drive.total_ratio):
            stretches = tuple(replace(s, body=self._bodies.get(s.body or "")) for s in path.stretches)
            cable = replace(path.cable, name=f"{FIRST}{path.cable.name}")
            own = {"stretches": stretches, "diameter_mm": first.drive.cable.diameter_mm}
            yield replace(path.each(carry), cable=cable, drum_angle_rad=drum_angle_rad, **own)

    def steps_before(self) -> Iterator[AssemblyStep]:
        """The whole of it; what it is screwed on holds it in place of a base."""
        for step in self.unit.own_steps(based=False):
            yield AssemblyStep(f"First stage: {step.text}", tuple(first_name(name) for name in step.items))


def first_name(name: str) -> str:
    """Name of an item or a part of the first stage; parts of a standard, and cables, keep their beginning."""
    if name.startswith(CABLE):
        return f"{CABLE}{FIRST}{name.removeprefix(CABLE)}"
    return name if name.startswith(_STANDARD) else FIRST + name
