"""docs/loop.md speaks of every effect, form and figure that the library has."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.result import VERDICTS
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.model.si import to_si

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "loop.md").read_text("utf-8")


def offered() -> list[Effect]:
    t = np.arange(0.0, 40.0, 0.05)
    angle = 0.45 * np.sin(2.0 * np.pi * t / 8.0)
    run = Run(t, np.stack([9.0 * angle, 9.0 * angle]), angle, 0.5 * np.cos(t), 20.0 + 0.1 * t)
    d = to_si(load_design(ROOT / "params" / "mbcdm.yaml").drive)
    ways = [(d, run), (d, replace(run, temperature_C=None)), (None, replace(run, load_Nm=None))]
    return [effect for drive, one in ways for effect in library(drive, prepare(one, 9.0)[1])]


def test_every_name_stage_and_figure_is_there() -> None:
    for effect in offered():
        rows = [line for line in PAGE.split("\n") if line.startswith(f"| `{effect.name}`")]
        assert len(rows) == 1, effect.label
        assert effect.stage is None or effect.stage in rows[0] or effect.name == "lash", effect.label
        for figure in effect.reported():
            assert f"`{figure.name}`" in rows[0], (effect.label, figure.name)


def test_every_verdict_is_there() -> None:
    assert [v for v in VERDICTS if f"| `{v}` |" not in PAGE] == []
