"""The reference design, its parts and its mechanism, drawn once for the tests of the robot files."""

from typing import Any

import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.robot.mechanism import Mechanism, mechanism
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.workshop.store import drawn
from tests.support.reference import REFERENCE


@pytest.fixture(scope="package")
def loaded() -> Any:
    return load_design(REFERENCE)


@pytest.fixture(scope="package")
def parts(loaded: Any) -> Any:
    return drawn(loaded.drive, 0.0, Cache(cache_folder()), lambda name: None)[1]


@pytest.fixture(scope="package")
def robot(loaded: Any, parts: Any) -> Mechanism:
    return mechanism(loaded.drive, {name: part.files for name, part in parts.items()})
