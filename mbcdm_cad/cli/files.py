"""The commands ``init``, ``schema`` and ``measurement-init``: new files, and the schema for editors.

Modules of measurement files are imported inside: they need numpy, a new design file does not.
"""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import click

from mbcdm_cad.design.editor import editor_schema
from mbcdm_cad.design.reference import reference_page
from mbcdm_cad.design.template import slug
from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.layouts.loader import DEFAULT, design_file, load_design, new_design_text, short_design_text
from mbcdm_cad.storage.files import refuse_missing_folder


def init_command(new: Path, configuration: str | None, form: str = "short") -> int:
    """Write the new design file: ``short``, ``full`` (with derived values as comments), or the ``reference`` design.

    A configuration without sizing rules always gets its reference design. Raises ``InputError`` if the file exists or
    cannot be written.
    """
    refuse_missing_folder(new)

    name = slug(new.stem)
    of = configuration or DEFAULT
    whole = form == "reference" or (form == "short" and not design_file(of).starting)
    text = new_design_text(name, of) if whole else short_design_text(name, of, derived=form == "full")
    try:
        with open(new, "x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        problem = Problem(str(new), 1, "", "exists already", remedy="choose another name, or remove it first")
        raise InputError([problem]) from None
    except ValueError as error:
        raise InputError([Problem(str(new), 1, "", f"cannot be written: {error}", remedy="check the path")]) from None
    click.echo(f"{new}: design {name} written; check it with: mbcdm check {shlex.quote(str(new))}")
    return 0


def schema_command(*, reference: bool, measurement: bool, configuration: str | None) -> int:
    """Print the JSON Schema, or the reference page, of one configuration's design files or of measurement files."""
    if measurement:
        from mbcdm_cad.measurement.reference import measurement_page
        from mbcdm_cad.measurement.schema import json_schema

        text = measurement_page() if reference else _json(json_schema())
    else:
        nodes = design_file(configuration or DEFAULT).nodes
        text = reference_page(nodes) if reference else _json(editor_schema(nodes))
    click.echo(text, nl=False)
    return 0


def _json(schema: dict[str, Any]) -> str:
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def measurement_init_command(data: Path, design: Path, out: Path | None) -> int:
    """Write a first measurement file for a logger's data. Never overwrites a file."""
    from mbcdm_cad.measurement.draft import draft_text

    path = out or data.with_suffix(".yaml")
    refuse_missing_folder(path)
    text = draft_text(data, load_design(design).drive)
    if path.parent.resolve() != data.parent.resolve():
        remedy = "write it into the folder of the data, because it names the data relative to itself"
        raise InputError([Problem(str(path), 1, "", "in another folder than the data", remedy=remedy)])
    try:
        with open(path, "x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        problem = Problem(str(path), 1, "", "exists already", remedy="choose another name with --out, or remove it")
        raise InputError([problem]) from None
    click.echo(text, nl=False)
    where = f"{shlex.quote(str(design))} {shlex.quote(str(path))}"
    click.echo(f"{path} written; check the guesses in it, then: mbcdm loop {where}")
    return 0
