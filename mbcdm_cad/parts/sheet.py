"""Content of a drawing as plain data: views, dimensions, labels, tables, notes. It needs no kernel and no paper size.

Points are in the part's own coordinates, mm. A view states which directions of the part lie to the right and upwards on
the paper; sections are views with a plane through ``cut`` that faces the reader, in front of which nothing is drawn.
Every dimension has its value, taken from the part's parameters, and the two points between which it is measured; the
engine refuses a sheet in which value and points disagree.
"""

from dataclasses import dataclass
from typing import Any, Literal

from mbcdm_cad.design.bought import InsertSpec
from mbcdm_cad.parts.fits import Datum, GeometricTolerance, thread

Vector = tuple[float, float, float]
Side = Literal["above", "below", "left", "right"]
X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)


# Placeholder in a table for the design's ``making.position_mm``, which is inserted when the sheet is drawn.
POSITION = "<position>"


def minus(v: Vector) -> Vector:
    """The opposite direction."""
    return (-v[0] + 0.0, -v[1] + 0.0, -v[2] + 0.0)


@dataclass(frozen=True)
class View:
    """One view. ``column`` and ``row`` place it in a grid, rows counted upwards; a row shares its height, a column its
    width, so that projections line up (first angle: the view from above lies below, that from the left to the right).

    ``magnify``: scale of a detail relative to the sheet's. ``window``: centre, half width and half height in mm of
    what a detail shows. ``axes``: centre lines from point to point; ``circles``: centre and radius of pitch circles.
    """

    name: str
    right: Vector
    up: Vector
    column: int = 0
    row: int = 0
    title: str = ""
    cut: Vector | None = None
    hidden: bool = False
    magnify: float = 1.0
    window: tuple[Vector, float, float] | None = None
    axes: tuple[tuple[Vector, Vector], ...] = ()
    circles: tuple[tuple[Vector, float], ...] = ()

    @property
    def toward(self) -> Vector:
        """Direction from the part to the reader."""
        (a, b, c), (d, e, f) = self.right, self.up
        return (b * f - c * e, c * d - a * f, a * e - b * d)

    def project(self, point: Vector) -> tuple[float, float]:
        """Coordinates of a point of the part in the view, mm to the right and upwards from the part's origin."""
        x, y, z = point
        return (
            x * self.right[0] + y * self.right[1] + z * self.right[2],
            x * self.up[0] + y * self.up[1] + z * self.up[2],
        )


@dataclass(frozen=True)
class Linear:
    """Distance between two points across (``above``, ``below``) or up (``left``, ``right``) the paper.

    ``prefix`` is written before the value ("%%c" for a diameter, "M" for a thread), ``fit`` behind it as a tolerance
    class of ISO 286, ``suffix`` last. ``deviations`` are upper and lower deviation in mm where no class applies.
    ``datum``: the letter of a diameter's axis as a datum.
    """

    view: str
    start: Vector
    end: Vector
    value: float
    side: Side
    prefix: str = ""
    suffix: str = ""
    fit: str = ""
    deviations: tuple[float, float] | None = None
    decimals: int = 2
    datum: str = ""


@dataclass(frozen=True)
class Radius:
    """Radius of an arc about ``centre``, its arrow at ``at``; the R before the value is not part of ``prefix``."""

    view: str
    centre: Vector
    at: Vector
    value: float
    suffix: str = ""
    prefix: str = ""


@dataclass(frozen=True)
class Angle:
    """Angle at ``vertex`` from ``start`` to ``end`` the way round that is ``value`` degrees, drawn ``reach`` mm out."""

    view: str
    vertex: Vector
    start: Vector
    end: Vector
    value: float
    reach: float
    suffix: str = ""


@dataclass(frozen=True)
class Label:
    """A short text beside a point of a view; the engine finds room for it. ``leader`` draws a line to the point.

    ``clear_mm``: radius on the part round the point that the text keeps off, such as a hole's.
    """

    view: str
    at: Vector
    text: str
    clear_mm: float = 0.0
    leader: bool = False


@dataclass(frozen=True)
class CuttingLine:
    """Trace of a section plane in a view, with the letter at both ends and arrows the way the section looks."""

    view: str
    start: Vector
    end: Vector
    letter: str
    looks: Vector


@dataclass(frozen=True)
class Table:
    """A table with a title, column heads and rows; empty cells are written as a dash."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class FitLine:
    """A toleranced size of the sheet, for its table of limits."""

    nominal_mm: float
    code: str
    what: str


@dataclass(frozen=True)
class Holes:
    """Equal holes, drilled from one face. ``depth`` is in mm or ``THROUGH``.

    ``diameter`` is the nominal one; of a thread its major diameter, the table then says the tap drill; with ``insert``
    that of the hole that the insert is set into.
    ``counterbore``: diameter, depth, fit, at the face ``from_face``. ``places``: where they start, in the part's
    coordinates; ``what`` says what they are for.
    """

    letter: str
    diameter: float
    depth: float | str
    places: tuple[Vector, ...]
    from_face: str
    what: str
    threaded: bool = False
    insert: InsertSpec | None = None
    fit: str = ""
    counterbore: tuple[float, float, str] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """A for a single hole, A1, A2 ... for several."""
        if len(self.places) == 1:
            return (self.letter,)
        return tuple(f"{self.letter}{n}" for n in range(1, len(self.places) + 1))

    def thread_text(self, tolerance: str = "") -> str:
        """Thread, its class of tolerance, and the depth of full thread in a blind hole: M2.5-6H x 6.5.

        Raises ``ValueError`` for a diameter that no thread has.
        """
        screw = thread(self.diameter)
        depth = "" if isinstance(self.depth, str) else f" x {mm(screw.full_thread_mm(self.depth), 1)}"
        return f"{screw.name}{tolerance}{depth}"

    def row(self) -> tuple[str, ...]:
        """The line of the table of holes."""
        drill, name = self.diameter, ""
        if self.threaded:
            drill, name = thread(self.diameter).tap_drill_mm, self.thread_text()
        elif self.insert is not None:
            name = f"insert {self.insert.name}"
        deeper = ""
        if self.counterbore is not None:
            diameter, depth, fit = self.counterbore
            deeper = f"%%c{mm(diameter)}{' ' + fit if fit else ''} x {mm(depth)}"
        depth_text = self.depth if isinstance(self.depth, str) else mm(self.depth)
        return (self.letter, str(len(self.places)), mm(drill, 3), name, depth_text, self.fit, deeper, self.from_face)

    def data(self) -> dict[str, Any]:
        """The same as plain data, with the places; lengths in mm."""
        screw = thread(self.diameter) if self.threaded else None
        bore = self.counterbore
        return {
            "hole": self.letter,
            "count": len(self.places),
            "diameter_mm": self.diameter,
            "thread": screw.name if screw else None,
            "insert": self.insert.name if self.insert else None,
            "tap_drill_mm": screw.tap_drill_mm if screw else None,
            "depth": self.depth,
            "fit": self.fit or None,
            "counterbore": None if bore is None else {"diameter_mm": bore[0], "depth_mm": bore[1], "fit": bore[2]},
            "from": self.from_face,
            "for": self.what,
            "places_mm": [list(place) for place in self.places],
        }

    def fit_lines(self) -> tuple[FitLine, ...]:
        """Its toleranced diameters."""
        lines = []
        if self.fit:
            lines.append(FitLine(round(self.diameter, 6), self.fit, f"{self.letter}, {self.what}"))
        if self.counterbore is not None and self.counterbore[2]:
            lines.append(FitLine(round(self.counterbore[0], 6), self.counterbore[2], f"{self.letter}, {self.what}"))
        return tuple(lines)

    @property
    def reach(self) -> float:
        """Radius of the hole as drawn, mm."""
        return max(self.diameter, self.counterbore[0] if self.counterbore else 0.0) / 2


@dataclass(frozen=True)
class Sheet:
    """The content of one drawing.

    ``holes``: those of its table, for the report.
    """

    part: str
    title: str
    views: tuple[View, ...]
    dimensions: tuple[Linear | Radius | Angle, ...] = ()
    labels: tuple[Label, ...] = ()
    datums: tuple[Datum, ...] = ()
    tolerances: tuple[GeometricTolerance, ...] = ()
    cutting_lines: tuple[CuttingLine, ...] = ()
    tables: tuple[Table, ...] = ()
    holes: tuple[Holes, ...] = ()
    fits: tuple[FitLine, ...] = ()
    notes: tuple[str, ...] = ()
    paper: Literal["A4", "A3", "A2"] = "A4"

    def view(self, name: str) -> View:
        """The view of that name. Raises ``KeyError``."""
        return next(v for v in self.views if v.name == name)


def mm(value: float, decimals: int = 2) -> str:
    """Millimetres, trailing zeros left out."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def mm3(value: float) -> str:
    """Millimetres to the micrometre."""
    return mm(value, 3)
