# `make help` lists the commands. Needs make and Python 3.11 or newer; everything else is installed into .venv.

VENV   := .venv
BIN    := $(VENV)/bin
PYTHON ?= $(firstword $(foreach name,python3 python3.14 python3.13 python3.12 python3.11,$(call if_recent,$(name))))
PIP    := $(BIN)/python -m pip --disable-pip-version-check --quiet
APT    := DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 >/dev/null
INPUTS := pyproject.toml constraints.txt
# A process for each core; a file's tests stay together, because they share what is slow to make, in our own order.
PARALLEL := -n logical --dist loadfile --no-loadscope-reorder
# Every worker of pytest and every command that a test starts would read all sources anew.
unexport PYTHONDONTWRITEBYTECODE

# A stamp is newer than what it was made from as long as nothing there has changed.
RUNTIME := $(VENV)/.nhtrack-setup
DEV     := $(VENV)/.nhtrack-setup-dev
GL      := $(VENV)/.nhtrack-setup-gl
BROWSER := $(VENV)/.nhtrack-setup-browser

# $(call if_recent,NAME): NAME if it is a Python of 3.11 or newer
if_recent = $(shell $(1) -c 'import sys; sys.version_info >= (3, 11) and print("$(1)")' 2>/dev/null)
# $(call install,.): installs the package with the pinned versions
install = $(PIP) install --constraint constraints.txt --editable '$(1)'
# Compiles what is not in the cache yet and says so; later runs find it there.
compile = $(BIN)/python -m nhtrack.experiment.compile
# Shell command that succeeds where a headless OpenGL draws a picture
draws = $(BIN)/python -c 'import sys, nhtrack.gl as gl; sys.exit(not any(gl.probe(b).ok for b in ("egl", "osmesa")))'
# Shell command that succeeds where there is a browser that reports can be tested in
browses = { command -v chromium || command -v chromium-browser || command -v google-chrome || \
    command -v google-chrome-stable; } >/dev/null

EGL_PACKAGES    := libegl1 libgl1-mesa-dri libopengl0
OSMESA_PACKAGES := libosmesa6

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup demo test check lint fuzz coverage bench docs site gallery clean

help:  ## list these commands
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1\t\2/p' Makefile | expand -t 16

setup: $(DEV) $(GL) $(BROWSER)  ## all that the other commands install into .venv

demo: $(RUNTIME) $(GL)  ## set up, run the paper's first example on wheels, say where its results are
	@$(compile)
	@$(BIN)/nhtrack run paper/example1

test: setup  ## set up and run the whole test suite
	@$(compile)
	@$(BIN)/python -m pytest -q $(PARALLEL) --durations=10

check: lint  ## lint, types, import rules and the fast tests
	@$(compile)
	@$(BIN)/python -m pytest -q $(PARALLEL) -m "not slow"

lint: $(DEV)  ## lint, types and import rules
	@$(BIN)/ruff check --quiet
	@$(BIN)/mypy --no-error-summary
	@$(BIN)/lint-imports --no-logo >$(VENV)/lint-imports.txt || { cat $(VENV)/lint-imports.txt; exit 1; }

fuzz: $(DEV)  ## judge N=1000 changed files of all kinds, of SEED=... (by default a fresh one)
	@$(BIN)/python -W error tests/fuzz/mutants.py --count $(or $(N),1000) $(if $(SEED),--seed $(SEED))

coverage: $(DEV)  ## what share of the lines the fast tests run
	@$(compile)
	@$(BIN)/python -m pytest -q $(PARALLEL) -m "not slow" --cov --cov-report=term:skip-covered

bench: $(DEV)  ## run every script in benchmarks/
	@for script in $(sort $(wildcard benchmarks/*.py)); do $(BIN)/python "$$script" || exit 1; done

docs: $(DEV)  ## write the generated pages of docs/ anew
	@$(BIN)/python -m nhtrack.config.documentation docs
	@for script in $(sort $(wildcard docs/_generate/generate_*.py)); do $(BIN)/python "$$script" || exit 1; done
	@$(BIN)/nhtrack paper --out $(VENV)/paper --no-report --force
	@$(BIN)/nhtrack paper --from $(VENV)/paper --out docs --no-report --force

site: $(DEV)  ## build the pages of docs/ for a browser, into build/site
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "build/site/index.html; for search: python3 -m http.server --directory build/site"

gallery: $(RUNTIME) $(GL)  ## make the films of renders/gallery anew
	@$(BIN)/python renders/make_gallery.py

clean:  ## remove .venv, caches and build products; runs/ stays
	rm -rf $(VENV) build dist .coverage .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find src tests benchmarks -name __pycache__ -prune -exec rm -rf {} +

# A Python without ensurepip (Debian splits it off) leaves half a .venv behind: it is removed and the package named.
$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "nhtrack needs Python 3.11 or newer: apt-get install python3" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip' 2>/dev/null || test "$$(id -u)" != 0 || ! command -v apt-get >/dev/null || \
	    { echo "installing python3-venv"; $(APT) update && $(APT) install -y --no-install-recommends python3-venv; }
	@$(PYTHON) -m venv $(VENV) >/dev/null || { rm -rf $(VENV); \
	    echo "Python's venv module is incomplete; ask for the package python3-venv" >&2; exit 1; }

$(RUNTIME): $(INPUTS) | $(BIN)/python
	@echo "installing nhtrack into $(VENV)"
	@$(call install,.)
	@touch $@

$(DEV): $(INPUTS) | $(BIN)/python
	@echo "installing nhtrack and its development tools into $(VENV)"
	@$(call install,.[dev])
	@touch $(RUNTIME) $@

# Headless OpenGL. Nothing is installed where EGL or OSMesa already draws; without either, all but pictures works.
$(GL): | $(RUNTIME)
	@$(draws) || test "$$(id -u)" != 0 || ! command -v apt-get >/dev/null || { \
	    echo "installing $(EGL_PACKAGES) for headless rendering"; $(APT) update; \
	    $(APT) install -y --no-install-recommends $(EGL_PACKAGES) && $(draws) || \
	    $(APT) install -y --no-install-recommends $(OSMESA_PACKAGES) || true; }
	@if $(draws); then touch $@; else \
	    echo "no headless OpenGL, so no video: ask for the packages $(EGL_PACKAGES) (EGL)," \
	        "or $(OSMESA_PACKAGES) (OSMesa)" >&2; fi

# A browser for the tests of reports. Nothing is installed where there is one; without, those tests are skipped.
$(BROWSER): | $(BIN)/python
	@$(browses) || test "$$(id -u)" != 0 || ! command -v apt-get >/dev/null || { \
	    echo "installing chromium for the tests of reports"; $(APT) update; \
	    $(APT) install -y --no-install-recommends chromium || true; }
	@if $(browses); then touch $@; else \
	    echo "no browser, so reports are not tested in one: ask for the package chromium" >&2; fi
