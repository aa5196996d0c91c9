"""The reference design as data to edit, and a function that loads the edited data."""

import copy
from collections.abc import Callable
from typing import Any

import pytest
import yaml

from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.loader import load_text, reference_data

Edit = Callable[..., LoadedDesign]


@pytest.fixture
def load_edited() -> Edit:
    """``load_edited({("travel", "half_angle_deg"): 30.0, ("rope", "type"): None})``; None removes the field."""

    def load(changes: dict[tuple[str | int, ...], Any]) -> LoadedDesign:
        data = copy.deepcopy(reference_data())
        for (*parents, last), value in changes.items():
            block: Any = data
            for part in parents:
                block = block[part]
            if value is None:
                del block[last]
            else:
                block[last] = value
        return load_text(yaml.safe_dump(data, sort_keys=False), "edited.yaml")

    return load
