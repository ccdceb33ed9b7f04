# `make run` (the paper's three problems), `make test` (lint, types, layers, tests), `make docs` (the site).
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready
# Kept bytecode lets the child processes of tests start faster.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: run test verify slow face docs package clean

run: $(READY)
	$(BIN)/poinsot paper --out out --overwrite

test: $(READY)
	@echo "== lint and format"
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	@echo "== types"
	$(BIN)/mypy
	@echo "== layers"
	$(BIN)/lint-imports
	@echo "== tests, on all cores"
	$(BIN)/python -m pytest --numprocesses auto --dist worksteal --durations 25

verify: $(READY)
	$(BIN)/poinsot verify

# The stubs, the JSON Schema and the tables that follow from the modules.
face: $(READY)
	$(BIN)/python -m tools.face

slow: $(READY)
	$(BIN)/python -m pytest -m slow --numprocesses auto --dist worksteal --durations 25

# The site, in docs/_build/html; a warning is an error. All pages are read anew, as only then the search has its index;
# notebooks and examples that have not changed are not run again. Its tests are those that need it, or a browser.
docs: .venv/.docs
	$(BIN)/python -m sphinx --fresh-env --nitpicky --fail-on-warning --keep-going --quiet docs docs/_build/html
	$(BIN)/python -m pytest -m "docs or browser"

.venv/.docs: $(READY)
	@echo "== setting up the tools of the site (once)"
	$(BIN)/python -m pip install --quiet --group docs
	@touch .venv/.docs

# Wheel and source distribution, in dist/; each is tried in an empty environment, and the wheel also with the lowest
# versions that pyproject.toml admits: make package PYTHON=python3.13
FRESH := .venv-package
package:
	$(PYTHON) -m venv --clear $(FRESH)
	$(FRESH)/bin/python -m pip install --quiet --upgrade pip build
	rm -rf dist
	$(FRESH)/bin/python -m build --outdir dist
	for made in dist/*.whl dist/*.tar.gz; do \
		$(PYTHON) -m venv --clear $(FRESH) && $(FRESH)/bin/python -m pip install --quiet $$made \
			&& $(FRESH)/bin/poinsot verify || exit 1; \
	done
	@echo "== the lowest versions of all dependencies"
	$(PYTHON) -m venv --clear $(FRESH)
	$(FRESH)/bin/python -m pip install --quiet uv
	$(FRESH)/bin/uv pip install --quiet --python $(FRESH)/bin/python --only-binary :all: --resolution lowest-direct \
		--requirements pyproject.toml --extra all
	$(FRESH)/bin/python -m pip install --quiet --no-deps dist/*.whl
	$(FRESH)/bin/poinsot verify | tee $(FRESH)/verify.txt
	grep --quiet "comparisons hold" $(FRESH)/verify.txt
	$(FRESH)/bin/python tools/snippets.py README.md
	cd $(FRESH) && bin/poinsot new top.toml --overwrite && bin/poinsot run top.toml --overwrite

$(READY): pyproject.toml
	@echo "== setting up .venv (once)"
	$(PYTHON) -c 'import sys; sys.exit("poinsot needs Python 3.11 or newer, but this is " + sys.version.split()[0] + ". Name another one: make PYTHON=python3.12") if sys.version_info < (3, 11) else 0'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable '.[all]' --group dev
	@touch $(READY)

# `make bench` writes docs/benchmarks.md and appends to benchmarks/history.csv (some minutes); `make bench-short` takes a
# quick look into out/bench-short. Both go without the peers that do not install; `make bench-peers` tries these again.
# numbalsoda is built from source where it has no wheel, which needs a Fortran compiler. `make bench ONLY="tops drifts"`
# prints single sections; `make bench RESUME=1` goes on where a run stopped.
BENCH := .venv-bench
PEERS := heyoka numba numbalsoda diffrax mujoco bsk

define INSTALL_PEERS
@echo "== installing the peers"
@trap 'exit 130' INT; for peer in $(PEERS); do \
	$(BENCH)/bin/python -m pip install --quiet $$peer >$(BENCH)/$$peer.log 2>&1 \
		|| echo "== $$peer did not install ($(BENCH)/$$peer.log says why): the report goes without it;" \
			"make bench-peers tries again"; \
done
@touch $(BENCH)/.peers
endef

.PHONY: bench bench-short bench-peers

bench: $(BENCH)/.peers
	$(BENCH)/bin/python -m benchmarks $(if $(ONLY),--only $(ONLY)) $(if $(RESUME),--resume)

bench-short: $(BENCH)/.peers
	$(BENCH)/bin/python -m benchmarks --short

bench-peers: $(BENCH)/.ready
	$(INSTALL_PEERS)

$(BENCH)/.peers: $(BENCH)/.ready
	$(INSTALL_PEERS)

$(BENCH)/.ready: pyproject.toml
	@echo "== setting up $(BENCH) (once)"
	$(PYTHON) -m venv $(BENCH)
	$(BENCH)/bin/python -m pip install --quiet --upgrade pip
	$(BENCH)/bin/python -m pip install --quiet --editable '.[symbolic,sky,cluster]' matplotlib
	@touch $(BENCH)/.ready

clean:
	rm -rf .venv $(BENCH) $(FRESH) dist out docs/_build docs/generated
