"""Count what makes the code large or hard to change; tests/unit/test_house_counts.py holds tests/house_limits.json.

    python tests/house_counts.py [TREE] [--pairs] [--twice] [--circles] [--helpers]

``TREE`` is the folder of a checkout, by default this one. The options list what was counted.
"""

import argparse
import ast
import io
import keyword
import re
import tokenize
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import networkx as nx

# The order of the rooms: a room may import from those before it and from itself.
ROOMS = (
    "errors",
    "storage",
    "parallel",
    "design",
    "sizing",
    "routes",
    "model",
    "parts",
    "face",
    "checks",
    "layouts",
    "solving",
    "drawings",
    "workshop",
    "report",
    "optimising",
    "robot",
    "measurement",
    "loop",
    "rig",
    "planning",
    "paper",
    "jobs",
    "api",
    "live",
    "cli",
)
# What all rooms may know of the layouts: that there are some, and what each supplies.
FACE = (
    "layouts",
    "layouts.base",
    "layouts.life",
    "layouts.lumped",
    "layouts.sector",
    "layouts.springs",
    "layouts.structure",
    "layouts.turns",
    "layouts.registry",
)
# Ends of the names of classes that describe a whole design of one layout.
ROLES = ("Design", "Drive", "Layout", "UnderTest", "Known", "Geometry", "Figures")
# Rooms whose lines are limited one by one.
SIZED_ROOMS = ("layouts", "loop", "planning", "measurement", "report", "checks", "parts", "design", "paper")
# Pages of docs/ that a command writes.
WRITTEN_PAGES = (
    "design-file",
    "measurement-file",
    "catalogue",
    "checks",
    "gallery",
    "built-by-others",
    "real-drives",
    "optimum",
    "validation",
    "loop-effects",
    "paper-figures",
)
# A private function that is used once is counted up to this number of lines.
SHORT_LINES = 8
# Numbers in comparisons that are no thresholds: signs, counts and dimensions.
NO_THRESHOLDS = (0, 1, 2)
# Two classes hold the same fields from this number of common names on.
COMMON_FIELDS = 3
# Length of a repeated place, in tokens and in lines of code.
REPEATED_TOKENS, REPEATED_LINES = 60, 6


@dataclass(frozen=True)
class House:
    """The source of the package below ``tree``."""

    tree: Path

    @cached_property
    def files(self) -> dict[str, Path]:
        """Files by module name without ``mbcdm_cad.``, such as ``model.equations``."""
        package = self.tree / "mbcdm_cad"
        return {
            ".".join(path.relative_to(package).with_suffix("").parts).removesuffix(".__init__"): path
            for path in sorted(package.rglob("*.py"))
        }

    @cached_property
    def texts(self) -> dict[str, str]:
        """Source of each module."""
        return {module: path.read_text("utf-8") for module, path in self.files.items()}

    @cached_property
    def trees(self) -> dict[str, ast.Module]:
        """Syntax tree of each module."""
        return {module: ast.parse(text) for module, text in self.texts.items()}

    @cached_property
    def walked(self) -> dict[str, list[ast.AST]]:
        """All nodes of each module: a dozen counts look at them."""
        return {module: list(ast.walk(tree)) for module, tree in self.trees.items()}

    @cached_property
    def layouts(self) -> tuple[str, ...]:
        """Names of the layouts: packages directly below ``layouts/``, which was ``configurations/``."""
        found = (name.split(".") for name, path in self.files.items() if path.name == "__init__.py")
        return tuple(parts[1] for parts in found if len(parts) == 2 and parts[0] in ("layouts", "configurations"))

    def of_layout(self, name: str) -> list[str]:
        """Modules of one layout."""
        own = re.compile(rf"(layouts|configurations)\.{name}(\.|$)")
        return [module for module in self.files if own.match(module)]

    @cached_property
    def imports(self) -> nx.DiGraph:
        """Which module imports which at run time, also inside functions."""
        return self._graph({module: _at_run_time(tree) for module, tree in self.trees.items()})

    @cached_property
    def needs(self) -> nx.DiGraph:
        """Which module imports which, those for a type checker too: what one reads to understand a module."""
        return self._graph(self.walked)

    def _graph(self, nodes: Mapping[str, Iterable[ast.AST]]) -> nx.DiGraph:
        graph = nx.DiGraph()
        graph.add_nodes_from(self.files)
        for module in self.files:
            graph.add_edges_from((module, name) for name in self._imported(nodes[module]) if name != module)
        return graph

    def _imported(self, nodes: Iterable[ast.AST]) -> Iterator[str]:
        """Modules of the package that are imported; of ``from a import b`` that is ``a.b`` if it is a module."""
        for node in nodes:
            names: list[tuple[str, ...]] = []
            if isinstance(node, ast.ImportFrom) and node.module:
                names = [(f"{node.module}.{alias.name}", node.module) for alias in node.names]
            elif isinstance(node, ast.Import):
                names = [(alias.name,) for alias in node.names]
            for ways in names:
                own = (name.removeprefix("mbcdm_cad.") for name in ways if name.startswith("mbcdm_cad."))
                yield from [name for name in own if name in self.files][:1]


def _at_run_time(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes below ``node``, but for what only a type checker reads."""
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"):
            yield child
            yield from _at_run_time(child)


def class_families(house: House) -> int:
    """Kinds of classes that every layout has of its own to describe one whole design, and its configuration object.

    A kind is an end of a class name in ``ROLES`` that classes of at least two layouts have.
    """
    owners: dict[str, set[str]] = defaultdict(set)
    for layout in house.layouts:
        for module in house.of_layout(layout):
            for node in house.walked[module]:
                if isinstance(node, ast.ClassDef):
                    owners |= {role: owners[role] | {layout} for role in ROLES if node.name.endswith(role)}
                elif isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "CONFIGURATION":
                    owners["CONFIGURATION"].add(layout)
    return sum(len(having) > 1 for having in owners.values())


def registry_calls(house: House) -> int:
    """Calls that look a layout up by its name, ``layout_named(name)``, in the whole package."""
    return sum(
        isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "layout_named"
        for nodes in house.walked.values()
        for node in nodes
    )


def maker_strings(house: House) -> int:
    """Strings ``module:function`` that name a function of the package to be called, whole or as the end of a format."""
    return sum(
        isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and bool(re.fullmatch(r"(mbcdm_cad|)\.[\w.]+:\w+", node.value))
        for nodes in house.walked.values()
        for node in nodes
    )


def twice_declared(house: House) -> list[tuple[str, str, int]]:
    """Pairs of a class that is read and one that is used, with the number of fields that both declare.

    The first is validated: its bases lead to pydantic's ``BaseModel`` or to ``PlainBlock``. Each class that is used is
    counted with the one that shares most field names: at least three and half of its own.
    """
    fields: dict[str, set[str]] = {}
    bases: dict[str, list[str]] = {}
    for module, nodes in house.walked.items():
        if module.partition(".")[0] in ("design", "layouts", "configurations", "parts"):
            for node in nodes:
                if isinstance(node, ast.ClassDef):
                    name = f"{module}.{node.name}"
                    bases[name] = [ast.unparse(base).partition("[")[0].rpartition(".")[2] for base in node.bases]
                    fields[name] = {
                        line.target.id
                        for line in node.body
                        if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name)
                    }
    read = {name for name in bases if {"BaseModel", "PlainBlock"} & {*bases[name], name.rpartition(".")[2]}}
    while more := {n for n in bases if n not in read and set(bases[n]) & {r.rpartition(".")[2] for r in read}}:
        read |= more
    found = []
    for used in sorted(set(fields) - read):
        common, name = max((len(fields[used] & fields[one]), one) for one in sorted(read))
        if common >= max(COMMON_FIELDS, len(fields[used]) / 2):
            found.append((name, used, common))
    return found


def fields_twice(house: House) -> int:
    """Fields that two classes declare, see :func:`twice_declared`."""
    return sum(common for _, _, common in twice_declared(house))


def files_of_layouts(house: House) -> dict[str, int]:
    """Python files in the folder of each layout."""
    return {name: len(house.of_layout(name)) for name in house.layouts}


def files(house: House) -> int:
    """Python files of the package."""
    return len(house.files)


def lines(house: House) -> int:
    """Lines of the package's Python files, empty ones too."""
    return sum(text.count("\n") for text in house.texts.values())


def import_share(house: House) -> float:
    """Lines of import statements, those for a type checker too, as a share of all lines."""
    imports = sum(
        (node.end_lineno or node.lineno) - node.lineno + 1
        for nodes in house.walked.values()
        for node in nodes
        if isinstance(node, ast.Import | ast.ImportFrom)
    )
    return imports / lines(house)


def circle_members(house: House) -> list[list[str]]:
    """Groups of modules that import each other in a circle: at the top, inside functions, or for a type checker."""
    return sorted(sorted(group) for group in nx.strongly_connected_components(house.needs) if len(group) > 1)


def circles(house: House) -> int:
    """Number of groups of modules that import each other, see :func:`circle_members`."""
    return len(circle_members(house))


def room(module: str) -> str:
    """The room of a module."""
    return "face" if module in FACE else module.partition(".")[0]


def back_arrows(house: House) -> list[tuple[str, str]]:
    """Imports of a room that comes later in ``ROOMS``: (module, imported module)."""
    place = {name: k for k, name in enumerate(ROOMS)}
    return [
        (module, other)
        for module, other in house.imports.edges
        if place.get(room(module), len(ROOMS)) < place.get(room(other), -1)
    ]


def arrows_back(house: House) -> int:
    """Number of pairs (module, room) against the order of the rooms."""
    return len({(module, room(other)) for module, other in back_arrows(house)})


def _code_tokens(text: str, nodes: list[ast.AST]) -> Iterator[tuple[str, int]]:
    """Tokens of the code with their lines; names, numbers and strings as placeholders.

    Imports, docstrings and comments are left out. A path, ``at.drum.bearing``, is one value as its string would be.
    """
    text = re.sub(r"\bat\.\w+\.\w+", '""', text)
    left_out: set[int] = set()
    for node in nodes:
        docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if docstring or isinstance(node, ast.Import | ast.ImportFrom):
            left_out |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    layout = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in layout or token.start[0] in left_out:
            continue
        if token.type == tokenize.NAME and not keyword.iskeyword(token.string):
            yield "name", token.start[0]
        elif token.type in (tokenize.NUMBER, tokenize.STRING):
            yield "value", token.start[0]
        else:
            yield token.string, token.start[0]


def repeats(house: House) -> list[tuple[str, int, str, int, int]]:
    """Pairs of places with the same code but for names and values: (module, line, module, line, length in tokens).

    A place is at least 60 tokens over at least 6 lines. Each is as long as it can be. Of three places that are alike
    the first is paired with the second and the second with the third.
    """
    tokens = {module: list(_code_tokens(text, house.walked[module])) for module, text in house.texts.items()}
    last: dict[int, tuple[str, int]] = {}
    pairs: dict[tuple[str, str, int], list[int]] = defaultdict(list)
    for module, found in tokens.items():
        words = [hash(word) for word, _ in found]
        for k in range(len(words) - REPEATED_TOKENS + 1):
            key = hash(tuple(words[k : k + REPEATED_TOKENS]))
            if key in last:
                other, j = last[key]
                if other != module or k - j >= REPEATED_TOKENS:
                    pairs[other, module, k - j].append(k)
            last[key] = module, k
    places = []
    for (other, module, shift), starts in pairs.items():
        begin = end = starts[0]
        for k in (*starts[1:], None):
            if k is not None and k <= end + REPEATED_TOKENS:
                end = k
                continue
            first, after = tokens[module][begin][1], tokens[module][end + REPEATED_TOKENS - 1][1]
            if after - first + 1 >= REPEATED_LINES:
                length = end - begin + REPEATED_TOKENS
                places.append((other, tokens[other][begin - shift][1], module, first, length))
            if k is not None:
                begin = end = k
    return sorted(places, key=lambda pair: -pair[-1])


def repeating_pairs(house: House) -> int:
    """Number of pairs of places that repeat each other, see :func:`repeats`."""
    return len(repeats(house))


def tests_lines(house: House) -> int:
    """Lines of all Python files below tests/."""
    return sum(path.read_text("utf-8").count("\n") for path in (house.tree / "tests").rglob("*.py"))


def docs_lines_by_hand(house: House) -> int:
    """Lines of the Markdown pages of docs/ but for those that a command writes, ``WRITTEN_PAGES``."""
    pages = (path for path in (house.tree / "docs").rglob("*.md") if path.stem not in WRITTEN_PAGES)
    return sum(page.read_text("utf-8").count("\n") for page in pages)


def decisions(house: House) -> int:
    """Pages of docs/decisions."""
    return len(list((house.tree / "docs" / "decisions").glob("[0-9]*.md")))


def short_helpers(house: House) -> list[tuple[str, str]]:
    """Private functions of at most ``SHORT_LINES`` lines whose name stands at one other place: (module, name)."""
    uses: Counter[str] = Counter()
    for nodes in house.walked.values():
        for node in nodes:
            if isinstance(node, ast.Name):
                uses[node.id] += 1
            elif isinstance(node, ast.Attribute):
                uses[node.attr] += 1
    return [
        (module, node.name)
        for module, nodes in house.walked.items()
        for node in nodes
        if isinstance(node, ast.FunctionDef)
        and re.match("_[^_]", node.name)
        and uses[node.name] == 1
        and (node.end_lineno or 0) - node.lineno < SHORT_LINES
    ]


def field_path_strings(house: House) -> int:
    """Strings that are a path of the design file, such as ``"drum.hub_diameter_mm"``.

    The first part is a block of a file of params/ (top level of a design file, with an indented line below it).
    """
    texts = (path.read_text("utf-8") for path in (house.tree / "params").rglob("*.yaml"))
    blocks = {name for text in texts for name in re.findall(r"^([a-z_]+):\s*(?:#.*)?\n[ #]", text, re.MULTILINE)}
    return sum(
        isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and bool(found := re.fullmatch(r"([a-z_]+)(\.\w+)+", node.value))
        and found[1] in blocks
        for nodes in house.walked.values()
        for node in nodes
    )


def _numbers(node: ast.AST) -> list[float]:
    inside = (one.value for one in ast.walk(node) if isinstance(one, ast.Constant))
    return [value for value in inside if isinstance(value, int | float) and not isinstance(value, bool)]


def search_thresholds(house: House) -> int:
    """Numbers by which loop/search decides: its module constants that hold one, and those written in comparisons."""
    found = 0
    for module, tree in house.trees.items():
        if module.startswith("loop.search"):
            constants = (node for node in tree.body if isinstance(node, ast.Assign | ast.AnnAssign))
            found += sum(bool(node.value and _numbers(node.value)) for node in constants)
            compared = (node for node in ast.walk(tree) if isinstance(node, ast.Compare))
            found += sum(value not in NO_THRESHOLDS for node in compared for value in _numbers(node))
    return found


def room_lines(house: House) -> dict[str, int]:
    """Lines of each room of ``SIZED_ROOMS``."""
    sums = Counter(dict.fromkeys(SIZED_ROOMS, 0))
    for module, text in house.texts.items():
        sums[module.partition(".")[0]] += text.count("\n")
    return {name: sums[name] for name in SIZED_ROOMS}


def counts(house: House) -> dict[str, float]:
    """All counts by name."""
    per_layout = {f"files of {name}": float(count) for name, count in files_of_layouts(house).items()}
    return {
        "class families a layout": class_families(house),
        "registry calls": registry_calls(house),
        "maker strings": maker_strings(house),
        "fields declared twice": fields_twice(house),
        **per_layout,
        "files": files(house),
        "imports, share of lines in %": round(100.0 * import_share(house), 2),
        "circles": circles(house),
        "arrows back": arrows_back(house),
        "repeating pairs": repeating_pairs(house),
        "lines": lines(house),
        "tests lines": tests_lines(house),
        "docs lines by hand": docs_lines_by_hand(house),
        "decisions": decisions(house),
        "private functions used once, at most 8 lines": len(short_helpers(house)),
        "field paths as string literals": field_path_strings(house),
        "thresholds in loop/search": search_thresholds(house),
        **{f"lines of {name}": count for name, count in room_lines(house).items()},
    }


def main() -> None:
    """Print the counts, and on request what was counted."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tree", type=Path, nargs="?", default=Path(__file__).parents[1])
    parser.add_argument("--pairs", action="store_true", help="places that repeat each other")
    parser.add_argument("--twice", action="store_true", help="classes that declare the same fields")
    parser.add_argument("--circles", action="store_true", help="modules in circles, and arrows back")
    parser.add_argument("--helpers", action="store_true", help="short private functions that are used once")
    given = parser.parse_args()
    house = House(given.tree)
    for name, count in counts(house).items():
        print(f"{name:46} {count:>8g}")
    if given.twice:
        print(*(f"{common:3d}  {read}  {used}" for read, used, common in twice_declared(house)), sep="\n")
    if given.circles:
        print(*(" <-> ".join(group) for group in circle_members(house)), sep="\n")
        print(*(f"{module} -> {other}" for module, other in back_arrows(house)), sep="\n")
    if given.helpers:
        print(*(f"{module}:{name}" for module, name in short_helpers(house)), sep="\n")
    if given.pairs:
        print(*(f"{size:5d}  {a}:{i}  {b}:{j}" for a, i, b, j, size in repeats(house)), sep="\n")


if __name__ == "__main__":
    main()
