"""The layout of the parallel drive: its dimensions by plain arithmetic, in mm, its checks, and what the report says."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from math import degrees, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks import motors, strength
from mbcdm_cad.checks.comparison import Family, Findings, at_most, check, families
from mbcdm_cad.checks.design_variables import SHARED, DesignVariable, by_path, down, field
from mbcdm_cad.checks.ratios import BENDING
from mbcdm_cad.design.loader import DesignFile
from mbcdm_cad.layouts.base import Conventions, Layout
from mbcdm_cad.parts.bill import AssemblyStep, Bill, MovingBody
from mbcdm_cad.routes.curves import CablePath
from mbcdm_cad.routes.route import RoutedDrive
from parallel_drive import parts, routes
from parallel_drive.design_file import DESIGN_FILE, ParallelDrive


class ParallelLayout(Layout):
    """One design; heights are along Y from the base up. The two cables run in planes beside the middle."""

    name = "parallel_test"
    title = "one input and a drum on parallel axes, for the tests"
    conventions = Conventions(
        frame="Frame: the drum's axis is Y; the input stands at x = +L, its axis along -Y.",
        cables="Cables are round rods at the nominal diameter, each in its own plane.",
    )
    drive: ParallelDrive
    half_width = 3.0
    base_top = -4.0
    base_thickness = 3.0

    @classmethod
    def design_file(cls) -> DesignFile:
        """Schema, rules and the drive of a file."""
        return DESIGN_FILE

    @classmethod
    def check_families(cls) -> tuple[Family, ...]:
        """One family: the checks below."""
        return (Family("Checks of the layout for tests", CHECKS),)

    @classmethod
    def path_lines(cls, cable: dict[str, Any]) -> Iterator[str]:
        """One line a cable."""
        yield f"  {cable['name']}: length {cable['length_mm']:.2f} mm"

    @classmethod
    def paths_template(cls) -> str:
        """The report's table of lengths."""
        return (
            "| cable | length mm |\n| --- | --- |\n"
            "{% for c in r.paths.cables %}| {{ c.name }} | {{ '%.2f' % c.length_mm }} |\n{% endfor %}\n"
        )

    def refuse_impossible(self) -> None:
        """Raise ValueError where the pulleys overlap."""
        run = self.drive.cables[0]
        if self.drive.centre_distance_mm <= run.input_radius_mm + run.drum_radius_mm:
            raise ValueError(f"centre distance {self.drive.centre_distance_mm} mm leaves no free span")

    @property
    def input_radius(self) -> float:
        """Surface of the input pulley under the cable."""
        return self.drive.cables[0].input_radius_mm - self.drive.cable.diameter_mm / 2

    @property
    def drum_radius(self) -> float:
        """Surface of the drum under the cable."""
        return self.drive.cables[0].drum_radius_mm - self.drive.cable.diameter_mm / 2

    @cached_property
    def routed(self) -> RoutedDrive:
        """How the cables run."""
        return routes.routed(self.drive)

    @cached_property
    def inertias_kg_m2(self) -> Mapping[str, float]:
        """Input pulley and drum as solid cylinders: pi/2 rho w R^4."""
        density = self.drive.material("aluminium-7075").density_g_cm3 * 1e3
        width = 2 * self.half_width * 1e-3
        radii = {f"input_{self.drive.input_names[0]}": self.input_radius, "drum": self.drum_radius}
        return {name: pi / 2 * density * width * (radius * 1e-3) ** 4 for name, radius in radii.items()}

    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Arc on the input, crossed span, arc on the drum."""
        self.require_geometry()
        return tuple(routes.cable_path(self.drive, run, drum_angle_rad) for run in self.drive.cables)

    @cached_property
    def path_figures(self) -> routes.ParallelFigures:
        """Lengths and wraps over the travel."""
        self.require_geometry()
        return routes.path_figures(self.drive)

    @cached_property
    def moving_bodies(self) -> tuple[MovingBody, ...]:
        """Drum and input."""
        return parts.moving_bodies(self)

    def bill(self, drum_angle_deg: float = 0.0) -> Bill:
        """Parts and instances."""
        self.require_geometry()
        return parts.bill(self, drum_angle_deg)

    @cached_property
    def assembly_order(self) -> tuple[AssemblyStep, ...]:
        """One step."""
        return parts.assembly_order(self)

    # The base is taken as rigid, no gap is stacked up, and how preloads are set is left open.
    frame_study = None
    tolerance_stacks = ()
    tensioning = None

    @property
    def variables(self) -> Mapping[str, DesignVariable]:
        """The shared ones and the centre distance."""
        return by_path((*SHARED, field("centre_distance_mm")))

    def wraps_rad(self, drum_angle_rad: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """See the base class."""
        both = np.array([routes.wraps_rad(self.drive, run, drum_angle_rad) for run in self.drive.cables])
        return both[:, 0], both[:, 1]

    def bends_mm(self) -> Sequence[tuple[str, str, float]]:
        """Input pulley and drum."""
        return [
            (run.name, body, radius)
            for run in self.drive.cables
            for body, radius in (("input pulley", run.input_radius_mm), ("drum", run.drum_radius_mm))
        ]


@check("Wrap on the input under a turn", "derived", *down("travel.half_angle_deg"))
def input_wrap(design: ParallelLayout) -> Findings:
    """The cable stays in its plane, so that its wrap on the input is under a turn."""
    ends = (-design.half_travel_rad, design.half_travel_rad)
    for angle in ends:
        yield at_most("largest wrap on the input", degrees(float(design.wraps_rad(angle)[0].max())), 350.0, "deg")


CHECKS = (*BENDING, *families(strength)[0].checks, *families(motors)[0].checks, input_wrap)
LAYOUT = ParallelLayout
