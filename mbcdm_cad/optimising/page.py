"""The page of a search: the front in two figures and as parallel coordinates, linked; each design with its sketch."""

from __future__ import annotations

from typing import Any

from mbcdm_cad.checks.comparison import figures as check_figures
from mbcdm_cad.optimising.figures import FIGURES, unit_of
from mbcdm_cad.optimising.result import FrontPoint, Optimum
from mbcdm_cad.report.page.template import page_environment

# Where the page's template lies.
_PACKAGE = ("mbcdm_cad.optimising", "assets")


def optimum_page(found: Optimum) -> bytes:
    """The page as UTF-8; needs no other file. Raises nothing for a search without a passing design."""
    names = [name for name in dict.fromkeys([*found.shown, *FIGURES]) if _varies(found, name)]
    data = {
        "aims": [{"figure": aim.figure, "sense": aim.sense} for aim in found.wishes.aims],
        "names": names,
        "units": {name: unit_of(name) for name in names},
        "points": [_point(point) for point in found.points],
        "starts": _marked(found),
        "curve": [list(step) for step in found.searched.curve],
    }
    template = page_environment(_PACKAGE).get_template("optimum.html.j2")
    return template.render(found=found, data=data, binding=found.binding(), meanings=FIGURES).encode()


def _marked(found: Optimum) -> list[dict[str, Any]]:
    """The designs that are no part of the front: its files as given, and those beside it."""
    several = len(found.starts) > 1
    given = [
        {"name": f"File {k} as given" if several else "File as given", "figures": dict(start.result.figures)}
        for k, start in enumerate(found.starts, start=1)
    ]
    return given + [
        {
            "name": f"{one.name} (fails {len(one.failing)} of its checks)" if one.failing else one.name,
            "figures": dict(one.figures),
            "beside": True,
        }
        for one in found.beside
    ]


def _varies(found: Optimum, name: str) -> bool:
    values = {point.figures.get(name) for point in found.points}
    return name in found.shown or len(values) > 1 or (len(found.points) == 1 and values != {None})


def _point(point: FrontPoint) -> dict[str, Any]:
    return {
        "name": point.name,
        "layout": point.layout,
        "figures": dict(point.figures),
        "patch": point.patch,
        "binding": list(point.binding),
        "sketch": dict(point.sketch),
        "checks": [[c.id, c.title, c.status, check_figures(c)] for c in point.checks],
    }
