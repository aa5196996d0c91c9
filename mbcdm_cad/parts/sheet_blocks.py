"""Blocks of a sheet: tables, labels, marks and fits of holes; profile and dimensions of a turned part."""

from collections.abc import Sequence
from dataclasses import dataclass

from mbcdm_cad.parts.fits import GeometricTolerance as Tolerance
from mbcdm_cad.parts.sheet import (
    POSITION,
    FitLine,
    Holes,
    Label,
    Linear,
    Radius,
    Side,
    Table,
    Vector,
    View,
    X,
    Y,
    Z,
    mm,
)

THROUGH = "through"
# Place of a hole for a screw or a key, plus or minus: half the play of a screw in its hole (ISO 273, fine).
FREE_POSITION_MM = 0.1
COLUMNS = ("Hole", "No.", "%%c", "Thread", "Depth", "Fit", "Counterbore", "From")


def hole_table(groups: Sequence[Holes]) -> Table:
    """One line for each group of equal holes."""
    return Table("Holes", COLUMNS, tuple(group.row() for group in groups))


def position_table(groups: Sequence[Holes], axes: tuple[int, int], title: str) -> Table:
    """One line for each hole; ``axes`` are the two coordinates (0 x, 1 y, 2 z) shown, both within the last column."""
    heads = (*("XYZ"[a] for a in axes), "%%p")
    rows = tuple(
        (name, *(mm(place[a], 3) for a in axes), _tolerance(group, place, axes))
        for group in groups
        for name, place in zip(group.names, group.places, strict=True)
    )
    return Table(title, ("Hole", *heads), rows)


def _tolerance(group: Holes, place: Vector, axes: tuple[int, int]) -> str:
    """Tolerance of both coordinates: close for a hole with a fit, none for the hole from which others are measured."""
    fitted = group.fit or (group.counterbore is not None and group.counterbore[2])
    if fitted and not any(place[a] for a in axes):
        return ""
    return POSITION if fitted else mm(FREE_POSITION_MM)


def hole_labels(groups: Sequence[Holes], view: str) -> tuple[Label, ...]:
    """The name of each hole beside it."""
    return tuple(
        Label(view, place, name, clear_mm=group.reach)
        for group in groups
        for name, place in zip(group.names, group.places, strict=True)
    )


def hole_marks(
    groups: Sequence[Holes], across: Vector, up: Vector, z: float | None = None
) -> tuple[tuple[Vector, Vector], ...]:
    """Centre lines of holes seen from their end: at the height ``z``, or each at that of its hole."""
    marks = []
    for group in groups:
        reach = group.reach + 0.8
        for x, y, own in group.places:
            place = (x, y, own if z is None else z)
            for way in (across, up):
                low, high = (tuple(p + s * reach * q for p, q in zip(place, way, strict=True)) for s in (-1, 1))
                marks.append(((low[0], low[1], low[2]), (high[0], high[1], high[2])))
    return tuple(marks)


MAIN = "main"


@dataclass(frozen=True)
class Axis:
    """The axis of a turned part, along Z or Y through the origin; it lies across the paper."""

    direction: Vector = Z

    def point(self, radius: float, along: float) -> Vector:
        """Point of the view's plane: ``radius`` up (down if negative) and ``along`` the axis."""
        x, y, z = X[0] * radius, self.direction[1] * along, self.direction[2] * along
        return (x, y, z)

    def view(self, low: float, high: float, *, section: bool) -> View:
        """The main view; a section through the axis if ``section``."""
        return View(
            MAIN,
            right=self.direction,
            up=X,
            cut=(0.0, 0.0, 0.0) if section else None,
            axes=((self.point(0.0, low), self.point(0.0, high)),),
        )

    def diameter(
        self, radius: float, at: float, side: Side, *, fit: str = "", count: int = 1, decimals: int = 2, datum: str = ""
    ) -> Linear:
        """Diameter of the cylinder whose generator passes ``at``, shown at the ``left`` or ``right``."""
        prefix, ends = f"{count}x %%c" if count > 1 else "%%c", (self.point(-radius, at), self.point(radius, at))
        return Linear(MAIN, *ends, 2 * radius, side, prefix, fit=fit, decimals=decimals, datum=datum)

    def thread(self, radius: float, at: float, side: Side, tolerance: str) -> Linear:
        """Thread of nominal diameter ``2 * radius``; its class of tolerance stands behind it."""
        return Linear(MAIN, self.point(-radius, at), self.point(radius, at), 2 * radius, side, "M", tolerance)

    def length(
        self,
        low: float,
        high: float,
        side: Side,
        radii: tuple[float, float],
        *,
        count: int = 1,
        suffix: str = "",
        decimals: int = 2,
    ) -> Linear:
        """Length along the axis; ``radii`` say where the extension lines start."""
        sign = 1.0 if side == "above" else -1.0
        prefix = f"{count}x " if count > 1 else ""
        ends = self.point(sign * radii[0], low), self.point(sign * radii[1], high)
        return Linear(MAIN, *ends, high - low, side, prefix, suffix, decimals=decimals)

    def square(self, radii: tuple[float, float], faces: tuple[float, ...], value_mm: float, datum: str) -> Tolerance:
        """Faces across the axis, between two radii, are perpendicular to it."""
        first, *others = (self.point(sum(radii) / 2, face) for face in faces)
        return Tolerance(MAIN, first, "perpendicularity", value_mm, (datum,), tuple(others))

    def run_out(self, lands: tuple[tuple[float, float], ...], value_mm: float, datum: str) -> Tolerance:
        """Run-out of cylinders, each with its radius and a place along the axis, to the axis."""
        first, *others = (self.point(radius, along) for radius, along in lands)
        return Tolerance(MAIN, first, "run-out", value_mm, (datum,), tuple(others))

    def chamfer(self, size: float, radius: float, edge: float, sense: float, side: Side, count: int = 1) -> Linear:
        """A 45 degree chamfer at the end ``edge`` of a cylinder; ``sense`` +1 if the part lies towards +axis."""
        low, high = sorted((edge, edge + sense * size))
        radii = (radius - size, radius) if sense > 0 else (radius, radius - size)
        return self.length(low, high, side, radii, count=count, suffix=" x 45%%d")


ALONG_Z = Axis(Z)
ALONG_Y = Axis(Y)


def fit_lines(*dimensions: Linear | Radius, what: dict[str, str]) -> tuple[FitLine, ...]:
    """A line of the table of limits for each dimension with a fit; ``what`` gives its place by the tolerance class."""
    return tuple(FitLine(round(d.value, 6), d.fit, what[d.fit]) for d in dimensions if isinstance(d, Linear) and d.fit)
