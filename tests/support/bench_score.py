"""Compare a result file of the loop with the truth of its run.

A truth is a list of entries as in the rig's truth files: ``name``, ``in_vocabulary``, ``parameters``, where it has them
``stage`` and ``cables`` (none: all of them), and ``changes`` for an effect that begins in mid-run.
"""

from math import tau
from typing import Any

from scipy.stats import beta

# Outcomes from best to worst. For runs without an effect "none" is right, for causes outside the vocabulary "unknown".
OUTCOMES = ("exact", "set", "partial", "none", "unknown", "not_testable", "wrong set", "wrong", "error")
Entry = dict[str, Any]
# What a change may be taken for: to second order only the product of friction and preload counts.
ALIKE = {"cable_friction": "preload_error", "preload_error": "cable_friction"}
# Effects that are told apart by the stage they sit on.
STAGED = ("once_per_rev", "twice_per_rev", "lash")


def label(one: Entry) -> str:
    """Short name with stage and cables, as in the tables."""
    cables = [str(cable).removeprefix("cable_") for cable in one.get("cables") or ()]
    words = ["change" if one.get("changes") else "", str(one["name"]), one.get("stage") or ""]
    return " ".join(filter(None, [*words, "cable " + ",".join(cables) if 0 < len(cables) < 4 else ""]))


def said_of(result: dict[str, Any]) -> str:
    """One line: names, sets in braces, or the verdict."""
    names = sorted(label(e) for e in result["effects"])
    names += sorted("{" + " or ".join(sorted(label(e) for e in one)) + "}" for one in result["one_of"])
    if result["verdict"] == "partly_explained" or (names and result["verdict"] == "unknown"):
        names.append("(+ unknown)")
    return " + ".join(names) if names else str(result["verdict"])


def same(said: Entry, true: Entry) -> bool:
    """True when a name the loop gave is the effect. An eccentric pulley and an encoder of one stage share a name."""
    if true.get("changes"):
        return said["name"] == "change" and said.get("stage") in (true["name"], ALIKE.get(true["name"]))
    if said["name"] != true["name"]:
        return False
    if said["name"] == "preload_error":
        numbers = [sorted(one.get("cables") or ()) for one in (said, true)]
        return numbers[0] == numbers[1] or all(len(some) in (0, 4) for some in numbers)
    # Play at the output has no stage of its own in the vocabulary, the one input of a drive has no name.
    stages = (said.get("stage"), true.get("stage"))
    return said["name"] not in STAGED or stages[0] == stages[1] or stages[0] in (None, "input") or stages[1] is None


def outcome_of(result: dict[str, Any], truth: list[Entry], small: list[Entry] | None = None) -> str:
    """The outcome of a run with the effects that the vocabulary has; see OUTCOMES. ``small`` ones may be left out."""
    left = [entry for entry in truth if entry["in_vocabulary"]]
    groups = [[said] for said in result["effects"]] + list(result["one_of"])
    for members in groups:
        hit = next((entry for entry in left if any(same(said, entry) for said in members)), None)
        if hit is None:
            return "wrong" if len(members) == 1 else "wrong set"
        left.remove(hit)
    if groups and all(entry in (small or ()) for entry in left):
        return "set" if result["one_of"] else "exact"
    if groups:
        return "partial"
    return {"none": "none", "not_testable": "not_testable"}.get(str(result["verdict"]), "unknown")


def score_of(result: dict[str, Any], truth: list[Entry], small: list[Entry]) -> str:
    """right, set (that holds the truth), missed, false, or unseen: all that is true is too small to be named."""
    outcome = outcome_of(result, truth, small)
    if outcome.startswith("wrong"):
        return "false"
    seen = [entry for entry in truth if entry not in small]
    if outcome in ("none", "not_testable"):
        return "right" if not truth else "missed" if seen else "unseen"
    if not all(entry["in_vocabulary"] for entry in seen):
        return "right" if outcome != "partial" and result["unknown"] is not None else "missed"
    return {"exact": "right", "set": "set"}.get(outcome, "missed")


def values_of(result: dict[str, Any], truth: list[Entry]) -> list[tuple[str, float, float, float, float]]:
    """What, true, found, ends of the 95 % interval: of effects named outright, where the truth has the figure."""
    found = []
    for entry in truth:
        said = next((e for e in result["effects"] if e["name"] == entry["name"] and same(e, entry)), None)
        for key, true in entry["parameters"].items():
            # The error of an input's encoder is found at the drum.
            at_input = key == "amplitude_rad" and str(entry.get("stage")).startswith("input")
            figure = None if said is None or at_input else said["parameters"].get(key)
            if figure is not None and None not in figure["ci95"]:
                # A phase is the same after a whole turn.
                turns = round((figure["value"] - true) / tau) if key.startswith("phase") else 0
                found.append((f"{label(entry)}.{key}", true + turns * tau, figure["value"], *figure["ci95"]))
    return found


def odds_of(result: dict[str, Any], truth: list[Entry]) -> list[tuple[float, bool]]:
    """Probabilities that the result states of its names, and whether each is true."""
    return [
        (float(said["probability"]), any(same(said, entry) for entry in truth))
        for said in [*result["effects"], *(one for group in result["one_of"] for one in group)]
        if "probability" in said
    ]


def interval(right: int, of: int) -> tuple[float, float]:
    """95 % interval of a share (Clopper and Pearson)."""
    low = float(beta.ppf(0.025, right, of - right + 1)) if right else 0.0
    return low, float(beta.ppf(0.975, right + 1, of - right)) if right < of else 1.0


def share(right: int, of: int) -> str:
    """A share with its interval, as a cell."""
    if not of:
        return "-"
    low, high = interval(right, of)
    return f"{right / of:.0%} ({low:.0%} to {high:.0%})"
