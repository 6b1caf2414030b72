# Each target sets up its environment in .venv; it needs only Python 3.11 or newer, pip and make.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet
# pip says nothing on its way.
INSTALLING = @echo "installing $(1) into $(VENV) with pip: about a minute, and not again"
WORKERS ?= 2

.PHONY: help demo extras test test-fast stress faults lint generated docs bench bench-quick tables clean

help:
	@echo "make demo       Fig. 7 of the paper: results/fig7.nc and its picture"
	@echo "make extras     what report, explore, fit, .parquet and clusters need"
	@echo "make test       the test suite, except stress and faults"
	@echo "make test-fast  the tests that are not marked slow"
	@echo "make stress     the long tests of the numerics, with every fluid and method"
	@echo "make faults     the long tests of kills, failing disks and damage, and their table; hours"
	@echo "make lint       ruff, mypy and the import contracts"
	@echo "make generated  the schema of configs and docs/configuration.md"
	@echo "make docs       the documentation as a site, with computed tutorial and gallery"
	@echo "make bench      the benchmarks with pictures and tables; hours, on an idle machine"
	@echo "make tables     the pictures and tables of the benchmarks from their records"
	@echo "make bench-quick  the same scripts in a minute or two, to see that they run"
	@echo "make clean      remove .venv, build products and caches; results/ stays"

demo: $(VENV)/.core
	$(BIN)/stickslip sweep configs/fig7.yaml -o results/fig7.nc --overwrite
	$(BIN)/stickslip plot results/fig7.nc -o results/fig7.png --overwrite
	@echo
	@echo "data:    $(CURDIR)/results/fig7.nc"
	@echo "picture: $(CURDIR)/results/fig7.png"

extras: $(VENV)/.created
	$(call INSTALLING,what report explore fit .parquet and clusters need)
	$(PIP) --editable ".[report,explore,table,fit,posterior,dask]"
	@touch $(VENV)/.core

test: $(VENV)/.dev
	$(BIN)/python -m pytest -n $(WORKERS)

test-fast: $(VENV)/.dev
	$(BIN)/python -m pytest -n $(WORKERS) -m "not slow and not stress and not faults"

stress: $(VENV)/.dev
	$(PIP) --editable ".[tools]"
	$(BIN)/python -m pytest -n $(WORKERS) -m "stress or hypothesis" --hypothesis-profile=search
	$(BIN)/python benchmarks/bench_stability.py
	$(MAKE) --no-print-directory tables

faults: $(VENV)/.dev
	$(BIN)/python -m pytest -n $(WORKERS) -m faults
	$(BIN)/python benchmarks/bench_faults.py
	$(MAKE) --no-print-directory tables

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

BENCHMARKS = $(sort $(wildcard benchmarks/bench_*.py))

bench: $(VENV)/.bench
	set -e; for script in $(BENCHMARKS); do echo "== $$script"; $(BIN)/python $$script --full; done
	$(MAKE) --no-print-directory tables

# Pictures and tables of the records as they are; seconds.
tables: $(VENV)/.core
	cd benchmarks && for kind in tables pictures; do "$(CURDIR)/$(BIN)/python" -m pages.$$kind; done

generated: $(VENV)/.core
	$(BIN)/stickslip schema > configs/stickslip.schema.json
	$(BIN)/python docs/configuration.py

SITE := docs/_build

# All pages anew, since some hang on the code; notebooks and pictures are kept where they would be the same.
docs: $(VENV)/.docs
	$(BIN)/python docs/gallery.py
	rm -rf $(SITE)/html $(SITE)/doctrees
	$(BIN)/sphinx-build --builder html --nitpicky --fail-on-warning --keep-going --quiet -c docs -d $(SITE)/doctrees . $(SITE)/html
	$(BIN)/python docs/check_links.py
	@echo
	@echo "site: $(CURDIR)/$(SITE)/html/index.html"

bench-quick: $(VENV)/.bench
	set -e; for script in $(BENCHMARKS); do echo "== $$script"; $(BIN)/python $$script --quick; done

# One environment, one stamp for each set of packages in it; a change of pyproject.toml installs anew.

$(VENV)/.created:
	@$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "stickslip needs Python 3.11 or newer; this is " + sys.version.split()[0] + ". Try: make PYTHON=python3.11")'
	$(PYTHON) -m venv --clear $(VENV)
	@touch $@

$(VENV)/.core: pyproject.toml | $(VENV)/.created
	$(call INSTALLING,stickslip and the packages that it needs)
	$(PIP) --editable .
	@touch $@

$(VENV)/.dev: pyproject.toml | $(VENV)/.created
	$(call INSTALLING,stickslip and what its tests need)
	$(PIP) --editable ".[dev]"
	@touch $(VENV)/.core $@

$(VENV)/.docs: pyproject.toml | $(VENV)/.created
	$(call INSTALLING,stickslip and what its pages need)
	$(PIP) --editable ".[docs]"
	@touch $(VENV)/.core $@

# Each peer by itself: one that cannot be built here must not take the others away.
$(VENV)/.bench: pyproject.toml | $(VENV)/.created
	$(call INSTALLING,stickslip and what its benchmarks need)
	$(PIP) --editable ".[report,explore,fit,dask]"
	@touch $(VENV)/.core
	$(BIN)/python -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["bench"], sep="\n")' > $(VENV)/peers.txt
	while read -r peer; do $(PIP) "$$peer" || echo "$$peer cannot be installed here; the benchmarks leave it out"; done < $(VENV)/peers.txt
	@touch $@

clean:
	rm -rf $(VENV) build dist *.egg-info docs/_build
	rm -rf .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find stickslip sweeps tests -name __pycache__ -type d -prune -exec rm -rf {} +
