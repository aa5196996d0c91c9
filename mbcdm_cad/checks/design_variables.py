"""Parameters of a design that a remedy may change, under the names they have in the design file."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields, replace
from functools import reduce
from typing import Any, NamedTuple

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.paths import at

ALL_RADII = "all radii of transmission"
ROPE_DIAMETER = "rope diameter_mm"


class DesignVariable(NamedTuple):
    """A parameter under the name it has in the design file.

    ``asked``: it says what the drive is for, so that a remedy names it last. ``scale``: its value is a factor on a list
    of radii. ``applies``: whether the design file gives it. ``shown``: its name in a remedy and what to add there,
    where these depend on the design. ``short``: the field that states it in a file of requirements, and the value of
    that field.
    """

    path: str
    get: Callable[[Any], float]
    put: Callable[[Any, float], Drive]
    scale: bool = False
    applies: Callable[[Any], bool] = lambda drive: True
    shown: Callable[[Any], tuple[str, str]] | None = None
    asked: bool = False
    short: tuple[str, Callable[[Any], float]] | None = None


class Adjustment(NamedTuple):
    """A design variable and the sense in which to change it, +1 up or -1 down."""

    path: str
    sense: int


def up(*paths: str) -> tuple[Adjustment, ...]:
    """Raise one of the design variables."""
    return tuple(Adjustment(path, 1) for path in paths)


def down(*paths: str) -> tuple[Adjustment, ...]:
    """Lower one of them."""
    return tuple(Adjustment(path, -1) for path in paths)


def _set_in(block: Any, names: list[str], value: float) -> Any:
    inner = value if len(names) == 1 else _set_in(getattr(block, names[0]), names[1:], value)
    return replace(block, **{names[0]: inner})


def field(path: str, attributes: str = "", *, asked: bool = False) -> DesignVariable:
    """A number of the drive; ``attributes`` is where the drive holds it, if not under ``path``."""
    names = (attributes or path).split(".")
    return DesignVariable(
        path,
        lambda drive: float(reduce(getattr, names, drive)),
        lambda drive, value: _set_in(drive, names, value),
        asked=asked,
    )


def lengths(block: str, kind: Any) -> Iterator[DesignVariable]:
    """The lengths that the class of a block of the drive declares."""
    return (field(f"{block}.{one.name}") for one in fields(kind) if one.name.endswith("_mm"))


def radii(path: str, attributes: tuple[str, ...]) -> DesignVariable:
    """A factor on the radii of all cables that ``attributes`` names."""

    def put(drive: Drive, factor: float) -> Drive:
        return _of_cables(drive, lambda c: {name: getattr(c, name) * factor for name in attributes})

    return DesignVariable(path, lambda drive: 1.0, put, scale=True, asked=True)


def _of_cables(drive: Drive, changes: Callable[[Any], dict[str, Any]]) -> Drive:
    return replace(drive, cables=tuple(replace(cable, **changes(cable)) for cable in drive.cables))


def _preload(drive: Drive, value: float) -> Drive:
    factor = value / drive.cables[0].preload_N
    return _of_cables(drive, lambda c: {"preload_N": c.preload_N * factor})


def by_path(variables: Iterable[DesignVariable]) -> dict[str, DesignVariable]:
    """The variables by their names."""
    return {variable.path: variable for variable in variables}


LESS_TORQUE = down(at.loads.peak_torque_Nm)
# Of a drive whose input turns the drum itself.
INPUT_TO_DRUM = DesignVariable(
    at.transmission.input_to_drum,
    lambda drive: drive.total_ratio,
    lambda drive, value: _of_cables(drive, lambda c: {"input_radius_mm": c.drum_radius_mm / value}),
    applies=lambda drive: not drive.radii_explicit,
)
DRUM = tuple(
    field(f"drum.{name}")
    for name in (
        "sector_half_angle_deg",
        "rim_inner_radius_mm",
        "outer_face_y_mm",
        "web_thickness_mm",
        "hub_diameter_mm",
        "hub_face_y_mm",
        "shaft_bore_mm",
    )
)
SHARED = (
    field(at.travel.half_angle_deg, "half_travel_deg", asked=True)._replace(
        short=(at.travel.to_deg, lambda d: 2 * d.half_travel_deg + (d.travel_from_deg or 0.0))
    ),
    field(at.travel.stop_clearance_deg, "stop_clearance_deg"),
    DesignVariable(at.rope.preload_N, lambda drive: drive.cables[0].preload_N, _preload),
    field(ROPE_DIAMETER, "cable.diameter_mm", asked=True),
    field(at.loads.test_torque_Nm, asked=True),
    field(at.loads.peak_torque_Nm, asked=True),
)
