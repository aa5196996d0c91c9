"""The reference design from its requirements and pins is the same as the one with all values stated."""

from __future__ import annotations

from pathlib import Path

from mbcdm_cad.design.fieldpath import leaves
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.solving.question import question_of

PARAMS = Path(__file__).parents[4] / "params"


def test_tables_and_pins_give_the_whole_reference_design() -> None:
    short, whole = load_design(PARAMS / "mbcdm-short.yaml"), load_design(PARAMS / "mbcdm.yaml")
    assert short.drive == whole.drive
    # The digest of the design and all that is made from it: the same files byte for byte.
    assert short.sha256 == whole.sha256
    assert not whole.sized and len(short.sized) > 40, len(short.sized)


def test_one_dimension_is_held_by_hand() -> None:
    question = question_of((PARAMS / "mbcdm-short.yaml").read_text("utf-8"))
    assert list(question.releases) == ["support.back_y_mm"]
    assert len(list(leaves(question.data))) <= 20
