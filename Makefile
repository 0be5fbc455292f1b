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
stamp_of = $(VENV)/.$(1)-$(shell cat $(2) | sha256sum | cut -c1-16)
VENV_STAMP   := $(VENV)/.created
RENDER_STAMP := $(call stamp_of,render,requirements/render.txt pyproject.toml)
DEV_STAMP    := $(call stamp_of,dev,requirements/dev.txt requirements/render.txt)
PIP_INSTALL   = $(PY) -m pip install --quiet --disable-pip-version-check --no-input

$(VENV_STAMP):
	@command -v $(PYTHON) >/dev/null || { echo "error: $(PYTHON) not found; see README.md, Getting started" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "error: Python 3.11 or newer is needed" >&2; exit 1; }
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

.PHONY: setup
setup: $(DEV_STAMP)  ## install everything that any target needs into .venv
