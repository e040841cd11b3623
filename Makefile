# Everything runs in a virtual environment of the project's own, made on first use.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
TOOLS := $(VENV)/.tools
DOCS := $(VENV)/.docs

# Small matrices: threads of the linear-algebra libraries only get in each other's way.
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
export MKL_NUM_THREADS := 1

.PHONY: run test test-slow soak mutations fuzz lint build docs setup clean

setup: $(STAMP)

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "rail-cosim needs Python 3.11 or newer; name one: make PYTHON=python3.12 ..." >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@

# The kernels' libraries: made by the installation, and again where their sources changed.
CORES := $(VENV)/.cores
$(CORES): $(STAMP) $(shell find fmus master -name '*.py' -path '*kernel*' -o -name loop.c)
	$(BIN)/python -m rail_native rail_vehicle slab_track rail_cosim
	@touch $@

# Only the tests need these.
$(TOOLS): $(STAMP)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --editable '.[tools]' || \
	  echo "The tools of others could not be installed: tests/tools will be skipped." >&2
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --editable '.[browser,docs]' || \
	  echo "The browser's driver could not be installed: tests/browser will be skipped." >&2
	@touch $@

# Sets up, builds both FMUs, runs the HD line at 300 km/h; results and plots in results/.
run: $(CORES)
	@mkdir -p results
	$(BIN)/rail-cosim run --line HD --speed 300 --distance 100 --out results/run.nc --plot results/run.png

test: $(TOOLS) $(CORES)
	$(BIN)/python -m pytest -n 2 --dist loadfile

test-slow: $(TOOLS) $(CORES)
	$(BIN)/python -m pytest -n 2 --dist loadfile -m slow

# 100 km in one go: memory and drift; half an hour.
soak: $(STAMP)
	$(BIN)/python benchmarks/soak.py --kilometres 100 --out results/soak

# Deliberate faults in a copy of the sources: the tests must notice them. At most an hour.
mutations: $(STAMP)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --editable '.[mutations]'
	$(BIN)/python tests/mutations/check.py

# A minute for each reader of files and bytes from elsewhere.
fuzz: $(STAMP)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --editable '.[fuzz]' || \
	  echo "atheris could not be installed." >&2
	$(BIN)/python tests/fuzz/run.py

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

build: $(STAMP)
	$(BIN)/rail-cosim build --out build

$(DOCS): $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --editable '.[docs]'
	@touch $@

# Any warning, such as a broken link, is an error.
docs: $(DOCS)
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict
	@echo "the pages are in build/site: open build/site/index.html"

clean:
	rm -rf $(VENV) build results
