# Needs Python 3.11 or newer with venv, and make; everything else comes from the locks.
# Another Python: make setup PYTHON=python3.12

PYTHON ?= python3
PORT ?= 8000
LOCK_FLAGS ?=
CORES := $(shell nproc)
WORKERS := $(shell echo $$(( 2 * $(CORES) )))

PY := .venv/bin/python
UV := .venv/bin/uv
# A slow network, or one that drops a connection now and then, must not end a first setup. Python
# compiles a module when it is first used; most of those that are installed never are.
PIP_INSTALL := $(PY) -m pip install --quiet --disable-pip-version-check --no-input --no-compile \
	--timeout 60 --retries 10
# So it has to keep what it compiles, whatever the machine says: a start takes 5 s longer without.
unexport PYTHONDONTWRITEBYTECODE
# uv takes a tenth of pip's time, but knows nothing of a mirror that pip is told of in its own files.
locked = $(UV) pip install --quiet --python $(PY) --require-hashes $(1) 2>/dev/null || \
	$(PIP_INSTALL) --require-hashes $(1)
NO_PACKAGES := echo "The packages could not be installed. They come from Python's package index:" \
	"is there a network, or a proxy or mirror that pip knows of? Then make setup again."
UV_COMPILE = $(UV) pip compile --quiet --universal --python-version 3.11 \
	--generate-hashes --no-annotate --custom-compile-command "make lock" $(LOCK_FLAGS)

# Scripts in .venv hold its absolute path: a checkout that has moved gets new stamps and a new .venv.
HERE := $(shell pwd | cksum | cut -d ' ' -f 1)
VENV_STAMP := .venv/made-$(HERE)
DEPS_STAMP := .venv/locked-$(HERE)
SETUP_STAMP := .venv/installed-$(HERE)
LOWEST_STAMP := build/lowest/installed-$(HERE)
LOWEST_ROUTES := $(addprefix tests/server/test_routes.py::,test_health \
	test_head_is_get_without_its_content \
	test_a_message_of_a_stream_that_is_no_short_frame \
	test_runs_of_a_tag_are_listed test_the_page_on_rest_names_every_route)
PAGE := frontend/dist/index.html
PAGE_SOURCES := $(shell find frontend -path frontend/node_modules -prune -o -path frontend/dist -prune -o \
	-type f -print 2>/dev/null)
# The kernel for browsers, which the page loads: it names a hash of the model's sources.
MODULE := frontend/kernel.wasm
MODULE_SOURCES := $(shell find $(addprefix backend/motionlab/,analysis/contouring.py control force_sharing \
	effects kernel lanes laws loop motor_design/fem/cells.py plant targets/wasm*.py telemetry/channels.py \
	telemetry/decimate.py timing.py) -type f ! -path '*/__pycache__/*')
# What makes lane parameters of a scenario, for the page: functions of the server, translated.
LANE_CODE := frontend/lanes.js
LANE_SOURCES := $(shell find $(addprefix backend/motionlab/,config/plant.py control force_sharing kernel \
	effects lanes laws plant targets/javascript*.py targets/lane_code.py timing.py) -type f ! -path '*/__pycache__/*')
HELP := build/help/index.html
HELP_SOURCES := README.md $(shell find docs backend/motionlab configs -type f ! -name '*.py[cod]' ! -name '*.nb[ci]')
LINT_STAMP := .venv/lint-$(HERE)
KERNELS_STAMP := .venv/kernels-$(HERE)
# Changes with each commit, and the version with it; empty without git.
COMMITS := $(wildcard $(shell git rev-parse --git-path logs/HEAD 2>/dev/null))
# Empty when .venv is missing or its Python has gone from the system.
VENV_RUNS := $(shell $(PY) -c 'print(1)' 2>/dev/null)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup run demo kernels test browser lint bench lowest lock schema types results docs FORCE

help: ## Show the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "make %-8s %s\n", $$1, $$2 }' Makefile

setup: $(SETUP_STAMP) ## Create .venv with everything needed to run and test
	@echo "Ready: .venv/bin/motionlab --help"

# Hundreds of processes are started, and none should compile again what it imports.
kernels test bench: export PYTHONDONTWRITEBYTECODE =

kernels: $(KERNELS_STAMP) ## Compile what is compiled once for all, rather than when it is first used

# Kernels first; then files on two processes for each core, since many tests wait; then browsers, one
# on each core; then what keeps time, one after another: a loop of drives takes a core. 5 is pytest's
# "no tests were selected".
# A crash ends the run: xdist would wait for the tests that the process had left.
test: $(SETUP_STAMP) $(PAGE) $(HELP) $(KERNELS_STAMP) ## Run the tests (PYTEST_ARGS="-k circle" for some)
	@frontend/npm test --silent
	@result=5; run() { \
		$(PY) -m pytest "$$@" --max-worker-restart=0 $(PYTEST_ARGS); code=$$?; \
		[ $$code = 5 ] || result=$$code; [ $$code = 5 ] || [ $$code = 0 ]; \
	}; \
	run -m "not browser and not realtime" -n $(WORKERS) --dist loadfile --no-loadscope-reorder && \
	run -m "browser and not realtime" -n $(CORES) --dist loadfile --no-loadscope-reorder $(if $(PYTEST_ARGS),,tests/e2e tests/targets) && \
	run -m realtime $(if $(PYTEST_ARGS),,tests/drive tests/e2e); \
	exit $$result

browser: ## Install Debian's Chromium and Firefox, for the browser tests (as root)
	@{ command -v chromium-headless-shell && command -v firefox-esr && ldconfig -p | grep -q libatomic; } >/dev/null || { \
		apt-get -o Acquire::Retries=5 update -qq && DEBIAN_FRONTEND=noninteractive \
		apt-get -o Acquire::Retries=5 install -y -qq --no-install-recommends chromium-headless-shell firefox-esr libatomic1; }

run: $(SETUP_STAMP) $(PAGE) ## Serve the lab at http://127.0.0.1:8000 (PORT=8001 elsewhere)
	@test -e $(HELP) || $(MAKE) --no-print-directory docs # every screen links to it
	@.venv/bin/motionlab serve --port $(PORT)

demo: $(SETUP_STAMP) $(PAGE) ## Write the Lab's what-ifs as a static folder, build/demo
	@.venv/bin/motionlab demo build/demo

lint: $(LINT_STAMP) ## Check style, types and the direction of imports
	@$(PY) -m ruff check
	@$(PY) -m ruff format --check
	@$(PY) -m basedpyright & types=$$!; \
	frontend/npm run --silent check && frontend/npm run --silent lint && wait $$types
	@.venv/bin/lint-imports --no-cache

bench: $(SETUP_STAMP) $(PAGE) ## Measure speed, each figure beside its reference (BENCH="stream page" for some)
	@$(PY) -m tests.bench $(BENCH)

# Kernels of its own: numba keeps one version's compiled code in a folder.
lowest: export NUMBA_CACHE_DIR = $(CURDIR)/build/lowest/kernels
# Not compiled, kernels compute both sides of every selection, of which numpy warns.
lowest: $(LOWEST_STAMP) ## Test the core on the lowest versions that pyproject.toml allows
	@NUMBA_DISABLE_JIT=1 build/lowest/bin/python -m pytest --quiet -W ignore::RuntimeWarning \
		$(LOWEST_ROUTES) & served=$$!; \
	build/lowest/bin/motionlab run circle >build/lowest/circle.txt && \
	build/lowest/bin/python -m pytest --quiet tests/config \
		$(addprefix tests/library/test_,named_maps.py records.py trajectories.py) && wait $$served

schema: $(SETUP_STAMP) ## Write configs/*.schema.json from the config models
	@$(PY) -m motionlab.config.schema

results: $(SETUP_STAMP) ## Compute the results that the screens open with, minutes; KINDS="tune sweep" for some
	@$(PY) -m motionlab.server.shipped $(KINDS)

docs: $(HELP) ## Build the documentation in build/help, which the lab serves at /help

types: $(SETUP_STAMP) ## Write what other languages read: frontend/src/app/api/schema.d.ts, tests/fixtures
	@mkdir -p build
	@.venv/bin/motionlab openapi > build/openapi.json
	@frontend/npm run --silent types
	@$(PY) -m tests.fixtures

# Pins stay as they are where they still fit; LOCK_FLAGS=--upgrade takes the newest.
lock: $(UV) ## Resolve the dependencies of pyproject.toml into hashed locks
	$(UV_COMPILE) pyproject.toml --extra lab --group build --output-file backend/requirements.lock
	$(UV_COMPILE) pyproject.toml --extra lab --extra cluster --group build \
		--constraints backend/requirements.lock --output-file backend/requirements-cluster.lock
	$(UV_COMPILE) --group test --group docs --constraints backend/requirements-cluster.lock \
		--output-file backend/requirements-test.lock
	$(UV_COMPILE) --group lint --constraints backend/requirements.lock \
		--constraints backend/requirements-test.lock --output-file backend/requirements-lint.lock
	$(UV_COMPILE) --group node --constraints backend/requirements-lint.lock \
		--output-file backend/requirements-node.lock
	$(UV_COMPILE) --group uv --output-file backend/requirements-uv.lock
	$(subst --universal,--resolution lowest-direct,$(UV_COMPILE)) pyproject.toml \
		--extra lab --extra control --extra gym --extra notebook --group build --group lowest \
		--output-file backend/requirements-lowest.lock

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

$(UV): $(VENV_STAMP) backend/requirements-uv.lock
	@$(PIP_INSTALL) --require-hashes -r backend/requirements-uv.lock || { $(NO_PACKAGES) >&2; exit 1; }
	@touch $@

$(DEPS_STAMP): $(UV) backend/requirements.lock backend/requirements-test.lock
	@echo "Installing the locked packages into .venv ..."
	@$(call locked,-r backend/requirements.lock -r backend/requirements-test.lock) || { \
		$(NO_PACKAGES) >&2; exit 1; }
	@touch $@

$(SETUP_STAMP): $(DEPS_STAMP) pyproject.toml hatch_build.py backend/motionlab/__init__.py $(COMMITS)
	@$(PIP_INSTALL) --no-deps --no-build-isolation --editable .
	@touch $@

$(LINT_STAMP): $(SETUP_STAMP) backend/requirements-lint.lock
	@echo "Installing the lint tools into .venv ..."
	@$(call locked,-r backend/requirements-lint.lock)
	@touch $@

$(KERNELS_STAMP): $(SETUP_STAMP) $(shell find backend/motionlab -name '*.py')
	@.venv/bin/motionlab precompile --quiet
	@touch $@

$(LOWEST_STAMP): $(UV) backend/requirements-lowest.lock pyproject.toml
	@echo "Installing the lowest versions into build/lowest ..."
	@$(UV) venv --quiet --clear --python "$(PYTHON)" build/lowest
	@$(UV) pip install --quiet --python build/lowest/bin/python --require-hashes \
		-r backend/requirements-lowest.lock
	@$(UV) pip install --quiet --python build/lowest/bin/python --no-deps \
		--no-build-isolation --editable .
	@mkdir build/lowest/kernels
	@touch $@

# The page is built with the system's node, or with one from the lock.
$(PAGE): $(SETUP_STAMP) $(PAGE_SOURCES) $(MODULE) $(LANE_CODE)
	@echo "Building the page ..."
	@frontend/npm run --silent build
	@touch $@

$(MODULE): $(SETUP_STAMP) $(MODULE_SOURCES)
	@echo "Compiling the kernel for browsers ..."
	@$(PY) -m motionlab.targets.wasm $@

$(LANE_CODE): $(SETUP_STAMP) $(LANE_SOURCES)
	@$(PY) -m motionlab.targets.lane_code $@

$(HELP): $(SETUP_STAMP) $(HELP_SOURCES)
	@echo "Building the documentation ..."
	@rm -rf build/help
	@$(PY) -m sphinx -q -W --keep-going -E -b html -d build/doctrees docs build/help
	@touch $@
