"""The output folder is complete before and after a build, even if the build is killed."""

from __future__ import annotations

import errno
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from mbcdm_cad.errors import OutputError
from mbcdm_cad.storage import folders
from mbcdm_cad.storage.folders import (
    MANIFEST_NAME,
    ORIGIN_NAME,
    Manifest,
    altered_files,
    output_folder,
    read_manifest,
    refuse_other_origin,
    write_from,
)

ROOT = Path(__file__).parents[3]
FACTS = Manifest(design_sha256="d", inputs_sha256="i")

# Builds generation after generation into argv[1] until killed: 12 files that all say which generation they are of.
BUILDER = """
import sys
from pathlib import Path
from mbcdm_cad.storage import folders
from mbcdm_cad.storage.folders import Manifest
from mbcdm_cad.storage.folders import output_folder
target, tag, first, count, exchange = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), sys.argv[5]
if exchange == "no":
    folders._exchange = lambda first, second: False
print("ready", flush=True)
for generation in range(first, first + count):
    with output_folder(target, Manifest("d", f"{tag}{generation}")) as folder:
        for k in range(12):
            folder.write(f"parts/{k}.bin", f"{tag}{generation} " * 2000)
    print(generation, flush=True)
"""


def build(target: Path, text: str = "one", copies: int = 100) -> None:
    with output_folder(target, FACTS) as folder:
        folder.write("report.md", text)
        folder.write("parts/disc.stl", text.encode() * (10_000 // copies))


def start(target: Path, tag: str, first: int, count: int, exchange: str = "yes") -> subprocess.Popen[str]:
    command = [sys.executable, "-c", BUILDER, str(target), tag, str(first), str(count), exchange]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT)


def leftovers(target: Path) -> list[str]:
    return sorted(path.name for path in target.parent.iterdir() if path != target)


def assert_whole(target: Path) -> str:
    """Every file is as the manifest says and all are of one generation, which is returned."""
    manifest = read_manifest(target)
    assert manifest is not None, f"no manifest in {target}"
    assert altered_files(target, manifest) == []
    generations = {(target / name).read_text().split()[0] for name in manifest.files}
    assert generations == {manifest.inputs_sha256}, f"mixed generations {generations}"
    return manifest.inputs_sha256


def test_files_and_manifest(tmp_path: Path) -> None:
    target = tmp_path / "deep" / "out"
    build(target)
    manifest = read_manifest(target)
    assert manifest is not None
    assert sorted(manifest.files) == ["parts/disc.stl", "report.md"]
    assert manifest.files["parts/disc.stl"].size == 300
    assert altered_files(target, manifest) == []
    (target / "report.md").write_text("two")
    (target / "parts" / "disc.stl").unlink()
    assert altered_files(target, manifest) == ["parts/disc.stl", "report.md"]
    assert leftovers(target) == []


def test_same_build_same_manifest(tmp_path: Path) -> None:
    build(tmp_path / "a")
    build(tmp_path / "b")
    assert (tmp_path / "a" / MANIFEST_NAME).read_bytes() == (tmp_path / "b" / MANIFEST_NAME).read_bytes()


def test_folder_is_readable_to_others_as_usual(tmp_path: Path) -> None:
    build(tmp_path / "out")
    plain = tmp_path / "plain"
    plain.mkdir()
    assert (tmp_path / "out").stat().st_mode == plain.stat().st_mode


def test_files_of_the_build_before_are_gone(tmp_path: Path) -> None:
    target = tmp_path / "out"
    with output_folder(target, FACTS) as folder:
        folder.write("parts/old.stl", "x")
    build(target)
    assert not (target / "parts" / "old.stl").exists()


def test_somebodys_own_files_move_along(tmp_path: Path) -> None:
    target = tmp_path / "out"
    build(target)
    (target / "notes").mkdir()
    (target / "notes" / "mine.txt").write_text("mine")
    (target / "link").symlink_to("report.md")
    for _ in range(2):
        build(target, "two")
    assert (target / "notes" / "mine.txt").read_text() == "mine"
    assert (target / "link").read_text() == "two"
    assert "notes/mine.txt" not in read_manifest(target).files


def test_somebodys_own_file_is_not_overwritten(tmp_path: Path) -> None:
    target = tmp_path / "out"
    with output_folder(target, FACTS) as folder:
        folder.write("a.txt", "a")
    (target / "report.md").write_text("mine")
    with pytest.raises(OutputError, match=r"report\.md.*move it away"):
        build(target)
    assert (target / "report.md").read_text() == "mine"


@pytest.mark.parametrize("exchange", [True, False])
def test_exception_leaves_the_last_output(tmp_path: Path, exchange: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not exchange:
        monkeypatch.setattr(folders, "_exchange", lambda first, second: False)
    target = tmp_path / "out"
    build(target)
    with pytest.raises(ZeroDivisionError):
        build(target, "two", copies=0)  # fails at its second file
    assert (target / "report.md").read_text() == "one"
    build(target, "three")
    assert (target / "report.md").read_text() == "three"
    assert leftovers(target) == []


@pytest.mark.parametrize("content", [None, "{}", '{"generator": "other"}', "[" * 100_000, "\x00"])
def test_foreign_folder_is_refused(tmp_path: Path, content: str | None) -> None:
    target = tmp_path / "home"
    target.mkdir()
    (target / "thesis.txt").write_text("ten years of work")
    if content is not None:
        (target / MANIFEST_NAME).write_text(content)
    with pytest.raises(OutputError, match="not made by this program"):
        build(target)
    assert (target / "thesis.txt").read_text() == "ten years of work"
    assert leftovers(target) == []


def test_empty_folder_is_taken_and_a_file_is_not(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    build(tmp_path / "empty")
    (tmp_path / "file").write_text("x")
    with pytest.raises(OutputError, match="there is a file of that name"):
        build(tmp_path / "file")
    with pytest.raises(OutputError, match="cannot write"):
        build(tmp_path / "file" / "below")


def test_link_to_a_folder_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "disk").mkdir()
    (tmp_path / "out").symlink_to("disk")
    build(tmp_path / "out")
    assert (tmp_path / "out").is_symlink()
    assert (tmp_path / "disk" / "report.md").read_text() == "one"


@pytest.mark.parametrize(
    "name", ["", ".", "..", "../x", "a/../../x", "/etc/x", "a\\..\\x", "a\0b", MANIFEST_NAME, "./" + MANIFEST_NAME]
)
def test_names_that_leave_the_folder_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match="plain relative name"), output_folder(tmp_path / "out", FACTS) as folder:
        folder.write(name, "x")


@pytest.mark.parametrize("failing", [1, 2, 3])
def test_full_disk_leaves_the_last_output(tmp_path: Path, failing: int, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "out"
    build(target)
    calls = 0
    real = Path.write_bytes

    def write_bytes(path: Path, data: bytes) -> int:
        nonlocal calls
        calls += 1
        if calls == failing:
            real(path, data[: len(data) // 2])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        return real(path, data)

    monkeypatch.setattr(Path, "write_bytes", write_bytes)
    if failing <= 2:
        with pytest.raises(OutputError, match=r"No space left on device.*What was there before is unchanged"):
            build(target, "two")
        assert (target / "report.md").read_text() == "one"
    else:
        build(target, "two")
    assert leftovers(target) == []
    assert altered_files(target, read_manifest(target)) == []


def test_disk_that_fills_up_at_the_last_sync(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "out"
    build(target)

    def fsync(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", fsync)
    with pytest.raises(OutputError, match="No space left"):
        build(target, "two")
    assert (target / "report.md").read_text() == "one"


def test_real_full_disk(tmp_path: Path) -> None:
    """On a file system of 300 kB: the first output fits, the second beside it does not."""
    mount = f"mount -t tmpfs -o size=300k tmpfs {tmp_path}"
    unshare = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c"]
    if shutil.which("unshare") is None or subprocess.run([*unshare, mount], capture_output=True).returncode:
        pytest.skip("no file system of its own can be mounted here")
    script = """
import sys
from pathlib import Path
from mbcdm_cad.storage.folders import Manifest, altered_files, read_manifest
from mbcdm_cad.errors import OutputError
from mbcdm_cad.storage.folders import output_folder
target = Path(sys.argv[1])
def build(size):
    with output_folder(target, Manifest("d", str(size))) as folder:
        for k in range(10):
            folder.write(f"{k}.bin", bytes(size))
build(10_000)
try:
    build(30_000)
except OutputError as error:
    print(error)
manifest = read_manifest(target)
print(manifest.inputs_sha256, altered_files(target, manifest), len(list(target.parent.iterdir())))
"""
    command = f'{mount} && exec "$0" -c "$1" "$2"'
    done = subprocess.run(
        [*unshare, command, sys.executable, script, str(tmp_path / "out")],
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=True,
    )
    first, last = done.stdout.splitlines()
    assert "No space left on device" in first
    assert last == "10000 [] 1", f"the output alone expected, got {last}"


@pytest.mark.parametrize("exchange", ["yes", "no"])
def test_killed_at_any_moment(tmp_path: Path, exchange: str) -> None:
    target = tmp_path / "out"
    with output_folder(target, Manifest("d", "a0")) as folder:
        folder.write("x", "a0")
    chance = random.Random(exchange)
    last, moments = 0, set()
    for _ in range(8):
        process = start(target, "a", last + 1, 1000, exchange)
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(chance.uniform(0.0, 0.08))
        process.send_signal(signal.SIGKILL)
        last = max([last, *map(int, process.communicate()[0].split())])
        if exchange == "yes":
            assert assert_whole(target) in (f"a{last}", f"a{last + 1}")
        moments.add(tuple(name.split("-")[0] for name in leftovers(target)))
        with pytest.raises(ZeroDivisionError), output_folder(target, FACTS):
            raise ZeroDivisionError  # the next build puts things right even if it comes to nothing itself
        found = assert_whole(target)
        assert found in (f"a{last}", f"a{last + 1}"), f"{found} after build {last}"
        assert leftovers(target) == []
        last = int(found[1:])
    assert moments != {()}, "no kill struck in the middle of a build: the test shows nothing"


def test_two_builds_at_once(tmp_path: Path) -> None:
    target = tmp_path / "out"
    processes = [start(target, tag, 1, 15) for tag in "ab"]
    for process in processes:
        process.communicate(timeout=600)
        assert process.returncode == 0
    assert assert_whole(target) in ("a15", "b15")
    assert leftovers(target) == []


def test_build_that_waits_too_long_says_so(tmp_path: Path) -> None:
    target = tmp_path / "out"
    with output_folder(target, FACTS) as folder:
        folder.write("x", "one")
        with (
            pytest.raises(OutputError, match="another build has been writing here"),
            output_folder(target, FACTS, 0.05),
        ):
            pass
    assert (target / "x").read_text() == "one"


def test_swap_that_died_half_way_is_undone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "out"
    build(target)
    monkeypatch.setattr(folders, "_exchange", lambda first, second: False)
    real: Any = Path.rename
    monkeypatch.setattr(
        Path, "rename", lambda a, b: (_ for _ in ()).throw(KeyboardInterrupt) if b == target else real(a, b)
    )
    with pytest.raises(KeyboardInterrupt):
        build(target, "two")
    monkeypatch.setattr(Path, "rename", real)
    assert not target.exists()
    with pytest.raises(ZeroDivisionError), output_folder(target, FACTS):
        raise ZeroDivisionError
    assert (target / "report.md").read_text() == "one"


def test_no_kernel_is_imported() -> None:
    code = (
        "import sys, mbcdm_cad.storage.folders, mbcdm_cad.storage.folders as m; m.versions(); "
        "print([n for n in ('cadquery', 'OCP', 'numpy', 'vtkmodules') if n in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout == "[]\n"


ORIGIN_FACTS = Manifest("d", "i")


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    """Two design files; their content does not matter here."""
    left, right = tmp_path / "left.yaml", tmp_path / "right.yaml"
    left.write_text("name: drive\n")
    right.write_text("name: drive\n")
    return left, right


def origin_build(target: Path, design: Path, text: str) -> None:
    with output_folder(target, ORIGIN_FACTS, design=design) as folder:
        folder.write("report.md", text)


def test_a_second_file_of_the_name_is_refused_and_told_what_to_do(tmp_path: Path, files: tuple[Path, Path]) -> None:
    left, right = files
    target = tmp_path / "out" / "drive"
    origin_build(target, left, "left")
    with pytest.raises(OutputError) as refused:
        origin_build(target, right, "right")
    words = str(refused.value)
    for part in (str(target), str(left), str(right), "change name", "--out"):
        assert part in words, words
    assert (target / "report.md").read_text() == "left"
    origin_build(target, left, "left again")
    assert (target / "report.md").read_text() == "left again"


def test_files_beside_the_build_are_refused_as_well(tmp_path: Path, files: tuple[Path, Path]) -> None:
    left, right = files
    target = tmp_path / "drive-drawings"
    write_from(left, target, {"drum.dxf": b"left"})
    with pytest.raises(OutputError, match="another design file with the same name"):
        write_from(right, target, {"drum.dxf": b"right"})
    assert (target / "drum.dxf").read_bytes() == b"left"


def test_a_file_that_was_renamed_or_a_design_without_a_file_goes_on(tmp_path: Path, files: tuple[Path, Path]) -> None:
    left, right = files
    target = tmp_path / "drive"
    origin_build(target, left, "left")
    refuse_other_origin(target, Path("<drive>"))
    left.unlink()
    origin_build(target, right, "renamed")
    assert (target / "report.md").read_text() == "renamed"


def test_the_record_is_relative_and_moves_with_both(tmp_path: Path, files: tuple[Path, Path]) -> None:
    left, right = files
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    left, right = left.rename(here / "left.yaml"), right.rename(here / "right.yaml")
    origin_build(here / "out" / "drive", left, "left")
    assert (here / "out" / "drive" / ORIGIN_NAME).read_text() == "../../left.yaml\n"
    here.rename(there)
    origin_build(there / "out" / "drive", there / "left.yaml", "left")
    with pytest.raises(OutputError):
        origin_build(there / "out" / "drive", there / "right.yaml", "right")


def test_a_folder_from_before_the_record_is_taken_over(tmp_path: Path, files: tuple[Path, Path]) -> None:
    target = tmp_path / "drive"
    with output_folder(target, ORIGIN_FACTS) as folder:
        folder.write("report.md", "old")
    origin_build(target, files[1], "new")
    assert (target / "report.md").read_text() == "new"
