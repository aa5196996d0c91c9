"""FrontSearch for the best designs and write them: the front's design files, their figures, the points evaluated."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.design.template import slug
from mbcdm_cad.design.yamltree import parse
from mbcdm_cad.errors import OutputError
from mbcdm_cad.optimising.figures import refuse_unknown
from mbcdm_cad.optimising.journal import Journal, sole_search
from mbcdm_cad.optimising.page import optimum_page
from mbcdm_cad.optimising.result import Optimum, optimum_of
from mbcdm_cad.optimising.search import FrontSearch, Told
from mbcdm_cad.optimising.variables import variables_of
from mbcdm_cad.optimising.wishes import Effort, Wishes
from mbcdm_cad.solving.question import Question, question_of
from mbcdm_cad.storage.folders import output_folder
from mbcdm_cad.storage.keys import content_key, package_hash
from mbcdm_cad.storage.manifest import Manifest, versions


def optimise(
    files: Sequence[tuple[str, Path]],
    wishes: Wishes,
    out: Path,
    effort: Effort,
    told: Told,
    beside: Sequence[LoadedDesign] = (),
) -> Optimum:
    """Search over ``files``, each its text and path, and write ``out/NAME-optimum``.

    Evaluated points go into ``out/NAME-optimum.jsonl`` on the way. The front is shown ``beside`` other designs. An
    interrupted search writes what it has. Raises ``InputError`` for mistakes in a file, ``MbcdmError`` for wishes that
    the layouts cannot answer, and ``OutputError`` if files cannot be written or a search before is there and ``effort``
    does not resume it.
    """
    text, path = files[0]
    data = parse(text, str(path)).data
    name = slug(str((data.get("name") if isinstance(data, dict) else None) or path.stem))
    folder = out / f"{name}-optimum"
    journal_path = out / f"{name}-optimum.jsonl"
    request = _request(files, wishes)
    # Small systems of equations: threads of the linear algebra would only wait for each other.
    with threadpool_limits(1), sole_search(journal_path):
        # Before any file is sized, which may take long: a search that is refused is refused at once.
        with Journal(journal_path, request, resume=effort.resume) as journal:
            questions = [question_of(text, path) for text, path in files]
            refuse_unknown([*(aim.figure for aim in wishes.aims), *(keep.figure for keep in wishes.keeps)], questions)
            variables = [variables_of(question, wishes) for question in questions]
            search = FrontSearch(questions, variables, wishes, journal, told)
            searched = search.run(effort)
        found = optimum_of(questions, searched, folder, name, beside)
        _write(found, questions, request)
    return found


def _request(files: Sequence[tuple[str, Path]], wishes: Wishes) -> dict[str, Any]:
    """All that the results depend on; a search goes on only with an equal one."""
    return {
        "files": [[path.name, text] for text, path in files],
        "aims": [str(aim) for aim in wishes.aims],
        "keeps": [str(keep) for keep in wishes.keeps],
        "free": [[freed.field, list(freed.values), freed.low, freed.high] for freed in wishes.free],
        "only_free": wishes.only_free,
        "package": package_hash(),
        "versions": versions() | {"pymoo": metadata.version("pymoo")},
    }


def _write(found: Optimum, questions: Sequence[Question], request: dict[str, Any]) -> None:
    key = content_key("optimum", request, package_hash(), versions())
    try:
        with output_folder(found.folder, Manifest(key, key), design=questions[0].path) as folder:
            folder.write("optimum.json", json.dumps(found.to_dict(), indent=1, allow_nan=False) + "\n")
            folder.write("front.csv", _csv(found))
            folder.write("optimum.html", optimum_page(found))
            for point in found.points:
                folder.write(f"front/{point.name}.yaml", point.text)
    except OutputError as error:
        raise OutputError(f"{error}; the evaluated points are kept: go on with --resume") from error


def _csv(found: Optimum) -> str:
    """All figures of the front; neither names nor numbers contain a comma."""
    table = found.all_figures()
    lines = [",".join("" if cell is None else str(cell) for cell in row) for row in (table.columns, *table.rows)]
    return "\n".join(lines) + "\n"
