"""A page that compares designs: pictures, figures with bars, behaviour under load."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.report.comparison import ComparedDesign, comparison_table
from mbcdm_cad.report.page.studies import charts_under_load
from mbcdm_cad.report.page.template import page_environment


def comparison_page(designs: Sequence[ComparedDesign], drives: Sequence[Drive], pictures: Sequence[bytes]) -> bytes:
    """The page as UTF-8; needs no other file. ``pictures``: a PNG of each design, in the same order."""
    text = (
        page_environment()
        .get_template("compare.html.j2")
        .render(
            designs=designs,
            pictures=[base64.b64encode(png).decode() for png in pictures],
            rows=[_row(label.strip(), cells) for label, *cells in comparison_table(designs).rows],
            charts=charts_under_load([(design.name, drive) for design, drive in zip(designs, drives, strict=True)]),
        )
    )
    return text.encode()


def _row(label: str, values: Sequence[Any]) -> dict[str, Any]:
    """A row of the table; comparable figures have their share of the largest, for a bar."""
    numbers = all(isinstance(value, float | int) for value in values)
    most = max(values) if numbers else 0.0
    cells = [{"value": value, "share": value / most if numbers and most > 0.0 else None} for value in values]
    return {"label": label, "cells": cells}
