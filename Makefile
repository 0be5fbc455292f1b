# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
# RayCore. `make` alone lists what there is to make. Every target sets up what it needs.

SHELL         := /bin/bash
.SHELLFLAGS   := -eu -o pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS     += --no-builtin-rules --no-print-directory

PYTHON ?= python3
VENV   := .venv
PY     := $(VENV)/bin/python

##@ Set-up
# A stamp is named after the hash of what it stands for: nothing is installed twice, and a changed
# requirement file installs itself with the next command.
hash_of       = $(shell { $(1); } | sha256sum | cut -c1-16)
VENV_STAMP   := $(VENV)/.created
RENDER_STAMP := $(VENV)/.render-$(call hash_of,cat requirements/render.txt; sed '/^.tool.pytest/Q' pyproject.toml)
DEV_STAMP    := $(VENV)/.dev-$(call hash_of,cat requirements/dev.txt requirements/render.txt)
DASK_STAMP   := $(VENV)/.cluster-$(call hash_of,cat requirements/cluster.txt requirements/render.txt)
PAIR_STAMP   := $(VENV)/.mitsuba-$(call hash_of,cat requirements/mitsuba.txt requirements/render.txt)
# --no-compile: Python compiles what is imported, a small part, when it is imported first.
PIP_INSTALL   = $(PY) -m pip install --quiet --disable-pip-version-check --no-input --no-compile

$(VENV_STAMP):
	@command -v $(PYTHON) >/dev/null || { echo "error: $(PYTHON) not found; see README.md, Getting started" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "error: Python 3.11 or newer is needed" >&2; exit 1; }
	@for tool in g++ perl; do command -v $$tool >/dev/null || { echo "error: $$tool not found; see README.md, Getting started" >&2; exit 1; }; done
	@echo "Creating $(VENV)"
	@rm -rf $(VENV)
	@$(PYTHON) -m venv $(VENV) || { echo "error: no venv module; see README.md, Getting started" >&2; rm -rf $(VENV); exit 1; }
	@touch $@

$(RENDER_STAMP): $(VENV_STAMP)
	@echo "Installing requirements/render.txt into $(VENV)"
	@$(PIP_INSTALL) --require-hashes -r requirements/render.txt
	@$(PIP_INSTALL) --no-deps --no-build-isolation --no-index -e .
	@rm -f $(VENV)/.render-*; touch $@

$(DEV_STAMP): $(RENDER_STAMP)
	@echo "Installing requirements/dev.txt into $(VENV)"
	@$(PIP_INSTALL) --require-hashes -r requirements/dev.txt
	@rm -f $(VENV)/.dev-*; touch $@

$(PAIR_STAMP): $(RENDER_STAMP)
	@echo "Installing requirements/mitsuba.txt into $(VENV)"
	@$(PIP_INSTALL) --require-hashes -r requirements/mitsuba.txt
	@rm -f $(VENV)/.mitsuba-*; touch $@

$(DASK_STAMP): $(RENDER_STAMP)
	@echo "Installing requirements/cluster.txt into $(VENV)"
	@$(PIP_INSTALL) --require-hashes -r requirements/cluster.txt
	@rm -f $(VENV)/.cluster-*; touch $@

.PHONY: cluster
cluster: $(DASK_STAMP)  ## install Dask, for `raycore sweep --scheduler`

.PHONY: setup
setup: $(DEV_STAMP)  ## install everything that any target needs into .venv

.PHONY: requirements
# Lines of options are dropped: they say where this machine gets its packages from.
requirements:  ## pin requirements/*.in again, with hashes
	@$(PYTHON) -m venv build/pip-tools && build/pip-tools/bin/pip install --quiet pip-tools==7.6.2
	@for set in render dev mitsuba cluster; do \
	  echo "Pinning requirements/$$set.in"; \
	  build/pip-tools/bin/pip-compile --quiet --generate-hashes --strip-extras --allow-unsafe --no-header \
	    -o requirements/$$set.txt requirements/$$set.in; \
	  sed -i '/^--/d' requirements/$$set.txt; \
	done

##@ Pictures
# make render SCENE=scenes/hall.py SIZE=320x192 OUT=picture.png ARGS='--no-shadows --check'
SCENE ?= hall
SIZE  ?= 320x192
OUT   ?= build/render.png
ARGS  ?=

.PHONY: render info sweep bench compare
render: $(RENDER_STAMP)  ## render SCENE at SIZE to OUT by the Verilated RTL; more options in ARGS
	@mkdir -p $(dir $(OUT))
	@$(VENV)/bin/raycore render '$(SCENE)' -o '$(OUT)' --size $(SIZE) $(ARGS)
	@echo "$(OUT)"

info: $(RENDER_STAMP)  ## show triangles, tree and memory of SCENE
	@$(VENV)/bin/raycore info '$(SCENE)' $(ARGS)

sweep: $(RENDER_STAMP)  ## render SCENE on many cache geometries and memories, into build/sweep-SCENE; lists and more in ARGS
	@mkdir -p build
	@$(VENV)/bin/raycore sweep '$(SCENE)' -o 'build/sweep-$(notdir $(basename $(SCENE)))' $(ARGS)

compare: $(PAIR_STAMP)  ## render SCENE at SIZE by Mitsuba 3 too, side by side in build/compare; options in ARGS
	@$(PY) -m raycore.mitsuba '$(SCENE)' -o 'build/compare/$(notdir $(basename $(SCENE)))' --size $(SIZE) $(ARGS)

bench: $(DEV_STAMP)  ## measure rays per cycle, slots, hit rates and bytes beside the paper's
	@$(PY) -m raycore.bench $(ARGS)

##@ Checks
# Two workers: one simulation fills a core. A worker's C++ compilations run one after the other.
JOBS   ?= 2
PYTEST  = RAYCORE_JOBS=$${RAYCORE_JOBS:-1} $(PY) -m pytest -n $(JOBS) --dist worksteal -q

.PHONY: test sim sim-full lint formal coverage synth
test: $(DEV_STAMP)  ## run every test: units, models, proofs, small frames
	@$(PYTEST) $(ARGS)

sim: $(DEV_STAMP)  ## Verilator regression: frames bit for bit, long random runs, corrupted images
	@$(PY) -m raycore.regress $(ARGS)

sim-full: $(DEV_STAMP)  ## the same with larger frames and more seeds; takes hours
	@$(PY) -m raycore.regress --full $(ARGS)

lint: $(DEV_STAMP)  ## Verilator -Wall, slang, Verible, ruff, file lists, generated files; CHECK= for one
	@PYTHONPATH=scripts $(PY) scripts/tools/lint.py $(CHECK)

formal: $(DEV_STAMP)  ## only the proofs
	@$(PYTEST) formal $(ARGS)

coverage: $(DEV_STAMP)  ## run the tests with coverage of rtl/; build/coverage.info for lcov
	@rm -rf build/coverage build/coverage.info build/coverage-html
	@RAYCORE_COVERAGE=1 $(PYTEST) $(ARGS)
	@$(PY) scripts/tools/rtl_coverage.py
	@if command -v genhtml >/dev/null; then \
	  genhtml --quiet --branch-coverage -o build/coverage-html build/coverage.info && echo "build/coverage-html/index.html"; \
	else echo "lcov is not installed: no build/coverage-html"; fi

synth: $(DEV_STAMP)  ## synthesize units and RTU with Yosys, resources beside Table I; a quarter of an hour
	@$(PY) fpga/synth.py $(ARGS)

##@ Work on it
.PHONY: waves format filelist regs
waves: $(DEV_STAMP)  ## record TEST (pytest's name, or FST file) and write a GTKWave file by stage; INSTANCE=
	@test -n "$(TEST)" || { echo "usage: make waves TEST=tb/rc_skid/test_rc_skid.py [INSTANCE=u_skid]" >&2; exit 2; }
	@PYTHONPATH=scripts $(PY) scripts/tools/waves.py '$(TEST)' $(if $(INSTANCE),--instance '$(INSTANCE)') $(ARGS)

format: $(DEV_STAMP)  ## format changed SystemVerilog and Python files, or FILES=
	@PYTHONPATH=scripts $(PY) scripts/tools/format.py $(FILES)

filelist: $(DEV_STAMP)  ## write rtl/rc.f and raycore.core from the files in rtl/
	@$(PY) scripts/tools/filelist.py write

regs: $(DEV_STAMP)  ## write everything that follows from rtl/top/rc_regs.rdl
	@PYTHONPATH=scripts $(PY) scripts/tools/gen_regs.py

##@ Tidy
.PHONY: clean distclean
clean:  ## remove build/
	rm -rf build

distclean: clean  ## remove build/ and .venv/
	rm -rf $(VENV)
	find . -name __pycache__ -not -path './.git/*' -prune -exec rm -rf {} +
	rm -rf scripts/raycore.egg-info

.PHONY: help
help:  ## this list
	@awk 'BEGIN {FS = ":.*## *"; print "RayCore: make TARGET [NAME=VALUE...]"} \
	  /^##@/ {printf "\n%s\n", substr($$0, 5)} \
	  /^[a-z][a-z-]*:.*## / {printf "  %-13s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))
