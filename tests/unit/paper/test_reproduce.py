"""The table of the paper's figures: within tolerances for the reference, outside for a wrong design, up to date."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from mbcdm_cad import cli
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.paper.reproduce import as_markdown, reproduce

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def drive() -> Drive:
    return load_design(ROOT / "params" / "mbcdm.yaml").drive


def test_reference_is_within_every_tolerance(drive: Drive) -> None:
    out = [f"{f.name}: {f.computed:.6g} against {f.paper:g} {f.unit}" for f in reproduce(drive) if not f.within]
    assert not out, out


def test_what_is_not_judged_says_why(drive: Drive) -> None:
    for figure in reproduce(drive):
        assert figure.remark, figure.name
        if figure.tolerance is None:
            words = ("unexplained", "other reading", "needs", "not proven")
            assert any(word in figure.remark for word in words), f"{figure.name}: {figure.remark}"


@pytest.mark.parametrize(
    ("change", "figure"),
    [
        ({"cable": {"modulus_GPa": 40.0}}, "backlash, as a swing at reversal"),
        ({"cable": {"diameter_mm": 1.0}}, "radius ratio rho"),
        ({"motor": {"rated_torque_mNm": 3.5}}, "torque, theoretical"),
        ({"gearhead": {"ratio": 60.0}}, "torque, measured"),
    ],
)
def test_a_wrong_design_leaves_its_tolerance(drive: Drive, change: dict[str, dict[str, float]], figure: str) -> None:
    ((block, values),) = change.items()
    other = replace(drive, **{block: replace(getattr(drive, block), **values)})
    out = [f.name for f in reproduce(other) if not f.within]
    assert figure in out, f"{change}: out of tolerance are {out}"


def test_page_is_up_to_date(drive: Drive) -> None:
    page = ROOT / "docs" / "paper-figures.md"
    assert page.read_text() == as_markdown(reproduce(drive), drive.name), (
        f"rewrite {page} from mbcdm_cad.paper.reproduce"
    )


def test_the_command_ends_with_1_outside_a_tolerance(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (ROOT / "params" / "mbcdm.yaml").read_text("utf-8")
    assert cli.run(["reproduce"]) == 0
    (tmp_path / "soft.yaml").write_text(text.replace("modulus_GPa: 54.0", "modulus_GPa: 40.0"), "utf-8")
    assert cli.run(["reproduce", str(tmp_path / "soft.yaml")]) == 1
    assert "from the paper's 0.33 (tolerance 5.00%)" in capsys.readouterr().err
