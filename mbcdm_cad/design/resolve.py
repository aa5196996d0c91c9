"""The catalogue of one design, the shared part of a ``Drive`` from the validated design, and the drive as built.

The package's entries are overridden by the design's own. Effects found on the built drive change values of the design:
modulus, preload, friction. The others have no value in the design file: they stay in ``Drive.as_built``, and the loop
predicts with them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from mbcdm_cad.design import bought
from mbcdm_cad.design.blocks import AsBuilt, AsBuiltValue, Cable, Design, Rope
from mbcdm_cad.design.catalogue import KINDS, package_entries
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.stage import stage_of
from mbcdm_cad.design.yamltree import FieldPath


class Catalogue:
    """Entries by kind and name, of the package and of a design."""

    def __init__(self, design: Design) -> None:
        self._nozzle_mm = design.printing.nozzle_mm
        self._own: dict[str, dict[str, bought.Entry]] = {kind: getattr(design.catalogue, kind) for kind in KINDS}

    def names(self, kind: str) -> list[str]:
        """All names of a kind, the package's first, in the files' order."""
        return list(dict.fromkeys((*package_entries(kind), *self._own[kind])))

    def has(self, kind: str, name: str) -> bool:
        """Whether there is an entry called ``name``."""
        return name in self._own[kind] or name in package_entries(kind)

    def get(self, kind: str, name: str, **changed: Any) -> Any:
        """The entry, an object of its class in ``KINDS``, with the values in ``changed`` replaced.

        The package's entries are not validated at every start, which would take a tenth of its time; a test validates
        them. KeyError if neither the design nor the package has the name.
        """
        own = self._own[kind].get(name)
        if own is not None:
            return replace(own, name=name, **changed)
        found = _bought(kind, name)
        return replace(found, **changed) if changed else found

    def material(self, name: str) -> bought.Material:
        """The material called ``name``, its thinnest wall that of the design's nozzle where it is printed."""
        if name not in self._own["materials"]:
            return _material(name, self._nozzle_mm)
        return _printed_with(self.get("materials", name), self._nozzle_mm)

    def bearing(self, name: str) -> bought.Bearing:
        """The bearing called ``name``."""
        found: bought.Bearing = self.get("bearings", name)
        return found

    def all(self, kind: str) -> tuple[Any, ...]:
        """Every entry of a kind."""
        return tuple(self.get(kind, name) for name in self.names(kind)) if self._own[kind] else _all(kind)

    def materials(self) -> tuple[bought.Material, ...]:
        """Every material, as :meth:`material`."""
        if self._own["materials"]:
            return tuple(self.material(name) for name in self.names("materials"))
        return _materials(self._nozzle_mm)


@cache
def _bought(kind: str, name: str) -> Any:
    """One of the package's entries; cached, since a search needs the same ones again."""
    values: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value for key, value in package_entries(kind)[name].items()
    }
    return KINDS[kind](name=name, **values)


@cache
def _all(kind: str) -> tuple[Any, ...]:
    return tuple(_bought(kind, name) for name in package_entries(kind))


@cache
def _material(name: str, nozzle_mm: float) -> bought.Material:
    return _printed_with(_bought("materials", name), nozzle_mm)


@cache
def _materials(nozzle_mm: float) -> tuple[bought.Material, ...]:
    return tuple(_material(name, nozzle_mm) for name in package_entries("materials"))


def _printed_with(found: bought.Material, nozzle_mm: float) -> bought.Material:
    return replace(found, min_wall_mm=bought.least_wall_mm(found.process, found.min_wall_mm, nozzle_mm))


def shared_values(design: Design, catalogue: Catalogue) -> dict[str, Any]:
    """The fields of :class:`~mbcdm_cad.design.drive.Drive` that follow from shared blocks.

    All except cables, sigmas, and the winding on the inputs (``helix_lead_mm``, ``dead_turns``). Effects found on the
    built drive are left out; the loader adds them.
    """
    train, rope, ends = design.drive, _rope(design.rope, catalogue), catalogue.all("terminations")
    motor: bought.Motor = catalogue.get("motors", train.motor)
    absent = train.gearhead == bought.NO_GEARHEAD
    gearhead: bought.Gearhead = bought.without_gearhead(motor) if absent else catalogue.get("gearheads", train.gearhead)
    stage = None if design.stage is None else stage_of(design.stage)
    turns = gearhead.ratio * (1.0 if stage is None else stage.ratio)

    def encoder(name: str) -> bought.Encoder:
        found: bought.Encoder = (
            bought.without_encoder(gearhead, turns) if name == bought.NO_ENCODER else catalogue.get("encoders", name)
        )
        return found

    return {
        "name": design.name,
        "configuration": design.configuration,
        "input_names": tuple(item.name for item in design.inputs),
        "half_travel_deg": design.travel.half_angle_deg,
        "travel_from_deg": design.travel.from_deg,
        "stop_clearance_deg": design.travel.stop_clearance_deg,
        "cable": rope,
        "terminations": ends,
        "termination": termination(design.rope.termination, ends, rope),
        "friction_coefficient": design.rope.friction_coefficient,
        "cut_tolerance_mm": design.rope.cut_tolerance_mm,
        "motor": motor,
        "gearhead": gearhead,
        "gearhead_angle_deg": train.gearhead_angle_deg,
        "bus_voltage_V": motor.voltage_V if train.bus_voltage_V is None else train.bus_voltage_V,
        "encoder": encoder(train.encoder),
        "drum_encoder": encoder(train.drum_encoder),
        "loads": design.loads,
        "limits": design.limits,
        "making": design.making,
        "printing": design.printing,
        "targets": design.targets,
        "export": design.export,
        "waivers": design.waivers,
        "screws": catalogue.all("screws"),
        "inserts": catalogue.all("inserts"),
        "materials": catalogue.materials(),
        "as_built": (),
        "stage": stage,
    }


def by_step(cables: Sequence[Any]) -> list[int]:
    """Indices of the file's cables, each of which has a ``step``, in the order of their steps."""
    return sorted(range(len(cables)), key=lambda k: cables[k].step)


def preload_N(design: Design, cable: Cable) -> float:
    """Preload of a cable, N: its own, else the rope's."""
    return design.rope.preload_N if cable.preload_N is None else cable.preload_N


def shared_sigmas(
    design: Design, catalogue: Catalogue, given: Mapping[FieldPath, float], cables: Sequence[int]
) -> dict[str, Any]:
    """Standard deviations of what shared blocks give; those of a field that another overrides do not count.

    ``cables``: places of the file's cables in the order in which the drive has them.
    """

    def of(*path: str | int) -> float:
        return given.get(path, 0.0)

    rope, spec = design.rope, _rope(design.rope, catalogue)
    entry: FieldPath = ("rope", "inline") if rope.inline is not None else ("catalogue", "ropes", rope.type or "")
    own_modulus = rope.inline is None and rope.modulus_GPa is not None
    area = of(*entry, "metallic_area_mm2")
    if spec.modulus_area == "nominal":
        area = 2.0 * spec.area_mm2 / spec.diameter_mm * of(*entry, "diameter_mm")
    return {
        "preload_N": tuple(
            of("rope", "preload_N") if design.cables[k].preload_N is None else of("cables", k, "preload_N")
            for k in cables
        ),
        "friction_coefficient": of("rope", "friction_coefficient"),
        "modulus_GPa": of("rope", "modulus_GPa") if own_modulus else of(*entry, "modulus_GPa"),
        "area_mm2": area,
        "test_torque_Nm": of("loads", "test_torque_Nm"),
        "motor_torque_mNm": of("catalogue", "motors", design.drive.motor, "rated_torque_mNm"),
    }


def termination(
    name: str | None, known: Sequence[bought.TerminationSpec], rope: bought.CableSpec
) -> bought.TerminationSpec:
    """The named termination, else the strongest that fits the rope, else the strongest, which a check then fails."""
    if name is not None:
        return next(each for each in known if each.name == name)
    return max(known, key=lambda each: (each.fits(rope), each.strength_share))


def _rope(rope: Rope, catalogue: Catalogue) -> bought.CableSpec:
    if rope.inline is not None:
        return replace(rope.inline, name="inline")
    changed = {} if rope.modulus_GPa is None else {"modulus_GPa": rope.modulus_GPa, "modulus_area": rope.modulus_area}
    spec: bought.CableSpec = catalogue.get("ropes", rope.type or "", **changed)
    return spec


# Forms, by name of the effect, whose figure "share" is the relative change of a value that the design declares.
CHANGE_VALUES = {
    "stiffness_error": ("modulus of the rope",),
    "preload_error": ("all cables", "one cable"),
    "cable_friction": ("rope on pulley",),
}
# Half a 95 % interval in standard deviations.
HALF_95 = 1.96


def with_as_built(drive: Drive, found: tuple[AsBuilt, ...]) -> Drive:
    """``drive`` as built: each entry of ``found`` changes a value and widens its sigma, or is kept for the loop."""
    for entry in found:
        if entry.form in CHANGE_VALUES.get(entry.name, ()):
            share = next(value for value in entry.values if value.name == "share")
            drive = _CHANGES[entry.name](drive, entry, share)
        else:
            drive = replace(drive, as_built=(*drive.as_built, entry))
    return drive


def _widened(sigma: float, value: float, share: AsBuiltValue) -> float:
    """Standard deviation of ``value * (1 + share)``, ``value`` with ``sigma``."""
    own = 0.0 if share.low is None or share.high is None else (share.high - share.low) / (2.0 * HALF_95)
    return float(((sigma * (1.0 + share.value)) ** 2 + (value * own) ** 2) ** 0.5)


def _modulus(drive: Drive, _: AsBuilt, share: AsBuiltValue) -> Drive:
    value = drive.cable.modulus_GPa
    sigmas = replace(drive.sigmas, modulus_GPa=_widened(drive.sigmas.modulus_GPa, value, share))
    return replace(drive, cable=replace(drive.cable, modulus_GPa=value * (1.0 + share.value)), sigmas=sigmas)


def _preload(drive: Drive, entry: AsBuilt, share: AsBuiltValue) -> Drive:
    cables, sigmas = [], []
    for cable, sigma in zip(drive.cables, drive.sigmas.preload_N, strict=True):
        has_it = not entry.cables or cable.name in entry.cables
        cables.append(replace(cable, preload_N=cable.preload_N * (1.0 + share.value)) if has_it else cable)
        sigmas.append(_widened(sigma, cable.preload_N, share) if has_it else sigma)
    return replace(drive, cables=tuple(cables), sigmas=replace(drive.sigmas, preload_N=tuple(sigmas)))


def _friction(drive: Drive, _: AsBuilt, share: AsBuiltValue) -> Drive:
    value = drive.friction_coefficient
    sigmas = replace(drive.sigmas, friction_coefficient=_widened(drive.sigmas.friction_coefficient, value, share))
    return replace(drive, friction_coefficient=value * (1.0 + share.value), sigmas=sigmas)


_CHANGES = {"stiffness_error": _modulus, "preload_error": _preload, "cable_friction": _friction}
