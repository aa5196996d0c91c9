# Two commands do all the set-up: `make build` (the main job) and `make test`.
PYTHON ?= python3.11
VENV   := .venv
BIN    := $(VENV)/bin
DESIGN ?= params/mbcdm.yaml

.PHONY: build test test-slow judge solids lint setup picture docs gallery built-by-others docs-site benchmark lock clean

build: setup
	$(BIN)/mbcdm build $(DESIGN)
	$(BIN)/mbcdm page $(DESIGN)

# Each worker computes on its own core: threads of the matrix library under them only wait for each other.
test test-slow judge: export OPENBLAS_NUM_THREADS = 1
# A file's tests share its fixtures, so they stay on one worker; tests/conftest.py has the order of the files.
PYTEST := $(BIN)/pytest -q -n auto --dist loadfile --no-loadscope-reorder

test: setup
	$(PYTEST) -m "not slow"

test-slow: setup
	$(PYTEST) -m slow

# Runs with known truth: fails where a class of them is worse than benchmarks/judge.jsonl says. ALL=--all: not a part.
judge: setup
	$(BIN)/python -m benchmarks.judge --check --workers 2 $(ALL)

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# Solid finite elements, which only tests use: gmsh is under the GPL.
solids: setup
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes -r tests/requirements-solids.lock

setup: $(VENV)/.ready

$(VENV)/.ready: requirements.lock pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	$(BIN)/python -m compileall -q mbcdm_cad
	@touch $@

# The picture at the top of the README.
picture: setup
	$(BIN)/mbcdm picture $(DESIGN) docs/pictures/assembly.png

# Pages written from the package: both references, the list of catalogue entries, the checks, the loop's effects.
docs: setup
	$(BIN)/mbcdm schema --reference > docs/design-file.md
	$(BIN)/mbcdm schema --reference --measurement > docs/measurement-file.md
	$(BIN)/mbcdm catalogue --markdown > docs/catalogue.md
	$(BIN)/python -m mbcdm_cad.report.checks_page params/mbcdm.yaml params/siso_bevel.yaml params/siso_spur.yaml \
	  params/miso_spur.yaml > docs/checks.md
	$(BIN)/python -m tests.effects_page > docs/loop-effects.md

# The drives of params/gallery with their pictures and key figures.
gallery: setup
	$(BIN)/python -m mbcdm_cad.report.gallery_page params/gallery docs

benchmark: setup
	for layout in mbcdm siso_spur miso_spur siso_bevel; do \
	  $(BIN)/python benchmarks/speed.py params/$$layout.yaml && $(BIN)/python benchmarks/model.py params/$$layout.yaml \
	    || exit 1; done

# The drives of params/built-by-others beside what is published of them; DRIVES="NAME ...": only those anew.
built-by-others: setup
	$(BIN)/python -m benchmarks.studies.built_by_others params/built-by-others docs $(DRIVES)

# The docs as a site that needs no network; a dead link or a page that nothing leads to fails.
docs-site: setup
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs out/site

# Pinned versions with hashes, from pyproject.toml.
lock:
	$(PYTHON) -m piptools compile --quiet --generate-hashes --allow-unsafe --extra dev --extra cluster --extra logs --strip-extras \
	  --no-emit-index-url --no-emit-find-links --no-emit-trusted-host --no-emit-options --output-file requirements.lock pyproject.toml
	$(PYTHON) -m piptools compile --quiet --generate-hashes --allow-unsafe --strip-extras --constraint requirements.lock \
	  --no-emit-index-url --no-emit-find-links --no-emit-trusted-host --no-emit-options \
	  --output-file tests/requirements-solids.lock tests/requirements-solids.in

clean:
	rm -rf $(VENV) out
