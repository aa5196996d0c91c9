"""The graph of dependencies between the fields of a design file, arranged in columns, as SVG.

Layers and positions come from networkx; within a column fields are ordered by the mean place of their neighbours
(Sugiyama's barycentre sweeps), so that few lines cross. The same records give the same bytes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import jinja2
import networkx as nx

from mbcdm_cad.design.describe import flow

# Sweeps over all columns in both directions; more change nothing for designs of some sixty fields.
_SWEEPS = 24
_BOX_PX = (208.0, 34.0)
_COLUMN_PX, _ROW_PX, _PASSING_PX, _EDGE_PX = 246.0, 42.0, 12.0, 12.0
_LONGEST = 24

# A field, or a line on its way through a column: (from, to, column).
_Place = str | tuple[str, str, int]


@dataclass(frozen=True)
class DependencyNode:
    """A field in the graph: box with its left upper corner in px, and its texts.

    ``kind``: "asked" has no rule (requirement, choice), "follows" was filled by its rule, "stated" is given in the file
    although a rule would fill it.
    """

    field: str
    value: str
    kind: str
    reason: str
    x: float
    y: float


@dataclass(frozen=True)
class DependencyLine:
    """A line from a field to one that depends on it: its points in px, from left to right."""

    source: str
    target: str
    points: tuple[tuple[float, float], ...]

    @property
    def path(self) -> str:
        """The line as the ``d`` of an SVG path, horizontal at its ends and in each column between."""
        start = self.points[0]
        steps = [f"M{start[0]:.1f} {start[1]:.1f}"]
        for (x0, y0), (x1, y1) in pairwise(self.points):
            middle = (x0 + x1) / 2
            steps.append(f"C{middle:.1f} {y0:.1f} {middle:.1f} {y1:.1f} {x1:.1f} {y1:.1f}")
        return "".join(steps)


@dataclass(frozen=True)
class DependencyGraph:
    """Fields and lines on a drawing of ``size_px``; fields in ``alone`` have no dependencies in either direction."""

    nodes: tuple[DependencyNode, ...]
    lines: tuple[DependencyLine, ...]
    alone: tuple[str, ...]
    size_px: tuple[float, float]


def dependency_graph(fields: Sequence[Mapping[str, Any]]) -> DependencyGraph:
    """The graph of the records of all fields (:meth:`mbcdm_cad.report.explain.Explained.to_dict`).

    A dependency that a longer path already shows has no line of its own. If the rules of two stated fields depend on
    each other, the first of them in the list comes first.
    """
    records = {record["field"]: record for record in fields}
    asked = {name: value for record in fields for name, value in record["rests_on"].items() if name not in records}
    rests = nx.DiGraph()
    for record in fields:
        rests.add_node(record["field"])
        for source in record["rests_on"]:
            if not (rests.has_node(source) and nx.has_path(rests, record["field"], source)):  # no cycles
                rests.add_edge(source, record["field"])
    alone = tuple(sorted(nx.isolates(rests)))
    rests.remove_nodes_from(alone)
    if not rests:
        return DependencyGraph((), (), alone, (0.0, 0.0))
    direct = nx.DiGraph()
    direct.add_edges_from(sorted(nx.transitive_reduction(rests).edges))
    places, column = _columns(direct)
    at = _positions(_ordered(places, column))
    nodes = [_node(name, records.get(name), asked.get(name), at[name]) for name in sorted(direct)]
    lines = [_line(a, b, column, at) for a, b in direct.edges]
    width = max(node.x for node in nodes) + _BOX_PX[0] + _EDGE_PX
    height = max(y for _, y in at.values()) + _BOX_PX[1] / 2 + _EDGE_PX
    return DependencyGraph(tuple(nodes), tuple(lines), alone, (width, height))


def dependency_svg(graph: DependencyGraph, title: str) -> str:
    """The graph as SVG text, for a file or inside a page; in a page it uses the page's colours (CSS variables)."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mbcdm_cad.report", "."), undefined=jinja2.StrictUndefined, autoescape=True
    )
    return environment.get_template("dependencies.svg.j2").render(graph=graph, title=title, box=_BOX_PX) + "\n"


def _columns(direct: nx.DiGraph) -> tuple[nx.DiGraph, dict[_Place, int]]:
    """Column of each field, as far right as its dependents allow; long lines get a place in each column between."""
    column: dict[_Place, int] = {}
    for k, generation in enumerate(nx.topological_generations(direct)):
        column |= dict.fromkeys(generation, k)
    for name in reversed(list(nx.topological_sort(direct))):
        column[name] = min((column[after] for after in direct.successors(name)), default=column[name] + 1) - 1
    first = min(column.values())
    column = {name: k - first for name, k in column.items()}
    places = nx.DiGraph()
    for a, b in direct.edges:
        passed = [(a, b, k) for k in range(column[a] + 1, column[b])]
        column |= {place: place[2] for place in passed}
        nx.add_path(places, [a, *passed, b])
    return places, column


def _ordered(places: nx.DiGraph, column: Mapping[_Place, int]) -> list[list[_Place]]:
    """The places column by column, in the order with the fewest crossings of all sweeps."""
    columns: list[list[_Place]] = [[] for _ in range(max(column.values()) + 1)]
    for place in places:
        columns[column[place]].append(place)
    best, fewest = columns, _crossings(columns, places)
    for sweep in range(_SWEEPS):
        rightward = sweep % 2 == 0
        neighbours = places.predecessors if rightward else places.successors
        order = range(1, len(columns)) if rightward else range(len(columns) - 2, -1, -1)
        columns = [list(entries) for entries in columns]
        for k in order:
            beside = {place: i for i, place in enumerate(columns[k - 1 if rightward else k + 1])}
            mean = {
                place: sum(beside[n] for n in near) / len(near) if (near := list(neighbours(place))) else float(i)
                for i, place in enumerate(columns[k])
            }
            columns[k].sort(key=mean.__getitem__)
        crossings = _crossings(columns, places)
        if crossings < fewest:
            best, fewest = columns, crossings
    return best


def _crossings(columns: Sequence[Sequence[_Place]], places: nx.DiGraph) -> int:
    found = 0
    for left, right in pairwise(columns):
        rank = {place: i for i, place in enumerate(right)}
        ends = [rank[after] for place in left for after in sorted(places.successors(place), key=rank.__getitem__)]
        found += sum(ends[i] > end for j, end in enumerate(ends) for i in range(j))
    return found


def _positions(columns: Sequence[Sequence[_Place]]) -> dict[_Place, tuple[float, float]]:
    """Left edge and middle of every place in px; columns are centred on each other."""
    at: dict[_Place, tuple[float, float]] = {}
    heights = [sum(_height(place) for place in entries) for entries in columns]
    for k, (entries, height) in enumerate(zip(columns, heights, strict=True)):
        top = _EDGE_PX + (max(heights) - height) / 2
        for place in entries:
            at[place] = (_EDGE_PX + k * _COLUMN_PX, top + _height(place) / 2)
            top += _height(place)
    return at


def _height(place: _Place) -> float:
    return _ROW_PX if isinstance(place, str) else _PASSING_PX


def _node(field: str, record: Mapping[str, Any] | None, asked: Any, at: tuple[float, float]) -> DependencyNode:
    x, y = at[0], at[1] - _BOX_PX[1] / 2
    if record is None:
        return DependencyNode(field, _short(asked), "asked", "requirement or choice", x, y)
    kind = "stated" if record["given"] else "follows"
    return DependencyNode(field, _short(record["value"]), kind, f"{record['driver']}: {record['rule']}", x, y)


def _line(a: str, b: str, column: Mapping[_Place, int], at: Mapping[_Place, tuple[float, float]]) -> DependencyLine:
    passed = [at[a, b, k] for k in range(column[a] + 1, column[b])]
    through = [point for x, y in passed for point in ((x, y), (x + _BOX_PX[0], y))]
    (x0, y0), (x1, y1) = at[a], at[b]
    return DependencyLine(a, b, ((x0 + _BOX_PX[0], y0), *through, (x1, y1)))


def _short(value: Any) -> str:
    text = flow(value)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"
