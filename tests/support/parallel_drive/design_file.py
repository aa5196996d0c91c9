"""The design file of the parallel drive: its own block, and its drive."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from mbcdm_cad.design.blocks import Cable, Design, Input, Length, SpanLimits, WoundRope
from mbcdm_cad.design.drive import CableRun, Drive, Sigmas
from mbcdm_cad.design.fields import Block, choice, quantity
from mbcdm_cad.design.loader import DesignFile
from mbcdm_cad.design.resolve import Catalogue, preload_N, shared_sigmas, shared_values
from mbcdm_cad.design.rules import Broken, NamedEntry
from mbcdm_cad.design.yamltree import FieldPath


class Transmission(Block):
    """Pitch radii and where the input stands."""

    centre_distance_mm: Length = quantity("drum axis to input axis", source="test")
    drum_radius_mm: Length = quantity("pitch radius of the drum", source="test")
    input_radius_mm: Length = quantity("pitch radius of the input", source="test")


class ParallelCable(Cable):
    """A cable and the sense in which it pulls the drum."""

    sense: Literal[-1, 1] = choice("sense in which it turns the drum", source="test")


class ParallelDesign(Design):
    """One input, two cables."""

    configuration: Literal["parallel_test"] = choice("layout of the drive", source="test")
    transmission: Transmission
    rope: WoundRope
    limits: SpanLimits
    inputs: tuple[Input, ...] = choice("the input", source="test", min_length=1, max_length=1)
    cables: tuple[ParallelCable, ...] = choice("the cables", source="test", min_length=2, max_length=2)


@dataclass(frozen=True)
class ParallelRun(CableRun):
    """A cable with its sense on the drum."""

    sigma: int


@dataclass(frozen=True)
class ParallelDrive(Drive):
    """What the parallel drive has beyond what all drives have."""

    cables: tuple[ParallelRun, ...]
    centre_distance_mm: float


def _drive(design: ParallelDesign, catalogue: Catalogue, sigmas: Mapping[FieldPath, float]) -> ParallelDrive:
    lengths = design.transmission
    runs = tuple(
        ParallelRun(
            name=cable.name,
            input_name=cable.input,
            input_radius_mm=lengths.input_radius_mm,
            drum_radius_mm=lengths.drum_radius_mm,
            preload_N=preload_N(design, cable),
            sigma=cable.sense,
        )
        for cable in design.cables
    )
    places = range(len(runs))
    return ParallelDrive(
        **shared_values(design, catalogue),
        helix_lead_mm=design.rope.helix_lead_mm,
        dead_turns=design.rope.dead_turns,
        cables=runs,
        sigmas=Sigmas(**shared_sigmas(design, catalogue, sigmas, places)),
        centre_distance_mm=lengths.centre_distance_mm,
    )


def _nothing(design: ParallelDesign) -> Iterator[Broken]:
    yield from ()


def _none_named(design: ParallelDesign) -> Iterator[NamedEntry]:
    yield from ()


DESIGN_FILE = DesignFile(ParallelDesign, {}, _nothing, _none_named, _drive)
