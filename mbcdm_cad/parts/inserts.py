"""Heat-set inserts of printed parts: texts for the order of assembly."""

from __future__ import annotations

from mbcdm_cad.design.bought import InsertSpec


def insert_items(stem: str, insert: InsertSpec | None, count: int) -> tuple[str, ...]:
    """Names of the items, none where the threads are cut."""
    return tuple(f"{stem}_{n}" for n in range(1, count + 1)) if insert else ()


def insert_words(insert: InsertSpec | None, count: int, where: str) -> str:
    """A sentence for the step in which the part joins, empty where its threads are cut."""
    if insert is None:
        return ""
    return (
        f"Before anything else, set {count} inserts {insert.name} into {where} with a hot tip of their thread's size, "
        "square to the face and flush with it or up to 0.1 mm below, and let them cool. "
    )
