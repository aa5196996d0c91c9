"""The command line from the user's side: exit codes, messages on stderr, never a traceback."""

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from mbcdm_cad import cli
from mbcdm_cad.layouts import loader
from mbcdm_cad.layouts.loader import load_design, new_design_text
from tests.support.reference import REFERENCE as PARAMS
from tests.support.reference import Says


def mbcdm(*arguments: str | Path, **more: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mbcdm_cad", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=600, check=False, **more)  # type: ignore[call-overload, no-any-return]


@pytest.fixture(autouse=True)
def own_cache(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> None:
    monkeypatch.setenv("MBCDM_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))


BAD_FILES = {
    "empty": b"",
    "not yaml": b"a: [\n",
    "not text": bytes(range(256)),
    "tag": b"a: !!python/object/apply:os.system [touch /tmp/pwned]\n",
    "bomb": b"\n".join([b"a0: &a0 [x, x]"] + [b"a%d: &a%d [*a%d, *a%d]" % (k, k, k - 1, k - 1) for k in range(1, 64)]),
    "deep": b"[" * 100_000,
    "wrong type": new_design_text("t").replace("34.6 ", "wide ").encode(),
    "climbing name": new_design_text("t").replace("name: t ", "name: ../../t ").encode(),
    "not a number": new_design_text("t").replace("34.6 ", ".nan ").encode(),
    "huge": b"a: " + b"9" * 100_000,
}


@pytest.mark.parametrize("command", ["check", "build", "analyse"])
@pytest.mark.parametrize("name", BAD_FILES)
def test_bad_input_ends_with_code_2_file_and_line(
    name: str, command: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "f.yaml"
    path.write_bytes(BAD_FILES[name])
    assert cli.run([command, str(path)]) == 2
    out, err = capfd.readouterr()
    assert out == "" and err.startswith(f"{path}:"), err
    assert int(err.split(":")[1]) >= 1 and "; " in err, err
    assert list(tmp_path.iterdir()) == [path]


def test_bad_input_in_a_process_of_its_own_shows_no_traceback(tmp_path: Path) -> None:
    path = tmp_path / "f.yaml"
    for content in (BAD_FILES["bomb"], BAD_FILES["deep"], BAD_FILES["not text"]):
        path.write_bytes(content)
        done = mbcdm("check", path, env={**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0"})
        assert done.returncode == 2 and "Traceback" not in done.stderr, done.stderr


def test_missing_file_and_missing_argument() -> None:
    assert mbcdm("check", "no-such.yaml").returncode == 2
    done = mbcdm("check")
    assert done.returncode == 2 and "Missing argument" in done.stderr, done.stderr
    assert mbcdm("build", PARAMS, "--angle", "wide").returncode == 2
    assert mbcdm("build", PARAMS, "--angle", "nan").returncode == 2
    assert mbcdm("nonsense").returncode == 2


def test_init_writes_a_file_that_loads_and_never_overwrites(tmp_path: Path) -> None:
    path = tmp_path / "My Drive 2.yaml"
    done = mbcdm("init", path)
    assert done.returncode == 0, done.stderr
    assert load_design(path).design.name == "my-drive-2"
    before = path.read_bytes()
    again = mbcdm("init", path)
    assert again.returncode == 2 and "exists already" in again.stderr, again.stderr
    assert path.read_bytes() == before


def test_init_into_a_missing_folder_is_told(tmp_path: Path) -> None:
    done = mbcdm("init", tmp_path / "no" / "x.yaml")
    assert done.returncode == 2 and f"there is no folder {tmp_path / 'no'}" in done.stderr, done.stderr
    assert "Traceback" not in done.stderr


def test_schema_prints_json_and_the_reference_page() -> None:
    done = mbcdm("schema")
    assert done.returncode == 0 and json.loads(done.stdout)["title"] == "Design"
    assert mbcdm("schema", "--reference").stdout.startswith("# The design file\n")


def test_a_reader_that_goes_away_is_no_error() -> None:
    command = f"{sys.executable} -m mbcdm_cad schema | head -c 10"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, timeout=600, check=False)
    assert done.stderr == "", done.stderr


@pytest.mark.parametrize(
    ("raised", "code", "words"),
    [
        (KeyboardInterrupt(), 130, "interrupted"),
        (OSError(28, "No space left on device", "x.yaml"), 2, "x.yaml: No space left on device"),
        (ZeroDivisionError("one\ntwo"), 70, r"fault of the program.*\(ZeroDivisionError: one\).* report it.* (/.*)\n$"),
    ],
)
def test_what_ends_a_command_is_told_in_one_line(
    raised: BaseException, code: int, words: str, monkeypatch: pytest.MonkeyPatch, says: Says, tmp_path: Path
) -> None:
    def ends(*_: str, **__: bool) -> str:
        raise raised

    monkeypatch.setattr(loader, "short_design_text", ends)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    told = re.search(words, says(["init", str(tmp_path / "drive.yaml")], code).err)
    assert told and not (tmp_path / "drive.yaml").exists()
    if told.groups():
        assert "Traceback" in Path(told[1]).read_text() and "init" in Path(told[1]).read_text()


def test_help_and_version() -> None:
    assert "check" in mbcdm("--help").stdout
    assert mbcdm("--version").stdout.startswith("mbcdm, version ")


@pytest.mark.parametrize("command", ["schema", "init"])
def test_commands_do_not_import_heavy_libraries(command: str, tmp_path: Path) -> None:
    arguments = [command] + ([str(tmp_path / "x.yaml")] if command == "init" else [])
    code = (
        "import sys; from mbcdm_cad import cli; cli.run(sys.argv[1:]);"
        "heavy = {'cadquery', 'OCP', 'numpy', 'scipy', 'matplotlib', 'vtk'} & set(sys.modules);"
        "print(sorted(heavy), file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, timeout=600, check=False
    )
    assert done.stderr.strip() == "[]", done.stderr
