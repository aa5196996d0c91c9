"""From the validated design to the ``Drive``: references looked up, radii known for every cable, names made objects."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, TypeVar

from mbcdm_cad.design import drive as d
from mbcdm_cad.design.as_built import with_as_built
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.loaded import FieldPath

if TYPE_CHECKING:
    from pydantic import BaseModel

    from mbcdm_cad.design.entries import Entry
    from mbcdm_cad.design.schema import Design, Rope, Transmission

_T = TypeVar("_T")
_TARGETS: dict[str, type[Any]] = {
    "ropes": d.CableSpec,
    "motors": d.Motor,
    "gearheads": d.Gearhead,
    "encoders": d.Encoder,
    "bearings": d.Bearing,
    "screws": d.Screw,
    "tensioners": d.TensionerSpec,
    "materials": d.Material,
}
# Kinds of entries of the catalogue.
KINDS = tuple(_TARGETS)
_SIGN = {"-x": -1, "+x": 1}


class Catalogue:
    """The package's entries with the design's own laid over them."""

    def __init__(self, design: Design) -> None:
        self._own: dict[str, dict[str, Entry]] = {kind: getattr(design.catalogue, kind) for kind in KINDS}

    def names(self, kind: str) -> list[str]:
        """All names of a kind, the package's first, in the files' order."""
        return list(dict.fromkeys((*package_entries(kind), *self._own[kind])))

    def get(self, kind: str, name: str, **changed: Any) -> Any:
        """The entry as its dataclass of :mod:`mbcdm_cad.design.drive`, the values in ``changed`` laid over it.

        The package's entries are taken as they are: validating them at every start would cost a tenth of it, and a
        test does it. KeyError if neither the design nor the package holds the name.
        """
        own = self._own[kind].get(name)
        if own is not None:
            return _copied(_TARGETS[kind], own, name=name, **changed)
        values = {
            key: tuple(value) if isinstance(value, list) else value
            for key, value in package_entries(kind)[name].items()
        }
        return _TARGETS[kind](name=name, **{**values, **changed})


def resolve(design: Design, sigmas: Mapping[FieldPath, float]) -> d.Drive:
    """The ``Drive`` of a design that satisfies :func:`mbcdm_cad.design.rules.broken_rules`; ``sigmas`` by field."""
    catalogue = Catalogue(design)
    material: Callable[[str], d.Material] = lambda name: catalogue.get("materials", name)  # noqa: E731
    bearing: Callable[[str], d.Bearing] = lambda name: catalogue.get("bearings", name)  # noqa: E731
    drum, guide, pulleys, train = design.drum, design.guide, design.input_pulleys, design.drive
    declared = d.Drive(
        name=design.name,
        configuration=design.configuration,
        cables=_cables(design),
        input_names=tuple(item.name for item in design.inputs),
        input_sides=tuple(_SIGN[item.side] for item in design.inputs),
        centre_distance_mm=design.transmission.centre_distance_mm,
        half_travel_deg=design.travel.half_angle_deg,
        stop_clearance_deg=design.travel.stop_clearance_deg,
        cable=_rope(design.rope, catalogue),
        friction_coefficient=design.rope.friction_coefficient,
        helix_lead_mm=design.rope.helix_lead_mm,
        dead_turns=design.rope.dead_turns,
        radii_explicit=design.transmission.ratios is None,
        clearances=_copied(d.Clearances, design.clearances),
        motor=catalogue.get("motors", train.motor),
        gearhead=catalogue.get("gearheads", train.gearhead),
        encoder=catalogue.get("encoders", train.encoder),
        drum_encoder=catalogue.get("encoders", train.drum_encoder),
        bearings=d.Bearings(
            drum=bearing(drum.bearing),
            guide=bearing(guide.bearing),
            input_lower=bearing(pulleys.lower_bearing),
            input_upper=bearing(pulleys.upper_bearing),
        ),
        tensioner=catalogue.get("tensioners", drum.tensioner),
        drum=_copied(d.DrumSpec, drum, material=material(drum.material), shaft_material=material(drum.shaft_material)),
        guide=d.GuideSpec(material=material(guide.material), axle_material=material(guide.axle_material)),
        input_pulleys=d.InputPulleySpec(material=material(pulleys.material)),
        support=_copied(d.SupportSpec, design.support, material=material(design.support.material)),
        loads=_copied(d.Loads, design.loads),
        limits=_copied(d.Limits, design.limits),
        targets=_copied(d.Targets, design.targets),
        export=_copied(d.ExportSettings, design.export),
        waivers=tuple(_copied(d.Waiver, waiver) for waiver in design.waivers),
        screws=tuple(catalogue.get("screws", name) for name in catalogue.names("screws")),
        materials=tuple(catalogue.get("materials", name) for name in catalogue.names("materials")),
        sigmas=_sigmas(design, catalogue, sigmas),
        as_built=(),
    )
    return with_as_built(declared, _as_built(design))


def _as_built(design: Design) -> tuple[d.AsBuilt, ...]:
    return tuple(
        _copied(d.AsBuilt, entry, values=tuple(_copied(d.AsBuiltValue, value) for value in entry.values))
        for entry in design.as_built
    )


def pitch_radii_mm(transmission: Transmission) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Guide and input pitch radii by step, from the ratios or as given.

    Radii from ratios are rounded to 1e-9 mm, so that 57.6/6 reads 9.6 in reports and not 9.600000000000001.
    """
    if transmission.ratios is None:
        return transmission.guide_radii_mm or (), transmission.input_radii_mm or ()
    ratios = transmission.ratios
    guide = tuple(round(radius / ratios.guide_to_drum, 9) for radius in transmission.drum_radii_mm)
    return guide, tuple(round(radius / ratios.input_to_guide, 9) for radius in guide)


def _cables(design: Design) -> tuple[d.CableRun, ...]:
    guide, pulley = pitch_radii_mm(design.transmission)
    sides = {item.name: _SIGN[item.side] for item in design.inputs}
    return tuple(
        d.CableRun(
            name=cable.name,
            input_name=cable.input,
            input_side=sides[cable.input],
            drum_side=_SIGN[cable.drum_side],
            step=cable.step,
            input_radius_mm=pulley[cable.step - 1],
            guide_radius_mm=guide[cable.step - 1],
            drum_radius_mm=design.transmission.drum_radii_mm[cable.step - 1],
            preload_N=design.rope.preload_N if cable.preload_N is None else cable.preload_N,
        )
        for cable in sorted(design.cables, key=lambda cable: cable.step)
    )


def _sigmas(design: Design, catalogue: Catalogue, given: Mapping[FieldPath, float]) -> d.Sigmas:
    """Standard deviations of what the ``Drive`` holds: those of a field that another overrides do not count."""

    def of(*path: str | int) -> float:
        return given.get(path, 0.0)

    rope, spec = design.rope, _rope(design.rope, catalogue)
    entry: FieldPath = ("rope", "inline") if rope.inline is not None else ("catalogue", "ropes", rope.type or "")
    own_modulus = rope.inline is None and rope.modulus_GPa is not None
    area = of(*entry, "metallic_area_mm2")
    if spec.modulus_area == "nominal":
        area = 2.0 * spec.area_mm2 / spec.diameter_mm * of(*entry, "diameter_mm")
    order = sorted(range(len(design.cables)), key=lambda index: design.cables[index].step)
    steps = [design.cables[index].step - 1 for index in order]
    return d.Sigmas(
        preload_N=tuple(
            of("rope", "preload_N") if design.cables[index].preload_N is None else of("cables", index, "preload_N")
            for index in order
        ),
        input_radius_mm=tuple(of("transmission", "input_radii_mm", step) for step in steps),
        guide_radius_mm=tuple(of("transmission", "guide_radii_mm", step) for step in steps),
        drum_radius_mm=tuple(of("transmission", "drum_radii_mm", step) for step in steps),
        centre_distance_mm=of("transmission", "centre_distance_mm"),
        friction_coefficient=of("rope", "friction_coefficient"),
        modulus_GPa=of("rope", "modulus_GPa") if own_modulus else of(*entry, "modulus_GPa"),
        area_mm2=area,
        test_torque_Nm=of("loads", "test_torque_Nm"),
        motor_torque_mNm=of("catalogue", "motors", design.drive.motor, "rated_torque_mNm"),
    )


def _rope(rope: Rope, catalogue: Catalogue) -> d.CableSpec:
    if rope.inline is not None:
        return _copied(d.CableSpec, rope.inline, name="inline")
    changed = {} if rope.modulus_GPa is None else {"modulus_GPa": rope.modulus_GPa, "modulus_area": rope.modulus_area}
    spec: d.CableSpec = catalogue.get("ropes", rope.type or "", **changed)
    return spec


def _copied(target: type[_T], block: BaseModel, **given: Any) -> _T:
    """``target`` with the fields of the same name in ``block``, those in ``given`` taking precedence."""
    names = [item.name for item in fields(target)]  # type: ignore[arg-type]
    return target(**{name: given[name] if name in given else getattr(block, name) for name in names})
