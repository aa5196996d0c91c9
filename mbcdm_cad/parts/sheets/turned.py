"""Helpers to describe turned parts: points, diameters, lengths and chamfers on a view along the axis."""

from __future__ import annotations

from dataclasses import dataclass

from mbcdm_cad.parts.sheets.description import FitLine, Linear, Radius, Side, Vector, View, X, Y, Z
from mbcdm_cad.parts.sheets.tolerances import GeometricTolerance as Tolerance

MAIN = "main"


@dataclass(frozen=True)
class Axis:
    """The axis of a turned part, along Z or Y through the origin; it lies across the paper."""

    direction: Vector = Z

    def point(self, radius: float, along: float) -> Vector:
        """Point of the view's plane: ``radius`` up (down if negative) and ``along`` the axis."""
        x, y, z = X[0] * radius, self.direction[1] * along, self.direction[2] * along
        return (x, y, z)

    def view(self, low: float, high: float, *, section: bool, hidden: bool = False, title: str = "") -> View:
        """The main view; a section through the axis if ``section``."""
        return View(
            MAIN,
            right=self.direction,
            up=X,
            cut=(0.0, 0.0, 0.0) if section else None,
            hidden=hidden,
            title=title,
            axes=((self.point(0.0, low), self.point(0.0, high)),),
        )

    def diameter(
        self,
        radius: float,
        at: float,
        side: Side,
        *,
        fit: str = "",
        count: int = 1,
        suffix: str = "",
        decimals: int = 2,
        datum: str = "",
    ) -> Linear:
        """Diameter of the cylinder whose generator passes ``at``, shown at the ``left`` or ``right``."""
        prefix = f"{count}x %%c" if count > 1 else "%%c"
        return Linear(
            MAIN,
            self.point(-radius, at),
            self.point(radius, at),
            2 * radius,
            side,
            prefix,
            suffix,
            fit,
            decimals=decimals,
            datum=datum,
        )

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
        return Linear(
            MAIN,
            self.point(sign * radii[0], low),
            self.point(sign * radii[1], high),
            high - low,
            side,
            prefix,
            suffix,
            decimals=decimals,
        )

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
