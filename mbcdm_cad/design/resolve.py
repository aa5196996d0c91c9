"""Make the shared part of a ``Drive`` from the validated design, for all configurations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

from mbcdm_cad.design.blocks import Cable, Design, Rope
from mbcdm_cad.design.bought import (
    NO_ENCODER,
    NO_GEARHEAD,
    CableSpec,
    Encoder,
    Gearhead,
    Motor,
    TerminationSpec,
    without_encoder,
    without_gearhead,
)
from mbcdm_cad.design.fieldpath import FieldPath
from mbcdm_cad.design.lookup import Catalogue
from mbcdm_cad.design.stage import stage_of


class SteppedCable(Protocol):
    """A cable whose step of the pulleys the file states."""

    @property
    def step(self) -> int:
        """From 1, the smallest."""


def shared_values(design: Design, catalogue: Catalogue) -> dict[str, Any]:
    """The fields of :class:`~mbcdm_cad.design.drive.Drive` that follow from shared blocks.

    All except cables, sigmas, and the winding on the inputs (``helix_lead_mm``, ``dead_turns``). Effects found on the
    built drive are left out; the loader adds them.
    """
    train, rope, ends = design.drive, _rope(design.rope, catalogue), catalogue.all("terminations")
    motor: Motor = catalogue.get("motors", train.motor)
    absent = train.gearhead == NO_GEARHEAD
    gearhead: Gearhead = without_gearhead(motor) if absent else catalogue.get("gearheads", train.gearhead)
    stage = None if design.stage is None else stage_of(design.stage)
    turns = gearhead.ratio * (1.0 if stage is None else stage.ratio)

    def encoder(name: str) -> Encoder:
        found: Encoder = without_encoder(gearhead, turns) if name == NO_ENCODER else catalogue.get("encoders", name)
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


def by_step(cables: Sequence[SteppedCable]) -> list[int]:
    """Indices of the file's cables in the order of their steps."""
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


def termination(name: str | None, known: Sequence[TerminationSpec], rope: CableSpec) -> TerminationSpec:
    """The named termination, else the strongest that fits the rope, else the strongest, which a check then fails."""
    if name is not None:
        return next(each for each in known if each.name == name)
    return max(known, key=lambda each: (each.fits(rope), each.strength_share))


def _rope(rope: Rope, catalogue: Catalogue) -> CableSpec:
    if rope.inline is not None:
        return replace(rope.inline, name="inline")
    changed = {} if rope.modulus_GPa is None else {"modulus_GPa": rope.modulus_GPa, "modulus_area": rope.modulus_area}
    spec: CableSpec = catalogue.get("ropes", rope.type or "", **changed)
    return spec
