"""Published figures compared with the model as one HTML page, without pictures or other files."""

from __future__ import annotations

import jinja2

from mbcdm_cad.paper.published import PublishedResult, shown


def published_page(result: PublishedResult, design: str) -> bytes:
    """The page as HTML; ``design`` is the design's name."""
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
