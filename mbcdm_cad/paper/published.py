"""Published figures compared with the declared model: predicted, measured, possible causes; as one HTML page."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import jinja2
import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.readable import readable
from mbcdm_cad.measurement.file import MeasurementFile
from mbcdm_cad.measurement.logformat import Unit, unit_of
from mbcdm_cad.paper.published_causes import JUDGES, Judged, together

# Ending of a name from which `readable` takes the unit.
ENDINGS = {"rad": "_rad", "N m": "_Nm"}


@dataclass(frozen=True)
class PublishedResult:
    """All figures of one file, and the conclusions from several of them."""

    source: str
    figures: tuple[Judged, ...]
    together: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """The result file: the form of every loop's result, with the figures under ``published``."""
        sets = [[{"name": c.effect} for c in figure.candidates if c.effect and c.plausible] for figure in self.figures]
        return {
            "verdict": "not_testable",
            "effects": [],
            "one_of": [list({item["name"]: item for item in named}.values()) for named in sets if named],
            "unknown": None,
            "error": None,
            "published": [asdict(figure) | {"residual": figure.residual} for figure in self.figures],
            "together": list(self.together),
        }

    def text(self) -> str:
        """The result as text."""
        lines = [
            f"{self.source}: {len(self.figures)} published figures. A scalar cannot be tested on held-out data: the "
            "causes below are possible, not confirmed."
        ]
        for figure in self.figures:
            lines += ["", *_lines(figure)]
        return "\n".join([*lines, "", *self.together])


def judge_published(drive: Drive, file: MeasurementFile) -> PublishedResult:
    """Compare the model of ``drive`` with the published figures. Raises InputError for a file of another kind."""
    if file.content.published is None:
        remedy = "use a file with published figures"
        raise InputError([file.problem(("data",), "contains a run, not published figures", remedy=remedy)])
    figures = []
    for item in file.content.published:
        d = layout_of(drive).si
        if item.conditions.preload_N is not None:
            d = d.with_(preload_N=np.full(d.n_cables, item.conditions.preload_N))
        unit = unit_of(item.quantity, item.unit) or Unit(1.0)
        figures.append(JUDGES[item.quantity](drive, d, item, item.value * unit.factor))
    return PublishedResult(file.path.name, tuple(figures), together(tuple(figures)))


def shown(figure: Judged, value: float | None) -> str:
    """A value in a readable unit; empty for None."""
    if value is None:
        return ""
    if figure.unit in ENDINGS:
        return readable(figure.quantity + ENDINGS[figure.unit], [value])[1][0]
    return f"{value:.4g} {figure.unit}"


def _lines(figure: Judged) -> list[str]:
    predicted = shown(figure, figure.predicted) or "gives no figure"
    residual = shown(figure, figure.residual)
    stated = shown(figure, figure.stated_theory)
    lines = [
        f"{figure.quantity} ({figure.where}): measured {shown(figure, figure.measured)}, model {predicted}"
        + (f", residual {residual}" if residual else "")
        + (f", the authors' theory {stated}" if stated else "")
    ]
    lines += [f"  {figure.remark}"] if figure.remark else []
    for candidate in figure.candidates:
        gives = "" if candidate.predicted is None else f"gives {shown(figure, candidate.predicted)}; "
        sign = "+" if candidate.plausible else "-"
        name = f" [{candidate.effect}]" if candidate.effect else ""
        lines.append(f"  {sign} {candidate.cause}{name}: {gives}{candidate.needed}")
    return [*lines, f"  experiment that distinguishes them: {figure.told_apart_by}"]


def published_page(result: PublishedResult, design: str) -> bytes:
    """Published figures compared with the model as one HTML page, without pictures or other files."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mbcdm_cad.paper", "."), undefined=jinja2.StrictUndefined, autoescape=True
    )
    figures = [
        {
            "name": figure.quantity.replace("_", " "),
            "where": figure.where,
            "measured": shown(figure, figure.measured),
            "predicted": shown(figure, figure.predicted),
            "residual": shown(figure, figure.residual),
            "stated": shown(figure, figure.stated_theory),
            "remark": figure.remark,
            "candidates": [(c, shown(figure, c.predicted)) for c in figure.candidates],
            "told_apart_by": figure.told_apart_by,
        }
        for figure in result.figures
    ]
    page = environment.get_template("published.html.j2").render(
        source=result.source, design=design, figures=figures, together=result.together
    )
    return page.encode()
