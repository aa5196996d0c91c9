"""The page without a browser: data within stated errors, order of its parts, reproducible and safe bytes."""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import asdict, replace
from importlib.resources import files
from math import radians
from typing import Any

import numpy as np
import pytest

import mbcdm_cad
from mbcdm_cad.api.design import DriveDesign
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.turns import modes_of, turns_at, turns_of
from mbcdm_cad.model.bulk import preload_table
from mbcdm_cad.optimising.evaluate import Facts, figure
from mbcdm_cad.report.analysis_report import above_gearhead
from mbcdm_cad.report.comparison import sweep
from mbcdm_cad.report.data import design_figures
from mbcdm_cad.report.page import template
from mbcdm_cad.report.page.scene import CHORD_ERROR_MM, POSE_ERROR_MM, _Binary, cable_lines
from mbcdm_cad.report.page.stage import LICENCE, THREE, THREE_SHA256, charts_under_load, studies
from mbcdm_cad.report.page.template import _figure, _json, derived
from tests.support.checked import results
from tests.support.reference import DRIVE, PARAMS

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


# One quantity has one figure: those that appear in several outputs of a design are the same in all of them.


DESIGNS = ("mbcdm", "siso_spur", "miso_spur", "siso_bevel", "built-by-others/printed-capstan")
# Names that mean another thing in each block, and which.
OTHER_MEANING = {"load_Nm": "each load case and curve has its own", "temperature_C": "each row of a table has its own"}


def leaves(value: Any, name: str = "") -> Iterator[tuple[str, float]]:
    """Every number with the name under which it stands."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from leaves(item, key)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from leaves(item, f"{name}[]")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield name, float(value)


def lonely(block: Any) -> dict[str, float]:
    """The numbers whose name stands only once in a block: one quantity of the design, not a row of a table."""
    found: dict[str, list[float]] = {}
    for name, value in leaves(block):
        found.setdefault(name, []).append(value)
    return {name: values[0] for name, values in found.items() if len(values) == 1 and "[]" not in name}


@pytest.fixture(scope="module", params=DESIGNS)
def design(request: pytest.FixtureRequest) -> DriveDesign:
    """One design of each layout, and a printed capstan with a continuous cable."""
    return mbcdm_cad.load(PARAMS / f"{request.param}.yaml")


@pytest.fixture(scope="module")
def outputs(design: DriveDesign) -> dict[str, Any]:
    """Blocks of ``analyse --json`` and of a report's data, as JSON."""
    layout = layout_of(design.loaded.drive)
    report = design_figures(layout, layout.bill()).data
    analysed = design.analyse().to_dict()
    own = analysed.pop
    blocks = {
        f"analyse: {name}": own(name) for name in ("structure", "modes", "losses", "duty", "life", "paths", "motor")
    }
    blocks["analyse"] = analysed
    blocks["report: analysis"] = report.pop("analysis")
    blocks |= {f"report: {name}": report[name] for name in ("structure", "torsion", "losses", "duty", "life", "paths")}
    found: dict[str, Any] = json.loads(json.dumps(blocks))
    return found


def test_a_name_that_stands_in_several_blocks_has_one_value(outputs: dict[str, Any]) -> None:
    seen: dict[str, list[tuple[str, float]]] = {}
    for where, block in outputs.items():
        for name, value in lonely(block).items():
            seen.setdefault(name, []).append((where, value))
    shared = {name: places for name, places in seen.items() if len(places) > 1 and name not in OTHER_MEANING}
    assert len(shared) > 20 and "lowest_inputs_held_Hz" in shared, sorted(shared)
    differ = {n: places for n, places in shared.items() if max(v for _, v in places) != min(v for _, v in places)}
    wrong = {n: p for n, p in differ.items() if p[0][1] != pytest.approx(p[1][1], rel=1e-8)}
    assert not wrong, wrong


def test_turns_swings_and_stiffness_are_the_same_everywhere(design: DriveDesign, outputs: dict[str, Any]) -> None:
    loaded = design.loaded
    drive, layout = loaded.drive, layout_of(loaded.drive)
    checks = {check.id: check for check in results(loaded)}
    facts = Facts(drive, loaded.data)
    turns, places = turns_of(layout), outputs["analyse: structure"]["places"]
    again = turns_at(layout, drive.loads.test_torque_Nm)
    analysis = outputs["analyse"]
    many = sweep(loaded, {"loads.test_torque_Nm": [drive.loads.test_torque_Nm]})
    whole = next(row for row in preload_table(layout_of(drive)) if row.share == 1.0)
    assert turns.payload is not None and turns.drum_encoder is not None
    same = {
        "swing of the payload": [
            turns.payload.swing_mrad,
            again.felt.swing_mrad,
            places["payload"]["swing_mrad"],
            outputs["report: structure"]["payload_swing_mrad"],
            figure(facts, "swing_mrad"),
        ],
        "swing by the cables": [
            turns.cables.swing_mrad,
            analysis["reversal_swing_mrad"],
            outputs["analyse: structure"]["cables_swing_mrad"],
            float(many["reversal_swing_mrad"][0]),
            whole.reversal_swing_mrad,
            figure(facts, "cable_swing_mrad"),
        ],
        "turn by the cables": [
            turns.cables.turn_mrad,
            abs(analysis["test"][0]["turn_mrad"]),
            outputs["analyse: structure"]["cables_urad_Nm"] * drive.loads.test_torque_Nm * 1e-3,
        ],
        "stiffness at the payload": [
            turns.payload.stiffness_Nm_rad,
            checks["stiffness"].actual,
            outputs["analyse: structure"]["stiffness_at_payload_Nm_rad"],
            figure(facts, "stiffness_Nm_rad"),
        ],
        "stiffness of the cables": [turns.cables.sticking_stiffness_Nm_rad, analysis["sticking_stiffness_Nm_rad"]],
        "structure at the drum's encoder": [
            turns.drum_encoder.structure_urad_Nm,
            outputs["report: structure"]["structure_at_drum_encoder_urad_Nm"],
        ],
    }
    for what, values in same.items():
        assert values == pytest.approx([values[0]] * len(values), rel=1e-6), what


def test_slip_of_a_continuous_cable_is_one_figure(design: DriveDesign, outputs: dict[str, Any]) -> None:
    limits = [x["torque_Nm"] for x in outputs["analyse"]["limits"] if x["cause"] == "slip"]
    checks = {check.id: check for check in results(design.loaded)}
    drive = design.loaded.drive
    if "input_slip" not in checks or not limits:
        assert not limits, "a limit of slip that no check judges"
        return
    judged = checks["input_slip"]
    assert judged.actual is not None
    assert judged.actual * drive.loads.peak_torque_Nm == pytest.approx(min(limits), rel=1e-6)
    assert f"{min(limits):.4g} N m" in judged.message, judged.message
    assert f"{min(limits):.3f} N m" in design.analyse().text()


def test_a_peak_torque_above_a_rating_of_the_gearhead_is_told(design: DriveDesign) -> None:
    """What motor and cables allow may be more than the gearhead holds."""
    report = design.analyse()
    limits, text = report.figures.limits, " ".join(report.text().split())
    for called, peaks in (
        ("without losses", report.figures.peak_torque_lossless_Nm),
        ("with losses", report.figures.peak_torque_with_losses_Nm),
    ):
        own = {
            x.direction: peak for x in limits for way, peak in zip((1, -1), peaks, strict=True) if x.direction == way
        }
        above = [x for x in limits if x.cause.startswith("gearhead") and x.torque_Nm < own[x.direction] * (1 - 1e-9)]
        assert (f"the peak torque {called}, " in text) == bool(above), (called, above)
    half = [replace(x, torque_Nm=x.torque_Nm / 2) if x.cause == "gearhead_maximum" else x for x in limits]
    maximum = [x.torque_Nm for x in half if x.cause == "gearhead_maximum"]
    if maximum:
        told = above_gearhead(half, "gearhead", "peak torque", (9e9, 9e9))
        assert told == (
            f"the peak torque, {9e9:.3f} N m, is above what the gearhead holds at most, {min(maximum):.3f} N m, "
            "which forbids it"
        )


def test_slack_is_one_figure(design: DriveDesign, outputs: dict[str, Any]) -> None:
    """The limit of analyse is the peak torque at which the check begins to fail, with the wraps that are there."""
    drive = design.loaded.drive
    limit = min(x["torque_Nm"] for x in outputs["analyse"]["limits"] if x["cause"] == "slack")
    row = next(r for r in outputs["analyse"].get("reached_preloads") or preload_rows(drive) if r["share"] == 1.0)
    assert min(row["slack_Nm"]) == pytest.approx(limit, rel=1e-6)
    assert f"{limit:.3f} N m" in design.analyse().text()
    check = next(check for check in checks_of(drive) if check.id == "no_slack")
    below, above = (check.measure(at_peak(drive, share * limit)) for share in (0.999, 1.001))
    assert below.holds and not above.holds, (below.message, above.message)


def preload_rows(drive: Any) -> list[dict[str, Any]]:
    """The table of lower preloads as the report has it."""
    return [asdict(row) for row in preload_table(layout_of(drive))]


def at_peak(drive: Any, torque_Nm: float) -> Any:
    """The same drive asked for another peak torque."""
    return layout_of(replace(drive, loads=replace(drive.loads, peak_torque_Nm=torque_Nm)))


def test_the_page_prints_these_figures(design: DriveDesign, outputs: dict[str, Any]) -> None:
    """Its derived values, and the curves of a comparison."""
    drive = design.loaded.drive
    layout = layout_of(drive)
    modes = modes_of(layout)
    torsion = {"inputs_free_Hz": list(modes.inputs_free_Hz)} | {
        name: getattr(modes, name) for name in ("lowest_inputs_held_Hz", "cables_alone_Hz")
    }
    report = {
        "analysis": outputs["report: analysis"] | {"motor": None},
        "paths": outputs["report: paths"],
        "structure": outputs["report: structure"],
        "torsion": torsion,
        "inertia_moving_g_mm2": {"at_drum_without_rotors": 1.0, "at_motor": 1.0},
        "torque": {"torque_to_weight_Nm_kg": 1.0},
        "frame": None,
    }
    said = {row["what"]: row["value"] for row in derived(report, [])}
    turns = turns_of(layout)
    assert said["swing at the payload"] == f"{turns.felt.swing_mrad:.4g} mrad"
    assert said["swing by the cables alone"] == f"{turns.cables.swing_mrad:.4g} mrad"
    over_travel = studies(drive)["charts"]["travel"]["lines"]
    assert over_travel[-1]["y"][0] == pytest.approx(turns.cables.turn_mrad, rel=1e-4), (
        "endless wraps: all other figures"
    )
    real = outputs["report: paths"]["test_turn_mrad"]["positive"]
    assert over_travel[0]["y"] == pytest.approx(np.abs(real), rel=1e-4)
    line = charts_under_load([("own", drive)])["swing"]["lines"][0]
    at = turns_at(layout, line["x"][-1])
    assert line["y"][-1] == pytest.approx(at.felt.swing_mrad, rel=1e-4)
