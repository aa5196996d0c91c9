"""Every single value of the reference's design file, and another one for each."""

from collections.abc import Iterator
from typing import Any

Path = tuple[str | int, ...]
# The kind of a catalogue entry by the field that names one.
KIND_OF = {
    "material": "materials",
    "shaft_material": "materials",
    "axle_material": "materials",
    "bearing": "bearings",
    "lower_bearing": "bearings",
    "upper_bearing": "bearings",
    "tensioner": "tensioners",
    "motor": "motors",
    "gearhead": "gearheads",
    "encoder": "encoders",
    "drum_encoder": "encoders",
    "type": "ropes",
}


def leaves(data: Any, path: Path = ()) -> Iterator[Path]:
    """Paths of all single values; a list of numbers counts as one."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield from leaves(value, (*path, key))
    elif isinstance(data, list) and data and isinstance(data[0], dict):
        for index, value in enumerate(data):
            yield from leaves(value, (*path, index))
    else:
        yield path
