"""The main job as a user runs it: each command in its own process, a new output folder; FreeCAD reads its STEP."""

import filecmp
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import cadquery as cq
import pytest

from mbcdm_cad.design.bought import Material
from mbcdm_cad.parts.bill import Item, Placement
from mbcdm_cad.storage.folders import ORIGIN_NAME
from mbcdm_cad.workshop.export.step import assembly_step
from tests.acceptance.check_output import faults
from tests.acceptance.freecad import differences, freecad_findings, freecad_program, read_parts
from tests.support.reference import ROOT

REFERENCE = ROOT / "params" / "mbcdm.yaml"


def mbcdm(*arguments: str | Path, cache: Path, timeout: float = 600) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"MBCDM_CACHE_DIR": str(cache)}
    command = [sys.executable, "-m", "mbcdm_cad", *map(str, arguments)]
    return subprocess.run(
        command, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=timeout, check=False
    )


def edited(folder: Path, name: str, *changes: tuple[str, str]) -> Path:
    """A copy of the reference design with other values, each change a text that stands once in the file."""
    text = REFERENCE.read_text("utf-8")
    for old, new in (("name: mbcdm", f"name: {name}"), *changes):
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in {REFERENCE}"
        text = text.replace(old, new)
    path = folder / f"{name}.yaml"
    path.write_text(text, "utf-8")
    return path


def files_of(folder: Path) -> list[str]:
    """Files of the output by name, but for the record of where the design file is."""
    files = (p for p in folder.rglob("*") if p.is_file() and p.name != ORIGIN_NAME)
    return sorted(p.relative_to(folder).as_posix() for p in files)


def assert_equal_folders(first: Path, second: Path) -> None:
    assert files_of(first) == files_of(second)
    _, mismatch, errors = filecmp.cmpfiles(first, second, files_of(first), shallow=False)
    assert not mismatch and not errors, f"differ: {mismatch}, unreadable: {errors}"


@pytest.fixture(scope="module")
def cache(shared_cache: Path) -> Path:
    return shared_cache


@pytest.fixture(scope="module")
def built(cache: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("out")
    done = mbcdm("build", REFERENCE, "--out", out, cache=cache)
    assert done.returncode == 0, done.stdout + done.stderr
    return out / "mbcdm"


def test_reference_design_meets_mass_box_and_has_no_clash(built: Path) -> None:
    report = json.loads((built / "report.json").read_text("utf-8"))
    assert faults(report, files_of(built)) == []


def test_the_readme_states_the_figures_of_the_build(built: Path) -> None:
    report, readme = json.loads((built / "report.json").read_text("utf-8")), (ROOT / "README.md").read_text("utf-8")
    mass, torque, structure = report["mass"], report["torque"], report["structure"]
    rows = (
        f"| mass | {mass['mass_g']:.1f} g +- {mass['sigma_g']:.1f} g ",
        "| box X x Z x Y | {:.2f} x {:.2f} x {:.2f} mm |".format(*report["envelope"]["size_mm"]),
        f" by the cables alone | {structure['cables_swing_mrad']:.3f} mrad ",
        f" with drum, shafts, bearings and frame | {structure['payload_swing_mrad']:.3f} mrad |",
        f" | {torque['peak_positive_Nm']:.2f} N m in one direction, {torque['peak_negative_Nm']:.2f} in the other |",
        f"| torque to weight, weaker direction | {torque['torque_to_weight_Nm_kg']:.2f} N m/kg |",
        f" due to the frame's deflection at 0.91 N m | {report['frame']['windup_at_test_torque_mrad']:.3f} mrad |",
    )
    assert [row for row in rows if row not in readme] == []


def test_report_says_what_sets_each_field(built: Path) -> None:
    report = json.loads((built / "report.json").read_text("utf-8"))
    entry = next(one for one in report["fields"] if one["field"] == "transmission.centre_distance_mm")
    assert entry["driver"] == "fleet_angle" and entry["value"] == 34.6 and entry["rule_value"] == 34.5, entry
    assert "| transmission.centre_distance_mm | 34.6 | the file; the rule gives 34.5 (fleet_angle) |" in (
        built / "report.md"
    ).read_text("utf-8")


@pytest.mark.skipif(
    freecad_program() is None, reason="FreeCAD is not installed (Debian: apt-get install freecad-python3)"
)
@pytest.mark.slow
def test_freecad_reads_every_solid(built: Path) -> None:
    step = built / "mbcdm.step"
    assert differences(freecad_findings(step), read_parts(step)) == []


def test_manifest_lists_every_file_and_the_versions(built: Path) -> None:
    manifest = json.loads((built / "manifest.json").read_text("utf-8"))
    assert sorted(manifest["files"]) == [name for name in files_of(built) if name != "manifest.json"]
    assert manifest["forced"] is False and {"mbcdm_cad", "cadquery", "cadquery-ocp"} <= set(manifest["versions"])


def test_nothing_changed_needs_no_kernel(built: Path, cache: Path) -> None:
    code = (
        "import sys; from mbcdm_cad.cli import run; "
        f"code = run(['build', {str(REFERENCE)!r}, '--out', {str(built.parent)!r}]); "
        "print(code, sorted(m for m in sys.modules if m.split('.')[0] in ('cadquery', 'OCP')))"
    )
    environment = os.environ | {"MBCDM_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert "nothing changed" in done.stdout
    assert done.stdout.splitlines()[-1] == "0 []", done.stdout


@pytest.mark.parametrize("command", ["check", "analyse"])
def test_check_and_analyse_never_import_the_kernel(command: str, tmp_path: Path) -> None:
    code = (
        f"import sys; from mbcdm_cad.cli import run; run([{command!r}, {str(REFERENCE)!r}]); "
        "print(sorted(m for m in sys.modules if m.split('.')[0] in ('cadquery', 'OCP')))"
    )
    environment = os.environ | {"MBCDM_CACHE_DIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]", done.stdout


@pytest.mark.slow
def test_one_parameter_edited_redraws_only_what_depends_on_it(built: Path, cache: Path, tmp_path: Path) -> None:
    design = edited(tmp_path, "thicker_web", ("web_thickness_mm: 2.4", "web_thickness_mm: 2.13"))
    done = mbcdm("build", design, "--out", tmp_path, cache=cache)
    assert done.returncode == 0, done.stdout + done.stderr
    made = done.stdout.splitlines()[0].partition("made: ")[2].split(", ")
    # The stop pin reaches through the web and the shaft's flats lie before it, so both follow.
    assert sorted(made) == ["assembly", "drum", "drum_shaft", "interference at 9 poses", "stop_pin"], done.stdout


@pytest.mark.slow
def test_failing_design_is_refused_and_forced_output_says_so(cache: Path, tmp_path: Path) -> None:
    design = edited(tmp_path, "stiff_rope", ("bend_ratio_min: 14.8", "bend_ratio_min: 16.0"))
    refused = mbcdm("build", design, "--out", tmp_path / "out", cache=cache)
    assert refused.returncode == 1 and "--force" in refused.stderr, refused.stderr
    assert not (tmp_path / "out" / "stiff_rope").exists()
    forced = mbcdm("build", design, "--out", tmp_path / "out", "--force", cache=cache)
    assert forced.returncode == 1, forced.stderr
    folder = tmp_path / "out" / "stiff_rope"
    failed = json.loads((folder / "manifest.json").read_text("utf-8"))["failed_checks"]
    assert failed
    for name in files_of(folder):
        assert failed[0].encode() in (folder / name).read_bytes(), f"{name} does not say which check fails"


@pytest.mark.parametrize("angle", ["nan", "inf", "36", "-1e9", "x"])
def test_senseless_angle_is_bad_input(angle: str, cache: Path, tmp_path: Path) -> None:
    done = mbcdm("build", REFERENCE, "--angle", angle, "--out", tmp_path, cache=cache)
    assert done.returncode == 2 and "Traceback" not in done.stderr, done.stderr
    assert not (tmp_path / "mbcdm").exists()


@pytest.mark.slow
def test_same_bytes_in_any_process_with_and_without_the_cache(built: Path, cache: Path, tmp_path: Path) -> None:
    for number, options in enumerate((("--no-cache", "--jobs", "1"), ("--jobs", "2"))):
        out = tmp_path / str(number)
        done = mbcdm("build", REFERENCE, "--out", out, *options, cache=cache)
        assert done.returncode == 0, done.stderr
        assert_equal_folders(built, out / "mbcdm")


@pytest.mark.slow
def test_assembly_turned_to_both_ends_has_the_same_parts_and_no_page_of_the_other(
    built: Path, cache: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "mbcdm"
    for angle in ("-35", "35"):
        done = mbcdm("build", REFERENCE, "--angle", angle, "--out", tmp_path, cache=cache)
        assert done.returncode == 0, done.stderr
        assert not (folder / "report.html").exists(), "the page of the build before stands beside the new report"
        (folder / "report.html").write_text("<p>a page of this build</p>")
        rigid = [n for n in files_of(built) if n.startswith("parts/") and "cable" not in n]
        _, mismatch, errors = filecmp.cmpfiles(built, folder, rigid, shallow=False)
        assert not mismatch and not errors


@pytest.mark.slow
def test_killed_at_any_moment_the_previous_output_stays_whole(built: Path, cache: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(built, out / "mbcdm")
    before = {name: (out / "mbcdm" / name).read_bytes() for name in files_of(out / "mbcdm")}
    generator = random.Random(7)
    environment = os.environ | {"MBCDM_CACHE_DIR": str(cache)}
    ended = 0
    for attempt in range(12):
        command = [
            sys.executable,
            "-m",
            "mbcdm_cad",
            "build",
            str(REFERENCE),
            "--out",
            str(out),
            "--angle",
            f"{attempt + 1}",
        ]
        process = subprocess.Popen(
            command, env=environment, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        time.sleep(generator.uniform(0.1, 3.0))
        process.send_signal(signal.SIGKILL)
        process.wait()
        folder = out / "mbcdm"
        manifest = json.loads((folder / "manifest.json").read_text("utf-8"))
        now = {name: (folder / name).read_bytes() for name in files_of(folder)}
        whole = set(manifest["files"]) | {"manifest.json"} == set(now)
        assert whole, f"attempt {attempt}: {set(manifest['files']) ^ set(now)}"
        if now != before:  # that build had come to its end before the signal
            ended += 1
            before = now
    assert ended < 12, "every build ended before it was killed: nothing was tested"


@pytest.mark.slow
@pytest.mark.parametrize("most_bytes", [200_000, 2_000_000])
def test_full_disk_leaves_the_previous_output_whole(most_bytes: int, built: Path, cache: Path, tmp_path: Path) -> None:
    """The system refuses files above a size, as it does on a full disk: in the parts, later in the assembly."""
    shutil.copytree(built, tmp_path / "mbcdm")
    code = (
        f"import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, ({most_bytes}, {most_bytes})); "
        "from mbcdm_cad.cli import run; sys.exit(run(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", code, "build", str(REFERENCE), "--out", str(tmp_path), "--angle", "5"]
    environment = os.environ | {"MBCDM_CACHE_DIR": str(cache)}
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 2, done.stdout + done.stderr
    assert "cannot write" in done.stderr and "Traceback" not in done.stderr, done.stderr
    assert_equal_folders(built, tmp_path / "mbcdm")
    assert [path.name for path in tmp_path.iterdir()] == ["mbcdm"], "something is left beside the output"


@pytest.mark.slow
def test_two_builds_at_once_into_one_folder(built: Path, cache: Path, tmp_path: Path) -> None:
    environment = os.environ | {"MBCDM_CACHE_DIR": str(cache)}
    command = [sys.executable, "-m", "mbcdm_cad", "build", str(REFERENCE), "--out", str(tmp_path)]
    processes = [
        subprocess.Popen(command, env=environment, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    for process in processes:
        _, errors = process.communicate(timeout=600)
        assert process.returncode == 0, errors
    assert_equal_folders(built, tmp_path / "mbcdm")
    assert [path.name for path in tmp_path.iterdir()] == ["mbcdm"], "something is left beside the output"


needs_freecad = pytest.mark.skipif(
    freecad_program() is None, reason="FreeCAD is not installed (Debian: apt-get install freecad-python3)"
)
STEEL = Material(
    name="steel",
    density_g_cm3=7.85,
    youngs_modulus_GPa=200.0,
    poisson_ratio=0.3,
    yield_MPa=500.0,
    process="turned",
    min_wall_mm=1.0,
    min_internal_radius_mm=1.0,
    colour=(0.3, 0.3, 0.3),
    source="test",
)


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[tuple[str, float]]]:
    wire = cq.Workplane(cq.Wire.makeHelix(0.87, 0.87 * 1.75, 6.4))
    plane = cq.Plane((6.4, 0, 0), (1, 0, 0), (0, 1, 0))
    solids = {
        "plate": cq.Workplane().box(60, 40, 5).faces(">Z").workplane().hole(8).val().Solids()[0],
        "cable_1": cq.Workplane(plane).circle(0.405).sweep(wire, isFrenet=True).val(),
        "nut": cq.Workplane().polygon(6, 4).extrude(1.5).val(),
    }
    items = [
        Item(
            f"{part}_{n}",
            part,
            STEEL,
            "made",
            Placement.translation(70.0 * n, 50.0 * k, 0.0) @ Placement.about((1, 1, 0), 20.0 * n),
            f"group_{n}",
        )
        for k, part in enumerate(solids)
        for n in range(2)
    ]
    path = tmp_path_factory.mktemp("step") / "model.step"
    path.write_bytes(assembly_step("model", items, solids))
    return path, [(item.part, solids[item.part].Volume()) for item in items]


@needs_freecad
def test_freecad_reads_what_was_written(model: tuple[Path, list[tuple[str, float]]]) -> None:
    path, expected = model
    findings = freecad_findings(path)
    assert differences(findings, expected) == []
    assert findings["assemblies"] == ["group_0", "group_1", "model"]


@needs_freecad
def test_differences_are_seen(model: tuple[Path, list[tuple[str, float]]]) -> None:
    path, expected = model
    findings = freecad_findings(path)
    heavier = [(name, volume * (1 + 3e-6)) for name, volume in expected]
    assert any("volume of all" in line for line in differences(findings, heavier))
    assert any("missing ['bolt']" in line for line in differences(findings, [("bolt", expected[0][1]), *expected[1:]]))
    assert differences(findings, expected[1:])[0] == "6 solids, expected 5"


def test_own_reader_agrees(model: tuple[Path, list[tuple[str, float]]]) -> None:
    path, expected = model
    found = sorted(read_parts(path))
    assert [name for name, _ in found] == sorted(name for name, _ in expected)
    for (name, volume), (_, wanted) in zip(found, sorted(expected), strict=True):
        assert volume == pytest.approx(wanted, rel=1e-6), name


@needs_freecad
def test_what_is_no_step_file_is_said(tmp_path: Path) -> None:
    path = tmp_path / "bad.step"
    path.write_text("not a STEP file")
    with pytest.raises(RuntimeError, match="no findings"):
        freecad_findings(path)
