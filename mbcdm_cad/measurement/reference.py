"""The reference page of the measurement file in Markdown, written from its schema and the table of units."""

import jinja2

from mbcdm_cad.design.describe import flow, limit_text
from mbcdm_cad.measurement.datafile import MOST_BROKEN
from mbcdm_cad.measurement.kinds import FEWEST_SAMPLES, FEWEST_STEPS
from mbcdm_cad.measurement.logformat import known_units
from mbcdm_cad.measurement.schema import json_schema


def measurement_page() -> str:
    """The whole page."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mbcdm_cad.measurement", "."), trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "flow": flow,
        "cell": lambda text: " ".join(str(text).split()).replace("|", "\\|"),
        "said": lambda node: node["description"].capitalize(),
    }
    schema = json_schema()
    blocks = schema["properties"]
    return environment.get_template("reference.md.j2").render(
        blocks=blocks,
        plain={name: node for name, node in blocks.items() if "properties" not in node and name != "published"},
        required=schema.get("required", []),
        limits=lambda node: environment.filters["cell"](limit_text(node)),
        known_units=known_units,
        MOST_BROKEN=MOST_BROKEN,
        FEWEST_SAMPLES=FEWEST_SAMPLES,
        FEWEST_STEPS=FEWEST_STEPS,
    )
