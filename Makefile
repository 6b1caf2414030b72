# Each target sets itself up in .venv from a bare checkout: Python 3.11 or newer, pip and make suffice.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet
WORKERS ?= 2

.PHONY: help demo test test-fast lint bench clean

help:
	@echo "make demo       Fig. 7 of the paper: results/fig7.nc and its picture"
	@echo "make test       the whole test suite"
	@echo "make test-fast  the tests that are not marked slow"
	@echo "make lint       ruff, mypy and the import contracts"
	@echo "make bench      the benchmarks"
	@echo "make clean      remove .venv, build products and caches; results/ stays"

demo: $(VENV)/.core
	$(BIN)/stickslip sweep configs/fig7.yaml -o results/fig7.nc --overwrite
	$(BIN)/stickslip plot results/fig7.nc -o results/fig7.png
	@echo
	@echo "data:    $(CURDIR)/results/fig7.nc"
	@echo "picture: $(CURDIR)/results/fig7.png"

test: $(VENV)/.dev
	$(BIN)/python -m pytest -n $(WORKERS)

test-fast: $(VENV)/.dev
	$(BIN)/python -m pytest -n $(WORKERS) -m "not slow"

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/.core
	set -e; for script in $(sort $(wildcard benchmarks/bench_*.py)); do $(BIN)/python $$script; done

# One environment, one stamp for each set of packages in it; a change of pyproject.toml installs anew.

$(VENV)/.created:
	@$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "stickslip needs Python 3.11 or newer; this is " + sys.version.split()[0] + ". Try: make PYTHON=python3.11")'
	$(PYTHON) -m venv --clear $(VENV)
	@touch $@

$(VENV)/.core: pyproject.toml | $(VENV)/.created
	$(PIP) --editable .
	@touch $@

$(VENV)/.dev: pyproject.toml | $(VENV)/.created
	$(PIP) --editable ".[dev]"
	@touch $(VENV)/.core $@

clean:
	rm -rf $(VENV) build dist *.egg-info
	rm -rf .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find stickslip sweeps tests -name __pycache__ -type d -prune -exec rm -rf {} +
