# Needs Python 3.11 or newer with venv, and make; everything else comes from the locks.
# Another Python: make setup PYTHON=python3.12

PYTHON ?= python3
LOCK_FLAGS ?=

PY := .venv/bin/python
PIP_INSTALL := $(PY) -m pip install --quiet --disable-pip-version-check --no-input
UV_COMPILE = build/uv/bin/uv pip compile --quiet --universal --python-version 3.11 \
	--generate-hashes --no-annotate --custom-compile-command "make lock" $(LOCK_FLAGS)

# Scripts in .venv hold its absolute path: a checkout that has moved gets new stamps and a new .venv.
HERE := $(shell pwd | cksum | cut -d ' ' -f 1)
VENV_STAMP := .venv/made-$(HERE)
DEPS_STAMP := .venv/locked-$(HERE)
SETUP_STAMP := .venv/installed-$(HERE)
LINT_STAMP := .venv/lint-$(HERE)
# Empty when .venv is missing or its Python has gone from the system.
VENV_RUNS := $(shell $(PY) -c 'print(1)' 2>/dev/null)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup test lint bench lock schema FORCE

help: ## Show the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "make %-8s %s\n", $$1, $$2 }' Makefile

setup: $(SETUP_STAMP) ## Create .venv with everything needed to run and test
	@echo "Ready: .venv/bin/motionlab --help"

test: $(SETUP_STAMP) ## Run the tests (PYTEST_ARGS="-k circle" for some of them)
	@$(PY) -m pytest $(PYTEST_ARGS)

lint: $(LINT_STAMP) ## Check style, types and the direction of imports
	@$(PY) -m ruff check
	@$(PY) -m ruff format --check
	@$(PY) -m basedpyright
	@.venv/bin/lint-imports --no-cache

bench: $(SETUP_STAMP) ## Measure speed, each figure beside its reference
	@$(PY) -m tests.bench

schema: $(SETUP_STAMP) ## Write configs/scenario.schema.json from the config models
	@$(PY) -m motionlab.config.schema

# Pins stay as they are where they still fit; LOCK_FLAGS=--upgrade takes the newest.
lock: build/uv/bin/uv ## Resolve the dependencies of pyproject.toml into hashed locks
	$(UV_COMPILE) pyproject.toml --group build --output-file backend/requirements.lock
	$(UV_COMPILE) --group test --constraints backend/requirements.lock \
		--output-file backend/requirements-test.lock
	$(UV_COMPILE) --group lint --constraints backend/requirements.lock \
		--constraints backend/requirements-test.lock --output-file backend/requirements-lint.lock

$(VENV_STAMP): $(if $(VENV_RUNS),,FORCE)
	@command -v "$(PYTHON)" >/dev/null || { \
		echo "Python 3.11 or newer is needed: apt-get install python3 python3-venv" >&2; exit 1; }
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "Python 3.11 or newer is needed, $(PYTHON) is older:" \
			"install a newer one, then make setup PYTHON=python3.11" >&2; exit 1; }
	@"$(PYTHON)" -c 'import ensurepip, venv' 2>/dev/null || { \
		echo "$(PYTHON) has no venv: apt-get install python3-venv" >&2; exit 1; }
	@"$(PYTHON)" -m venv --clear .venv
	@touch $@

$(DEPS_STAMP): $(VENV_STAMP) backend/requirements.lock backend/requirements-test.lock
	@echo "Installing the locked packages into .venv ..."
	@$(PIP_INSTALL) --require-hashes -r backend/requirements.lock -r backend/requirements-test.lock
	@touch $@

$(SETUP_STAMP): $(DEPS_STAMP) pyproject.toml backend/motionlab/__init__.py
	@$(PIP_INSTALL) --no-deps --no-build-isolation --editable .
	@touch $@

$(LINT_STAMP): $(SETUP_STAMP) backend/requirements-lint.lock
	@echo "Installing the lint tools into .venv ..."
	@$(PIP_INSTALL) --require-hashes -r backend/requirements-lint.lock
	@touch $@

build/uv/bin/uv:
	@"$(PYTHON)" -m venv build/uv
	@build/uv/bin/pip install --quiet --disable-pip-version-check uv
