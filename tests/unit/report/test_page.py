"""The page without a browser: data within stated errors, order of its parts, reproducible and safe bytes."""

from __future__ import annotations

import hashlib
from importlib.resources import files
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.report.page import template
from mbcdm_cad.report.page.scene import CHORD_ERROR_MM, POSE_ERROR_MM, _Binary, cable_lines
from mbcdm_cad.report.page.stage import LICENCE, THREE, THREE_SHA256
from mbcdm_cad.report.page.template import _figure, _json

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
LARGEST_BUNDLE_BYTES = 800_000


def check(**changes: Any) -> dict[str, Any]:
    plain = {"id": "one", "status": "pass", "actual": 1.0, "limit": 2.0, "margin": 1.0, "unit": "mm", "title": "One"}
    return plain | changes


class TestVendored:
    def test_bundle_is_the_one_that_make_sh_printed(self) -> None:
        data = (files("mbcdm_cad.report.page") / THREE).read_bytes()
        assert hashlib.sha256(data).hexdigest() == THREE_SHA256
        assert len(data) < LARGEST_BUNDLE_BYTES, len(data)

    def test_licence_comes_with_it(self) -> None:
        text = (files("mbcdm_cad.report.page") / LICENCE).read_text("utf-8")
        assert "MIT License" in text and "three.js authors" in text


class TestUsedShare:
    @pytest.mark.parametrize(
        ("actual", "limit", "margin", "share"),
        [
            (1.0, 2.0, 1.0, 0.5),  # at most 2
            (3.0, 2.0, -1.0, 1.5),
            (4.0, 2.0, 2.0, 0.5),  # at least 2
            (1.0, 2.0, -1.0, 2.0),
            (2.0, 2.0, 0.0, 1.0),
            (0.0, 0.5, 0.5, 0.0),
        ],
    )
    def test_is_one_at_the_limit_and_more_beyond(
        self, actual: float, limit: float, margin: float, share: float
    ) -> None:
        assert template.used_share(check(actual=actual, limit=limit, margin=margin)) == pytest.approx(share)

    @pytest.mark.parametrize("gone", ["actual", "limit", "margin"])
    def test_is_none_without_a_figure(self, gone: str) -> None:
        assert template.used_share(check(**{gone: None})) is None

    def test_is_none_against_a_limit_of_nought(self) -> None:
        assert template.used_share(check(actual=0.0, limit=0.0, margin=0.0)) is None


def test_fails_come_first_then_warnings_then_what_is_tight() -> None:
    rows = [
        check(id="easy", actual=0.1, margin=1.9),
        check(id="tight", actual=1.9, margin=0.1),
        check(id="warn", status="warn", actual=3.0, margin=-1.0),
        check(id="none", limit=None, margin=None),
        check(id="fail", status="fail", actual=4.0, margin=-2.0),
    ]
    assert [row["id"] for row in template.sorted_checks(rows)] == ["fail", "warn", "tight", "easy", "none"]
    assert template.check_counts(rows) == {"fail": 1, "warn": 1, "pass": 3}
    best = template.tightest(rows)
    assert best is not None and best["id"] == "tight"


def test_cables_have_a_column_for_each_figure_of_their_paths() -> None:
    path = {"name": "one", "length_mm": 12.345, "wrap_deg": [10.0, 20.0], "contact_mm": [1.0, 2.0, 3.0], "side": "+x"}
    report = {
        "paths": {"drum_angle_deg": [-1.0, 1.0], "cables": [path]},
        "analysis": {"cables": [{"name": "one", "preload_N": 70.0, "total_ratio": 9.0}]},
    }
    table = template.cable_rows(report)
    assert table["head"] == ["preload N", "total ratio", "length mm", "wrap °"]
    assert table["rows"] == [("one", ["70", "9", "12.35", "10.0 to 20.0"])]


class TestCableLines:
    @pytest.fixture(scope="class")
    @classmethod
    def paths_at(cls) -> Any:
        return layout_of(DRIVE).cable_paths

    def test_points_lie_on_the_route_and_chords_near_it(self, paths_at: Any) -> None:
        lines, angles = cable_lines(paths_at, DRIVE.half_travel_deg)
        k = len(angles) // 3
        for path in paths_at(radians(float(angles[k]))):
            route = path.sample(0.01)
            chords = lines[path.cable.name][k]
            middles = (chords[1:] + chords[:-1]) / 2
            far = max(float(np.linalg.norm(route - point, axis=1).min()) for point in (*chords, *middles))
            assert far < CHORD_ERROR_MM + 0.006, (path.cable.name, far)  # the route is sampled every 0.01 mm

    def test_between_two_angles_the_error_is_within_its_bound(self, paths_at: Any) -> None:
        lines, angles = cable_lines(paths_at, DRIVE.half_travel_deg)
        half = (float(angles[5]) + float(angles[6])) / 2
        for path in paths_at(radians(half)):
            between = (lines[path.cable.name][5] + lines[path.cable.name][6]) / 2
            route = path.sample(0.01)
            far = max(float(np.linalg.norm(route - point, axis=1).min()) for point in between)
            assert far < POSE_ERROR_MM + 0.006, (path.cable.name, far)

    def test_no_two_points_of_a_line_are_one(self, paths_at: Any) -> None:
        lines, _ = cable_lines(paths_at, DRIVE.half_travel_deg)
        shortest = min(float(np.linalg.norm(np.diff(points, axis=1), axis=2).min()) for points in lines.values())
        assert shortest > 1e-3, shortest


def test_quantised_points_come_back_within_a_step() -> None:
    points = np.random.default_rng(1).uniform(-65.0, 65.0, (500, 3))
    binary = _Binary()
    place = binary.quantised(points)
    shorts = np.frombuffer(binary.bytes(), np.uint16, place["count"], place["start"]).reshape(-1, 3)
    error = np.abs(np.array(place["low"]) + shorts * np.array(place["step"]) - points).max()
    assert error < 130.0 / 65535, error


@pytest.mark.parametrize("text", ["</script>", "<!--", "a & b"])
def test_data_cannot_end_its_script(text: str) -> None:
    written = str(_json({"name": text}))
    assert not set(written) & set("<>&"), written


@pytest.mark.parametrize(
    ("value", "text"), [(None, "–"), (-1.5, "−1.5"), (2.2e-16, "0"), (123456.0, "123456"), ((1.0, 2.0), "1, 2")]
)
def test_figures_are_written_for_people(value: Any, text: str) -> None:
    assert _figure(value) == text
