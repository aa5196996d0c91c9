"""Published figures beside the model as one HTML page, without pictures or any other file."""

from __future__ import annotations

from mbcdm_cad.loop.published import Judged, PublishedResult
from mbcdm_cad.loop.readable import readable

# Ending that tells `readable` the unit of a figure.
ENDINGS = {"rad": "_rad", "N m": "_Nm"}


def published_page(result: PublishedResult, design: str) -> bytes:
    """The page as HTML; ``design`` is the design's name."""
    import jinja2  # only a report needs it

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mbcdm_cad.loop", "."), undefined=jinja2.StrictUndefined, autoescape=True
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


def shown(figure: Judged, value: float | None) -> str:
    """A value in the unit that suits it; empty for none."""
    if value is None:
        return ""
    if figure.unit in ENDINGS:
        return readable(figure.quantity + ENDINGS[figure.unit], [value])[1][0]
    return f"{value:.4g} {figure.unit}"
