"""The Python API: its names and signatures, changes of a design, results as data, and what importing it loads."""

import inspect
import json
import os
import re
import shutil
import subprocess
import sys
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad import api, cli
from mbcdm_cad.cli.group import mbcdm
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.storage.cache import rounded
from tests.support.reference import ROOT, Says
from tests.unit.solving.test_solve import PINNED

PARAMS = ROOT / "params" / "mbcdm.yaml"

# The promise to scripts: a change here is a change of the API and belongs into the notes of a release.
SIGNATURES = {
    "load": "(path: 'str | Path') -> 'DriveDesign'",
    "reference_design": "(name: 'str' = 'mbcdm') -> 'DriveDesign'",
    "new_design": "(name: 'str', configuration: 'str | None' = None, *, form: 'Form' = 'short') -> 'DriveDesign'",
    "new_design_text": "(name: 'str', configuration: 'str | None' = None, *, form: 'Form' = 'short') -> 'str'",
    "solve": "(design: 'DriveDesign | str | Path', *, jobs: 'int | None' = None, progress: 'Callable[[str, int],"
    " None] | None' = None) -> 'SolveReport'",
    "optimise": "(designs: 'DriveDesign | str | Path | Iterable[DriveDesign | str | Path]', aims: 'Sequence[str]',"
    " out: 'str | Path' = 'out', *, keeps: 'Sequence[str]' = (), free: 'Sequence[str]' = (), only_free: 'bool' ="
    " False, over: \"Literal['tolerances'] | None\" = None, beside: 'Iterable[DriveDesign | str | Path]' = (),"
    " effort: 'Effort | None' = None, progress:"
    " 'Callable[[str, int], None] | None' = None) -> 'Optimum'",
    "prices": "(design: 'DriveDesign | str | Path', figures: 'Sequence[str]', *, workers: 'int | None' = None,"
    " scheduler: 'str | None' = None, progress: 'Progress | None' = None) -> 'Prices'",
    "compare": "(designs: 'Iterable[DriveDesign | str | Path]', out: 'str | Path' = 'out', *, page: 'str | Path"
    " | None' = None, jobs: 'int | None' = None, cache: 'bool' = True, progress: 'Progress | None' = None) ->"
    " 'ComparisonReport'",
    "analyse_many": "(design: 'DriveDesign', ranges: 'Mapping[str, Any]', *, grid: 'bool' = False) -> 'Sweep'",
    "load_run": "(path: 'str | Path') -> 'MeasuredRun'",
    "close_loop": "(design: 'DriveDesign | None', runs: 'MeasuredRun | str | Path | Iterable[MeasuredRun | str |"
    " Path]', *, ratio: 'float | None' = None) -> 'LoopReport'",
    "next_run": "(report: 'LoopReport') -> 'NextRun | None'",
    "trend": "(study: 'str | Path', design: 'DriveDesign | None' = None) -> 'TrendReport'",
    "judge_published": "(design: 'DriveDesign', path: 'str | Path') -> 'PublishedResult'",
    "draft_measurement": (
        "(data: 'str | Path', design: 'DriveDesign | None' = None, *, ratio: 'float | None' = None) -> 'str'"
    ),
    "reproduce": "(design: 'DriveDesign | None' = None) -> 'PaperTable'",
    "catalogue": "(kind: 'str | None' = None) -> 'CatalogueList'",
    "schema": "(configuration: 'str | None' = None, *, measurement: 'bool' = False) -> 'dict[str, Any]'",
    "schema_page": "(configuration: 'str | None' = None, *, measurement: 'bool' = False) -> 'str'",
    "doctor": "(*, cache: 'bool' = False) -> 'Machine'",
    "DriveDesign.with_": "(self, changes: 'Mapping[str, Any] | None' = None, /, **fields: 'Any') -> 'DriveDesign'",
    "DriveDesign.check": "(self) -> 'CheckReport'",
    "DriveDesign.analyse": "(self) -> 'AnalysisReport'",
    "DriveDesign.preload": "(self, out: 'str | Path | None' = None, *, logs: 'Mapping[str, str | Path] | None' = None)"
    " -> 'PreloadReport'",
    "DriveDesign.explain": "(self, field: 'str | None' = None) -> 'Explanation'",
    "DriveDesign.explain_graph": "(self, svg: 'str | Path') -> 'Written'",
    "DriveDesign.sensitivity": "(self, out: 'str | Path' = 'out', *, workers: 'int | None' = None, scheduler:"
    " 'str | None' = None) -> 'SensitivityStudy'",
    "DriveDesign.part_names": "(self) -> 'tuple[str, ...]'",
    "DriveDesign.part": "(self, name: 'str') -> 'cadquery.Solid'",
    "DriveDesign.assembly": "(self, angle_deg: 'float' = 0.0) -> 'cadquery.Assembly'",
    "DriveDesign.build": "(self, out: 'str | Path' = 'out', *, angle_deg: 'float' = 0.0, force: 'bool' = False,"
    " jobs: 'int | None' = None, cache: 'bool' = True, progress: 'Progress | None' = None) -> 'BuildReport'",
    "DriveDesign.page": "(self, out: 'str | Path' = 'out', *, force: 'bool' = False, cache: 'bool' = True,"
    " progress: 'Progress | None' = None) -> 'PageReport'",
    "DriveDesign.drawings": "(self, out: 'str | Path' = 'out', *, part: 'str | None' = None, jobs: 'int | None'"
    " = None, cache: 'bool' = True, progress: 'Progress | None' = None) -> 'Written'",
    "DriveDesign.prints": "(self, out: 'str | Path' = 'out', *, every_made_part: 'bool' = False,"
    " cache: 'bool' = True, progress: 'Progress | None' = None) -> 'Written'",
    "DriveDesign.pictures": "(self, out: 'str | Path' = 'out', *, cache: 'bool' = True, progress: 'Progress |"
    " None' = None) -> 'Written'",
    "DriveDesign.picture": "(self, png: 'str | Path', *, angle_deg: 'float' = 0.0, view: 'str' = 'output',"
    " cache: 'bool' = True, progress: 'Progress | None' = None) -> 'Written'",
    "DriveDesign.moving_picture": "(self, gif: 'str | Path', *, view: 'str' = 'output', cache: 'bool' = True,"
    " progress: 'Progress | None' = None) -> 'Written'",
    "DriveDesign.export": "(self, form: \"Literal['urdf', 'mjcf', 'fmu']\", out: 'str | Path' = 'out', *,"
    " elastic: 'bool' = False, package: 'str | None' = None, xacro: 'bool' = False, ros2_control: 'bool' = False,"
    " cache: 'bool' = True, progress: 'Progress | None' = None) -> 'Written'",
    "DriveDesign.simulate": "(self, experiment: 'str | Path', out: 'str | Path' = 'out') -> 'Written'",
    "DriveDesign.plan": "(self, experiment: 'str | Path', *, noise_from: 'str | Path | None' = None) -> 'RunPlan'",
    "DriveDesign.best_run": "(self, bench: 'str | Path', *, experiment: 'str | Path | None' = None, noise_from:"
    " 'str | Path | None' = None, progress: 'Progress | None' = None) -> 'BestRun'",
    "DriveDesign.save": "(self, path: 'str | Path') -> 'None'",
    "MeasuredRun.to_dict": "(self) -> 'dict[str, Any]'",
    "MeasuredRun.to_pandas": "(self) -> 'pandas.DataFrame'",
}
NAMES = [
    "load",
    "reference_design",
    "new_design",
    "new_design_text",
    "DriveDesign",
    "solve",
    "optimise",
    "Effort",
    "prices",
    "compare",
    "analyse_many",
    "load_run",
    "MeasuredRun",
    "close_loop",
    "next_run",
    "trend",
    "judge_published",
    "draft_measurement",
    "reproduce",
    "catalogue",
    "schema",
    "schema_page",
    "doctor",
    "MbcdmError",
    "InputError",
]


@pytest.fixture(scope="module")
def design() -> mc.DriveDesign:
    return mc.load(PARAMS)


def test_names_and_signatures_are_those_promised() -> None:
    assert api.__all__ == NAMES
    found = {}
    for name in SIGNATURES:
        owner, _, method = name.partition(".")
        target = getattr(mc, owner)
        found[name] = str(inspect.signature(getattr(target, method) if method else target))
    assert found == SIGNATURES
    public = {
        f"{c.__name__}.{n}"
        for c in (mc.DriveDesign, mc.MeasuredRun)
        for n, f in vars(c).items()
        if inspect.isfunction(f) and not n.startswith("_")
    }
    assert public == {name for name in SIGNATURES if "." in name}
    assert set(NAMES) <= set(dir(mc)) and all(inspect.getdoc(getattr(mc, name)) for name in NAMES)


def test_a_name_that_is_not_there_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'loads'"):
        mc.loads  # noqa: B018


def test_results_can_be_printed_shown_and_turned_into_data(design: mc.DriveDesign) -> None:
    swept = mc.analyse_many(design, {"rope.preload_N": [60.0, 70.0]})
    for result in (design.check(), design.analyse(), swept):
        assert design.name in str(result) and "<table>" in result._repr_html_()
        json.dumps(result.to_dict(), allow_nan=False)


def test_check_and_analyse_say_what_the_commands_say(design: mc.DriveDesign, says: Says) -> None:
    for command, result in (("check", design.check()), ("analyse", design.analyse())):
        assert says([command, str(PARAMS)]).out == f"{result}\n"
        assert json.loads(says([command, "--json", str(PARAMS)]).out) == rounded(result.to_dict())


def test_with_changes_one_field_and_leaves_the_design_alone(design: mc.DriveDesign) -> None:
    for changed in (
        design.with_(transmission__centre_distance_mm=36.0),
        design.with_({"transmission": {"centre_distance_mm": 36.0}}),
        design.with_({"transmission.centre_distance_mm": np.float64(36.0)}),
    ):
        assert changed.drive.centre_distance_mm == 36.0 and design.drive.centre_distance_mm == 34.6
        assert changed.drive.cables == design.drive.cables
        assert changed.loaded.sha256 != design.loaded.sha256
    one = design.with_(cables__1__preload_N=65.0).drive
    assert [cable.preload_N for cable in one.cables] == [70.0, 65.0, 70.0, 70.0]
    assert design.with_().drive == design.drive and design.with_().loaded.sha256 == design.loaded.sha256


def test_a_value_with_a_sigma_keeps_it(design: mc.DriveDesign) -> None:
    uncertain = design.with_(rope__preload_N={"value": 70.0, "sigma": 3.0})
    changed = uncertain.with_(rope__preload_N=80.0)
    assert set(changed.drive.sigmas.preload_N) == {3.0} and changed.drive.cables[0].preload_N == 80.0


@pytest.mark.parametrize(
    ("field", "value", "in_file"),
    [
        ("transmission.centre_distance_mm", 0.5, "centre_distance_mm: 0.5 "),
        ("rope.preload_N", "70 N", 'preload_N: "70 N"'),
        ("rope.type", "FF-08", "type: FF-08 "),
    ],
)
def test_messages_are_those_of_the_edited_file(field: str, value: object, in_file: str, tmp_path: Path) -> None:
    path = tmp_path / "d.yaml"
    text = PARAMS.read_text("utf-8")
    path.write_text(text, "utf-8")
    design = mc.load(path)
    with pytest.raises(mc.InputError) as by_program:
        design.with_({field: value})
    name = field.rpartition(".")[2]
    lines = [in_file if line.strip().startswith(f"{name}:") else line for line in text.splitlines()]
    lines = ["  " + line if line == in_file else line for line in lines]
    path.write_text("\n".join(lines) + "\n", "utf-8")
    with pytest.raises(mc.InputError) as by_hand:
        mc.load(path)
    assert str(by_program.value) == str(by_hand.value)


def test_unknown_fields_and_items_are_refused_with_a_remedy(design: mc.DriveDesign) -> None:
    for field, words in (
        ("transmission__centre_distanc_mm", "unknown field; did you mean centre_distance_mm"),
        ("cables__7__step", "cables has no item 7 (value a list of 4, limit 0 to 3)"),
        ("name__x", "name is no block (value 'mbcdm')"),
    ):
        with pytest.raises(mc.InputError) as error:
            design.with_(**{field: 1})
        assert words in str(error.value), error.value


def test_a_saved_design_loads_as_it_was(design: mc.DriveDesign, tmp_path: Path) -> None:
    design.with_(rope__preload_N=66.0).save(tmp_path / "new.yaml")
    again = mc.load(tmp_path / "new.yaml")
    assert again.drive == design.with_(rope__preload_N=66.0).drive
    design.save(tmp_path / "same.yaml")
    assert (tmp_path / "same.yaml").read_bytes() == PARAMS.read_bytes()


def test_many_designs_have_the_figures_of_each(design: mc.DriveDesign) -> None:
    spans = [34.6, 40.0, 55.0]
    many = mc.analyse_many(design, {"transmission__centre_distance_mm": spans})
    assert len(many) == 3 and list(many["transmission.centre_distance_mm"]) == spans
    for k, span in enumerate(spans):
        figures = design.with_(transmission__centre_distance_mm=span).analyse().figures
        assert many["reversal_swing_mrad"][k] == pytest.approx(figures.reversal_swing_mrad, rel=1e-9)
        assert many["turn_plus_mrad"][k] == pytest.approx(figures.test[0].turn_mrad, rel=1e-9)
        assert many["peak_torque_minus_Nm"][k] == pytest.approx(figures.peak_torque_Nm[1], rel=1e-9)
        assert many["cable_backlash_mrad[cable_2]"][k] == pytest.approx(figures.cables[1].backlash_mrad, rel=1e-9)


def test_ranges_are_paired_or_combined(design: mc.DriveDesign) -> None:
    ranges = {"rope.preload_N": [50.0, 60.0, 70.0], "transmission.centre_distance_mm": [35.0, 36.0]}
    grid = mc.analyse_many(design, ranges, grid=True)
    assert len(grid) == 6 and list(grid["transmission.centre_distance_mm"][:3]) == [35.0, 36.0, 35.0]
    assert len(mc.analyse_many(design, {**ranges, "transmission.centre_distance_mm": 35.0})) == 3
    with pytest.raises(MbcdmError, match=r"transmission.centre_distance_mm: values of shape \(2,\) beside others"):
        mc.analyse_many(design, ranges)
    with pytest.raises(MbcdmError, match="no designs to analyse"):
        mc.analyse_many(design, {})
    with pytest.raises(mc.InputError, match=r"rope.preload_N: out of bounds \(value -1"):
        mc.analyse_many(design, {"rope.preload_N": [70.0, -1.0]})
    with pytest.raises(MbcdmError, match="did you mean reversal_swing_mrad"):
        grid["reversal_swing"]


def test_a_design_without_a_free_span_is_marked(design: mc.DriveDesign) -> None:
    many = mc.analyse_many(design, {"transmission.centre_distance_mm": [17.0, 34.6]})
    assert list(many["valid"]) == [False, True] and np.isnan(many["reversal_swing_mrad"][0])
    assert many.to_dict()["reversal_swing_mrad"][0] is None


def test_parts_are_cadquery_solids(design: mc.DriveDesign) -> None:
    cq = pytest.importorskip("cadquery")
    assert {"drum", "frame"} <= set(design.part_names())
    spacer = design.part("guide_spacer")
    assert isinstance(spacer, cq.Solid) and spacer.isValid() and spacer.Volume() > 1.0
    with pytest.raises(MbcdmError, match=r"drumm: no such part; did you mean drum\?"):
        design.part("drumm")


def test_every_instance_has_its_place_and_a_name_of_its_own(
    design: mc.DriveDesign, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Boxes stand in for the solids, so that nothing is drawn; a design may be called after one of its parts."""
    from mbcdm_cad.workshop import store

    cq = pytest.importorskip("cadquery")

    class Box:
        def solid(self) -> object:
            return cq.Solid.makeBox(1.0, 1.0, 1.0).wrapped

    def stand_in(drive: object, angle_deg: float, *_: object) -> object:
        items = store._bill(drive).items  # type: ignore[arg-type]
        return items, {item.part: Box() for item in items}

    monkeypatch.setattr(store, "drawn", stand_in)
    whole = design.with_(name="drum").assembly()
    items = store._bill(design.drive).items
    placed = {
        name.rpartition("/")[2]: part.loc.toTuple()[0] for name, part in whole.objects.items() if part.obj is not None
    }
    assert set(placed) == {item.name for item in items}
    for item in items:
        assert placed[item.name] == pytest.approx(item.location.shift_mm, abs=1e-9), item.name


@pytest.mark.slow
def test_the_assembly_and_the_build(design: mc.DriveDesign, tmp_path: Path) -> None:
    """Every instance in its place; the build by the API is that of the command."""
    box = design.assembly(20.0).toCompound().BoundingBox()
    assert 100.0 < box.xlen < 150.0, f"{box.xlen:.1f} mm long"
    with pytest.raises(MbcdmError, match="beyond the travel"):
        design.assembly(90.0)
    built = design.build(tmp_path)
    assert built.passed and built.folder == tmp_path / "mbcdm" and "interference: 0 clashes" in str(built)
    assert design.build(tmp_path).unchanged


def test_a_design_that_fails_is_not_built(design: mc.DriveDesign, tmp_path: Path) -> None:
    refused = design.with_(transmission__centre_distance_mm=45.0).build(tmp_path)
    assert refused.folder is None and not refused.passed and "not built" in str(refused), refused
    assert list(tmp_path.iterdir()) == [] and refused.to_dict()["checks"]


def test_without_pandas_the_message_says_what_to_do(design: mc.DriveDesign, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MbcdmError, match=r"pandas is not installed.*pip install pandas"):
        design.check().to_pandas()
    stand_in = types.ModuleType("pandas")
    stand_in.DataFrame = lambda columns: columns  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "pandas", stand_in)
    frame: dict[str, list[object]] = design.check().to_pandas()  # type: ignore[assignment]
    assert len(frame["id"]) == len(design.check())
    assert list(design.analyse().to_pandas()["name"]) == ["cable_1", "cable_2", "cable_3", "cable_4"]


def test_a_run_is_read_and_judged(design: mc.DriveDesign, tmp_path: Path) -> None:
    """A perfect run: the API's answer is the command's file, and the declared model explains it."""
    time_s = np.arange(0.0, 20.0, 0.02)
    output = np.radians(30.0) * np.sin(2.0 * np.pi * time_s / 10.0)
    ratio = design.drive.cables[0].drum_radius_mm / design.drive.cables[0].input_radius_mm
    rows = np.column_stack([time_s, output * ratio, output * ratio, output])
    rows[:, 1:] += 1e-6 * np.random.default_rng(0).standard_normal((len(time_s), 3))
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", header="t,a,b,q", comments="")
    columns = {"time": ("t", "s"), "input_left": ("a", "rad"), "input_right": ("b", "rad"), "output": ("q", "rad")}
    lines = [f"  {key}: {{column: {name}, unit: {unit}}}" for key, (name, unit) in columns.items()]
    (tmp_path / "run.yaml").write_text("\n".join(["data: run.csv", "columns:", *lines]) + "\n", "utf-8")
    run = mc.load_run(tmp_path / "run.yaml")
    assert list(run.to_dict()) == ["time_s", "input_left_rad", "input_right_rad", "output_rad"]
    assert "1000 samples over 19.98 s" in repr(run)
    report = mc.close_loop(design, run)
    assert report.verdict == report.to_dict()["verdict"] == "none", str(report)
    assert report.result.sentence in str(report)
    code = cli.run(["loop", str(PARAMS), str(tmp_path / "run.yaml"), "--json", str(tmp_path / "result.json")])
    assert code == 0 and json.loads((tmp_path / "result.json").read_text("utf-8")) == report.to_dict()
    with pytest.raises(mc.InputError, match="the same data as"):
        mc.close_loop(design, [run, tmp_path / "run.yaml"])


def test_no_runs_and_published_figures_are_refused(design: mc.DriveDesign, tmp_path: Path) -> None:
    with pytest.raises(MbcdmError, match="no runs to judge"):
        mc.close_loop(design, [])
    with pytest.raises(MbcdmError, match="no-such"):
        mc.close_loop(design, tmp_path / "no-such.yaml")


def loaded_by(code: str) -> set[str]:
    watched = "{'cadquery', 'OCP', 'scipy', 'matplotlib', 'vtkmodules', 'numba', 'numpy', 'pydantic', 'pandas', 'rich'}"
    done = subprocess.run(
        [sys.executable, "-c", f"import sys\n{code}\nprint(*({watched} & set(sys.modules)))"],
        capture_output=True,
        text=True,
        timeout=600,
        check=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    return set(done.stdout.split())


def test_importing_is_light_and_cad_is_loaded_only_when_asked_for() -> None:
    assert loaded_by("import mbcdm_cad as mc; mc.load, mc.close_loop, dir(mc)") == set()
    checked = loaded_by("import mbcdm_cad as mc; d = mc.load('params/mbcdm.yaml'); d.check(); d.analyse()")
    assert checked <= {"numpy", "pydantic", "scipy"}, checked


@pytest.mark.slow
def test_the_ten_line_sweep_runs(tmp_path: Path) -> None:
    script = ROOT / "docs" / "examples" / "sweep.py"
    code = [line for line in script.read_text("utf-8").splitlines() if line and not line.startswith(("#", '"""'))]
    assert len(code) <= 12, code
    done = subprocess.run(
        [sys.executable, str(script)],
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "agg"},
    )
    assert done.returncode == 0 and "1000 designs, 1000 with a free span" in done.stdout, done.stderr
    assert (tmp_path / "sweep.png").stat().st_size > 5000


# ``analyse_many`` of a short file gives the figures of each design sized alone.


SHORT = """
name: short
configuration: miso_bevel
travel: {half_angle_deg: 30.0}
transmission: {ratio: 9.0, drum_radius_mm: 60.0}
loads: {peak_torque_Nm: 2.0}
"""


def test_rules_may_route_the_cables_of_some_designs_otherwise() -> None:
    """A motor of 87 mm stands behind the drum only if set back."""
    text = SHORT.replace("drum_radius_mm: 60.0", "drum_radius_mm: 60.0, centre_distance_mm: 60.0").replace("9.0", "5.0")
    ranges = {"drive.motor": ["maxon-ec60flat-200W", "tmotor-u8-100kv"]}
    design = mc.DriveDesign(load_text(text + "drive: {gearhead: none}\n"))
    each = [design.with_(drive__motor=motor) for motor in ranges["drive.motor"]]
    assert len({one.drive.input_setback_mm for one in each}) == 2
    swings = [one.analyse().figures.reversal_swing_mrad for one in each]
    assert mc.analyse_many(design, ranges)["reversal_swing_mrad"] == pytest.approx(swings, rel=1e-9)


@pytest.mark.parametrize("layout", ["siso_spur", "miso_spur", "siso_bevel"])
def test_designs_of_other_layouts_are_those_of_each_alone(layout: str) -> None:
    ratio = "input_to_drum: 4.0" if layout == "siso_bevel" else "input_to_drum: 8.0"
    text = SHORT.replace("miso_bevel", layout).replace("ratio: 9.0", ratio)
    design = mc.DriveDesign(load_text(text.replace("peak_torque_Nm: 2.0", "peak_torque_Nm: 0.4")))
    ranges = {"transmission.drum_radius_mm": [60.0, 75.0], "rope.type": ["7x7-1.0", "7x7-0.61"]}
    together = mc.analyse_many(design, ranges)["reversal_swing_mrad"]
    for k in range(2):
        one = design.with_({field: values[k] for field, values in ranges.items()})
        assert together[k] == pytest.approx(one.analyse().figures.reversal_swing_mrad, rel=1e-9)


EXPERIMENT = ROOT / "params" / "experiments" / "null-short-brake.yaml"
# The functions of each command, in the package or of a design.
FUNCTIONS = {
    "analyse": ["DriveDesign.analyse"],
    "build": ["DriveDesign.build"],
    "catalogue": ["catalogue"],
    "check": ["DriveDesign.check"],
    "compare": ["compare"],
    "doctor": ["doctor"],
    "drawings": ["DriveDesign.drawings"],
    "explain": ["DriveDesign.explain", "DriveDesign.explain_graph"],
    "export": ["DriveDesign.export"],
    "init": ["new_design_text", "new_design"],
    "loop": ["close_loop", "next_run", "judge_published"],
    "measurement-init": ["draft_measurement"],
    "optimise": ["optimise"],
    "page": ["DriveDesign.page"],
    "picture": ["DriveDesign.picture", "DriveDesign.moving_picture"],
    "pictures": ["DriveDesign.pictures"],
    "plan": ["DriveDesign.plan", "DriveDesign.best_run"],
    "preload": ["DriveDesign.preload"],
    "prices": ["prices"],
    "prints": ["DriveDesign.prints"],
    "reproduce": ["reproduce"],
    "schema": ["schema", "schema_page"],
    "sensitivity": ["DriveDesign.sensitivity"],
    "simulate": ["DriveDesign.simulate"],
    "solve": ["solve"],
    "trend": ["trend"],
}
# Commands without a function, and why.
ONLY_COMMANDS = {"watch": "runs until it is interrupted, and gives nothing back"}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder with a design file."""
    shutil.copy(ROOT / "params" / "mbcdm-short.yaml", tmp_path / "drive.yaml")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def said(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs a command and gives what it prints on standard output."""

    def run(*arguments: str, code: int = 0) -> str:
        capsys.readouterr()
        assert cli.run(list(arguments)) == code, capsys.readouterr().err
        return capsys.readouterr().out

    return run


def function(name: str) -> Any:
    owner, _, method = name.rpartition(".")
    return getattr(getattr(mc, owner) if owner else mc, method)


def test_each_command_has_its_functions() -> None:
    assert set(FUNCTIONS) | set(ONLY_COMMANDS) == set(mbcdm.commands)
    for command, names in FUNCTIONS.items():
        for name in names:
            words = inspect.getdoc(function(name)) or ""
            assert len(words) > 60, f"{name} is not documented"
        assert any(f"mbcdm {command}" in (inspect.getdoc(function(name)) or "") or name == "schema" for name in names)


def test_what_a_command_writes_is_what_its_function_gives(folder: Path, said: Callable[..., str]) -> None:
    design = mc.load("drive.yaml")
    assert said("explain", "drive.yaml") == f"{design.explain()}\n"
    assert said("explain", "drive.yaml", "support.back_y_mm") == f"{design.explain('support.back_y_mm')}\n"
    assert json.loads(said("explain", "drive.yaml", "--json")) == rounded(design.explain().to_dict())
    said("explain", "drive.yaml", "--graph", "command.svg")
    assert design.explain_graph("function.svg").files == (Path("function.svg"),)
    assert Path("command.svg").read_text() == Path("function.svg").read_text()

    for form in ("short", "full", "reference"):
        said("init", f"new-{form}.yaml", *([] if form == "short" else [f"--{form}"]))
        assert Path(f"new-{form}.yaml").read_text() == mc.new_design_text(f"new-{form}", form=form)  # type: ignore[arg-type]
        assert mc.load(f"new-{form}.yaml").drive == mc.new_design(f"new-{form}", form=form).drive  # type: ignore[arg-type]
    for measurement in (False, True):
        words = ["schema", *(["--measurement"] if measurement else [])]
        assert json.loads(said(*words)) == mc.schema(measurement=measurement)
        assert said(*words, "--reference") == mc.schema_page(measurement=measurement)
    for kind in (None, "ropes"):
        words = ["catalogue", *([kind] if kind else [])]
        assert said(*words) == f"{mc.catalogue(kind)}\n"
        assert said(*words, "--markdown") == mc.catalogue(kind).markdown()
    assert mc.catalogue("ropes").to_dict()["ropes"]["FF-081"]["diameter_mm"] == pytest.approx(0.81)
    assert said("reproduce") == str(mc.reproduce())
    with pytest.raises(mc.MbcdmError, match="catalogue: no such kind"):
        mc.catalogue("rope")


def test_the_search_gives_the_same_design_and_patch(folder: Path, said: Callable[..., str]) -> None:
    Path("pinned.yaml").write_text(PINNED)
    found = mc.solve("pinned.yaml")
    assert said("solve", "pinned.yaml", "--apply", "solved.yaml") == f"{found}\nsolved.yaml written\n"
    found.save("saved.yaml")
    assert Path("saved.yaml").read_text() == Path("solved.yaml").read_text() == found.design_text
    assert json.loads(said("solve", "pinned.yaml", "--json")) == rounded(found.to_dict())
    assert mc.load("saved.yaml").check().passed and [one.field for one in found.changes] == ["drum.outer_face_y_mm"]


def test_runs_are_simulated_judged_and_planned_alike(folder: Path, said: Callable[..., str]) -> None:
    design = mc.load("drive.yaml")
    printed = said("simulate", "drive.yaml", str(EXPERIMENT), "--out", "command")
    run = design.simulate(EXPERIMENT, "function")
    assert printed.replace("command", "function") == f"{run}\n"
    for path in run.files:
        assert path.read_bytes() == (folder / "command" / path.parent.name / path.name).read_bytes(), path
    measured = run.folder / f"{EXPERIMENT.stem}.yaml"
    judged = mc.close_loop(design, measured)
    outputs = ["--json", "result.json", "--apply", "built.yaml", "--report", "page", "--correction", "table"]
    printed = said("loop", "drive.yaml", str(measured), *outputs, "--next", "next.yaml")
    assert printed.startswith(f"{judged}\n")
    assert json.loads(Path("result.json").read_text()) == rounded(judged.to_dict())
    assert Path("built.yaml").read_text() == judged.as_built_text()
    assert (folder / "page" / "report.html").read_bytes() == judged.page()
    assert {path.name: path.read_bytes() for path in (folder / "table").iterdir()} == judged.correction_files()
    assert (mc.next_run(judged) is None) == ("no set of possible effects is left" in printed)

    assert said("plan", "drive.yaml", str(EXPERIMENT)) == f"{design.plan(EXPERIMENT).text()}\n"
    data = next(path for path in run.files if path.suffix == ".csv")
    printed = said("measurement-init", str(data), "drive.yaml", "--out", str(data.with_name("draft.yaml")))
    assert printed.startswith(mc.draft_measurement(data, design))


@pytest.mark.slow
def test_what_is_drawn_is_the_same_file_by_file(folder: Path, said: Callable[..., str]) -> None:
    """Each command into one folder and its function into another."""
    design = mc.load("drive.yaml")
    pairs: list[tuple[list[str], Callable[[str], Any]]] = [
        (["build"], lambda out: design.build(out)),
        (["page"], lambda out: design.page(out)),
        (["drawings", "--part", "drum"], lambda out: design.drawings(out, part="drum")),
        (["prints", "--all"], lambda out: design.prints(out, every_made_part=True)),
        (["pictures"], lambda out: design.pictures(out)),
        (["export", "--format", "mjcf", "--elastic"], lambda out: design.export("mjcf", out, elastic=True)),
        (["sensitivity"], lambda out: design.sensitivity(out)),
    ]
    for (command, *options), call in pairs:
        printed = said(command, "drive.yaml", *options, "--out", "command")
        result = call("function")
        # The first of both draws the parts, the second takes them from the cache.
        first, second = (re.sub(r"\d+ made", "made", text) for text in (printed, f"{result}\n"))
        assert first.replace("command", "function").startswith(second), command
    files = {
        path.relative_to(out): path.read_bytes()
        for out in ("command", "function")
        for path in Path(out).rglob("*")
        if path.is_file()
    }
    for name, content in files.items():
        for out in ("command", "function"):
            assert (Path(out) / name).read_bytes() == content, f"{out}/{name}"
    said("picture", "drive.yaml", "command.png", "--view", "iso", "--angle", "10")
    design.picture("function.png", view="iso", angle_deg=10.0)
    said("picture", "drive.yaml", "command.gif", "--travel")
    design.moving_picture("function.gif")
    for kind in ("png", "gif"):
        assert Path(f"command.{kind}").read_bytes() == Path(f"function.{kind}").read_bytes(), kind
    with pytest.raises(mc.MbcdmError, match="no such view"):
        design.picture("side.png", view="side")
    with pytest.raises(mc.MbcdmError, match="URDF has no springs"):
        design.export("urdf", elastic=True)
    with pytest.raises(mc.MbcdmError, match="they belong to ROS"):
        design.export("mjcf", xacro=True)


@pytest.mark.slow
def test_designs_of_one_name_are_compared_by_their_files(folder: Path, said: Callable[..., str]) -> None:
    design = mc.new_design("drive", "siso_spur")
    for name, half_angle in (("left", 40), ("right", 30)):
        design.with_(travel__half_angle_deg=half_angle).save(f"{name}.yaml")
    found = mc.compare(["left.yaml", "right.yaml"])
    assert [design.name for design in found.designs] == ["left.yaml", "right.yaml"]
    assert said("compare", "left.yaml", "right.yaml") == f"{found}\n"
    assert json.loads(said("compare", "left.yaml", "right.yaml", "--json")) == rounded(found.to_dict())
    assert found.designs[0].travel_deg == 80.0 and found.designs[1].travel_deg == 60.0
    mc.load("left.yaml").build()
    with pytest.raises(mc.MbcdmError, match="another design file with the same name"):
        mc.load("right.yaml").build()
