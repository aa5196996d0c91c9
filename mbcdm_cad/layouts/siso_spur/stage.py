"""The attachment of belt or gears between the motor and an input."""

from collections.abc import Iterator
from dataclasses import replace

from mbcdm_cad.layouts.base import Attachment
from mbcdm_cad.layouts.siso_spur.cable_path import turned
from mbcdm_cad.parts.bill import ALONG_Y, BillBuilder, MovingBody, Placement
from mbcdm_cad.parts.coupling import Belt, Wheel, belt_bottom_mm

# Linear RGB.
_RUBBER = (0.015, 0.015, 0.017)


class BeltOrGears(Attachment):
    """The driving wheel stands beyond the input, as seen from the drum."""

    block = "stage"

    def moving_bodies(self, body: MovingBody) -> Iterator[MovingBody]:
        """The driving wheel of an input."""
        drive = self.layout.drive
        if body.kind == "input":
            name = body.name.removeprefix("input_")
            angle = drive.angles_rad[drive.input_names.index(name)]
            at = turned(angle, 0.0, drive.centre_distance_mm + drive.stage.centre_mm)
            turns = body.numerator_mm * drive.stage.ratio * drive.stage.sense
            yield MovingBody(f"driver_{name}", "stage", at, body.axis, turns, body.denominator_mm)

    def add_on_input(self, b: BillBuilder, name: str, turn: Placement) -> None:
        """Both wheels, and the belt."""
        drive, dims = self.layout.drive, self.layout.stage
        metal = drive.material("aluminium-7075" if dims.stage.is_belt else "steel")
        at = turn @ ALONG_Y @ Placement.translation(0.0, 0.0, dims.bottom_z)
        for part, spec, body in (("driven", dims.driven, "input"), ("driver", dims.driver, "driver")):
            b.add(
                f"stage_{part}_{name}",
                Wheel(spec),
                part=f"stage_{part}",
                material=metal,
                group=f"{body}_{name}",
                place=at,
                mass_g=dims.mass_g(spec),
            )
        if dims.belt is not None:
            # The belt is drawn with the driver at +Y; turned, it is away from the drum.
            stand = turn @ Placement.translation(0.0, 0.0, drive.centre_distance_mm) @ ALONG_Y
            bottom = Placement.translation(0.0, 0.0, dims.bottom_z + belt_bottom_mm())
            b.add(
                f"stage_belt_{name}",
                Belt(dims.belt),
                part="stage_belt",
                material=replace(drive.material("stainless"), colour=_RUBBER),
                place=stand @ Placement.about((0.0, 0.0, 1.0), 180.0) @ bottom,
                mass_g=dims.mass_g(dims.belt),
            )
