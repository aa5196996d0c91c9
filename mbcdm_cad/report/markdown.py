"""report.md from the report's data."""

from __future__ import annotations

from typing import Any

import jinja2

from mbcdm_cad.checks.comparison import shown
from mbcdm_cad.design.describe import flow
from mbcdm_cad.model.measured import papers_test
from mbcdm_cad.report.analysis_report import motor_lines
from mbcdm_cad.report.duty import duty_shown
from mbcdm_cad.report.life import life_shown
from mbcdm_cad.report.losses import losses_shown
from mbcdm_cad.report.preload import preload_shown
from mbcdm_cad.report.table import speed_shown

_AT_DRUM = "_at_drum"


def _figure(value: Any) -> str:
    if isinstance(value, float):
        return shown(value)
    if isinstance(value, list | tuple):
        return ", ".join(_figure(v) for v in value)
    return "none" if value is None else str(value)


def report_markdown(data: dict[str, Any], paths_template: str) -> str:
    """The report in words and tables; ``paths_template`` is the layout's for its cable paths."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mbcdm_cad.report", "."),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,  # no HTML escapes in Markdown; all names in it are plain slugs
    )
    environment.filters["figure"] = _figure
    environment.filters["figures"] = _figure
    environment.filters["flow"] = flow
    environment.filters["speed"] = speed_shown
    paths = environment.from_string(paths_template).render(r=data)
    moving = data["inertia_moving_g_mm2"]
    passed = {
        name.removesuffix(_AT_DRUM): value
        for name, value in moving.items()
        if name.endswith(_AT_DRUM) and name not in ("inputs_at_drum", "rotors_at_drum")
    }
    motor = data["analysis"]["motor"]
    return environment.get_template("report.md.j2").render(
        r=data,
        a=data["analysis"],
        papers_test=papers_test(data["analysis"]["test"][0]["load_Nm"]),
        paths=paths,
        passed=passed,
        losses=losses_shown(data["losses"]),
        life=life_shown(data["life"]),
        preload=preload_shown(data["preload"]),
        duty=duty_shown(data["duty"]),
        motor_lines=motor_lines(motor) if motor else (),
    )
