"""After a loop that ended with a set: the run that ``--next`` proposes is made on the rig, and the loop decides."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from mbcdm_cad.cli import run as mbcdm

ROOT = Path(__file__).resolve().parents[2]
DESIGN = str(ROOT / "params" / "mbcdm.yaml")


def command(capsys: pytest.CaptureFixture[str], *words: str | Path) -> str:
    code = mbcdm([str(word) for word in words])
    shown = capsys.readouterr()
    assert code == 0, shown.err
    return shown.out


def names(result: Path) -> tuple[list[str], list[set[str]]]:
    content = yaml.safe_load(result.read_text())

    def label(one: dict[str, str]) -> str:
        return " ".join(filter(None, [one["name"], one.get("stage")]))

    return [label(one) for one in content["effects"]], [{label(one) for one in group} for group in content["one_of"]]


@pytest.mark.slow
def test_the_proposed_run_settles_the_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    truth = ROOT / "params" / "experiments" / "eccentric-guide-short.yaml"
    command(capsys, "simulate", DESIGN, truth, "--out", tmp_path / "short")
    run = next((tmp_path / "short").rglob("eccentric-guide-short.yaml"))
    said = command(capsys, "loop", DESIGN, run, "--json", tmp_path / "first.json", "--next", tmp_path / "next.yaml")
    named, sets = names(tmp_path / "first.json")
    assert not named and sets and "once_per_rev guide" in sets[0], said
    assert "expected odds" in said and str(tmp_path / "next.yaml") in said, said
    experiment = yaml.safe_load((tmp_path / "next.yaml").read_text())
    experiment["effects"] = yaml.safe_load(truth.read_text())["effects"]
    (tmp_path / "made.yaml").write_text(yaml.safe_dump(experiment))
    command(capsys, "simulate", DESIGN, tmp_path / "made.yaml", "--out", tmp_path / "made")
    made = next((tmp_path / "made").rglob("next-run.yaml"))
    said = command(
        capsys, "loop", DESIGN, run, made, "--json", tmp_path / "second.json", "--next", tmp_path / "none.yaml"
    )
    assert names(tmp_path / "second.json") == (["once_per_rev guide"], []), said
    assert "no set of possible effects is left" in said and not (tmp_path / "none.yaml").exists(), said
