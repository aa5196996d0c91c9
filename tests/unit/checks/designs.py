"""The reference drive, and functions that change one value of it."""

import copy
import math
import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from typing import Any

import yaml

from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import design_file, load_text, new_design_text, reference_data

Change = Callable[[Drive, float], Drive]


@cache
def reference() -> Drive:
    """The drive of the reference design."""
    return load_text(new_design_text("reference")).drive


def put(drive: Drive, path: str, value: Any) -> Drive:
    """The drive with the attribute at a dotted ``path`` replaced."""

    def inside(block: Any, names: list[str]) -> Any:
        first, *rest = names
        return replace(block, **{first: inside(getattr(block, first), rest) if rest else value})

    changed: Drive = inside(drive, path.split("."))
    return changed


def to(path: str) -> Change:
    """Setting the attribute at a dotted path."""
    return lambda drive, value: put(drive, path, value)


def with_cable(drive: Drive, index: int, **changes: float) -> Drive:
    """The drive with fields of one cable replaced."""
    cables = list(drive.cables)
    cables[index] = replace(cables[index], **changes)  # type: ignore[arg-type]
    return replace(drive, cables=tuple(cables))


def radius_of(index: int, field: str) -> Change:
    """Setting one radius of one cable."""
    return lambda drive, value: with_cable(drive, index, **{field: value})


def _scaled(field: str, which: tuple[int, ...], drive: Drive, factor: float) -> Drive:
    for k in which:
        drive = with_cable(drive, k, **{field: getattr(drive.cables[k], field) * factor})
    return drive


def scaled(field: str, which: tuple[int, ...] = (0, 1, 2, 3)) -> Change:
    """Scaling a field of some cables."""
    return partial(_scaled, field, which)


def preloaded(drive: Drive, value: float) -> Drive:
    """All preloads at one value."""
    return replace(drive, cables=tuple(replace(c, preload_N=value) for c in drive.cables))


def with_screw(name: str, **factors: float) -> Change:
    """Scaling the fields of one screw of the catalogue by ``value``."""

    def change(drive: Drive, value: float) -> Drive:
        screws = tuple(
            replace(s, **{field: getattr(s, field) * value**power for field, power in factors.items()})  # type: ignore[arg-type]
            if s.name == name
            else s
            for s in drive.screws
        )
        return replace(drive, screws=screws)

    return change


Path = tuple[str | int, ...]
NODES = design_file().nodes
NAMES = {
    ("rope", "type"): "ropes",
    ("drive", "motor"): "motors",
    ("drive", "gearhead"): "gearheads",
    ("drive", "encoder"): "encoders",
    ("drive", "drum_encoder"): "encoders",
    ("drum", "material"): "materials",
    ("drum", "shaft_material"): "materials",
    ("drum", "bearing"): "bearings",
    ("drum", "tensioner"): "tensioners",
    ("guide", "material"): "materials",
    ("guide", "axle_material"): "materials",
    ("guide", "bearing"): "bearings",
    ("input_pulleys", "material"): "materials",
    ("input_pulleys", "lower_bearing"): "bearings",
    ("input_pulleys", "upper_bearing"): "bearings",
    ("support", "material"): "materials",
}


def numbers() -> dict[Path, tuple[float, float]]:
    """Every number of the reference design with the bounds that the schema sets."""
    found: dict[Path, tuple[float, float]] = {}

    def walk(node: dict[str, Any], data: Any, path: Path) -> None:
        node = NODES.solid(node)
        if isinstance(data, dict):
            for key, value in data.items():
                if key in node.get("properties", {}):
                    walk(node["properties"][key], value, (*path, key))
        elif isinstance(data, list):
            for k, value in enumerate(data):
                inner = node.get("items") or (node.get("prefixItems") or [{}] * len(data))[k]
                walk(inner, value, (*path, k))
        elif isinstance(data, float):
            low = node.get("minimum", node.get("exclusiveMinimum"))
            high = node.get("maximum", node.get("exclusiveMaximum"))
            if low is not None and high is not None:
                found[path] = (float(low), float(high))

    walk(NODES.root, reference_data(), ())
    return found


def _put(data: dict[str, Any], path: Path, value: Any) -> None:
    block: Any = data
    for part in path[:-1]:
        block = block[part]
    block[path[-1]] = value


def _get(data: dict[str, Any], path: Path) -> Any:
    block: Any = data
    for part in path:
        block = block[part]
    return block


def value_within(rng: random.Random, now: float, low: float, high: float) -> float:
    """Near the present value, at a bound, or anywhere between, small values as likely as large ones."""
    kind = rng.random()
    if kind < 0.5:
        return min(max(now * math.exp(rng.gauss(0.0, 0.4)), low), high)
    if kind < 0.65:
        return rng.choice((low + 1e-9 * (high - low), high))
    if low > 0.0:
        return math.exp(rng.uniform(math.log(low), math.log(high)))
    return rng.uniform(low, high)


def random_data(rng: random.Random, changes: int) -> dict[str, Any]:
    """The reference design's data with up to ``changes`` fields drawn anew."""
    data = copy.deepcopy(reference_data())
    bounds = numbers()
    for path in rng.sample(sorted(bounds, key=str), rng.randint(1, changes)):
        _put(data, path, value_within(rng, float(_get(data, path)), *bounds[path]))
    for path, kind in NAMES.items():
        if rng.random() < 0.1:
            _put(data, path, rng.choice(sorted(package_entries(kind))))
    if rng.random() < 0.2:
        radii = sorted(rng.uniform(1.0, 40.0) for _ in range(4))
        data["transmission"].pop("ratios")
        data["transmission"]["guide_radii_mm"] = radii
        data["transmission"]["input_radii_mm"] = [rng.uniform(0.6, 30.0) for _ in range(4)]
    data["transmission"]["drum_radii_mm"].sort()
    if rng.random() < 0.3:
        for cable in data["cables"]:
            cable["preload_N"] = math.exp(rng.uniform(math.log(0.1), math.log(2e4)))
    return data


def loaded(data: dict[str, Any]) -> Drive | None:
    """The design's drive, or None where rules between fields refuse it."""
    try:
        return load_text(yaml.safe_dump(data), "random.yaml").drive
    except InputError:
        return None


def random_drives(seed: int, count: int, changes: int) -> Iterator[tuple[dict[str, Any], Drive]]:
    """``count`` designs that load, with their data."""
    rng = random.Random(seed)
    found = 0
    while found < count:
        data = random_data(rng, changes)
        drive = loaded(data)
        if drive is not None:
            found += 1
            yield data, drive
