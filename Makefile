# Everything runs in .venv, which the verbs make and keep up to date by themselves.

PYTHON ?= python3

VENV := .venv
WEB := src/robomore/report/web
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet --quiet
# One lock for every platform, and the same versions for every Python: runs stay comparable.
COMPILE := uv pip compile pyproject.toml --quiet --universal --python-version 3.11 \
	--fork-strategy fewest --generate-hashes --no-header --no-emit-index-url

# Many containers have Python keep no compiled modules, and then each of the many processes that the
# tests start compiles RoboMoRe anew.
# One process more than there are cores: some tests wait for a server or a clock.
PROCESSES = $$($(PYTHON) -c 'import os; print(1 + len(getattr(os, "sched_getaffinity", lambda _: range(os.cpu_count()))(0)))')
PYTEST = env -u PYTHONDONTWRITEBYTECODE OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n $(PROCESSES)
# What a file's tests share (runs, compiled trainers, a browser) is made once then, and not once on
# each core. In the order of the files: those with the fewest tests, which would come last, take the
# longest. Not with all examples, of which single files have hundreds of slow ones.
TOGETHER := --dist loadfile --no-loadscope-reorder

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help demo picture test test-all test-robots lint format lock bundle clean

help: ## List these verbs
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "make %-8s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: $(VENV)/.run ## Search for a better robot on this machine; ends with a report
	$(BIN)/robomore run swimmer --preset quick --steps 20000 \
		--method-option morphologies=3 --method-option rewards=2 --method-option max_cycles=2 \
		--seed 0 --out runs/demo

picture: $(VENV)/.run ## Make a moving picture like the README's from what the demo found
	$(BIN)/robomore play runs/demo --beside --seconds 10 --out runs/demo/champion.webp

test: $(VENV)/.dev ## Run the tests, on all cores
	$(PYTEST) $(TOGETHER)

test-all: $(VENV)/.dev ## Run the tests with all their examples (takes long)
	$(PYTEST) -m ''

test-robots: $(VENV)/.dev ## Run the tests with robots that others made (downloads 30 MB)
	@$(PIP) install --no-deps --require-hashes --requirement lock/robots.txt
	$(PYTEST) -m robots

lint: $(VENV)/.dev ## Check style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(VENV)/.dev ## Put the code into the one style
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

lock: ## Choose the packages' versions anew (needs uv)
	@command -v uv >/dev/null || { echo "make lock needs uv: pip install uv" >&2; exit 2; }
	$(COMPILE) --upgrade --group build --output-file lock/base.txt
	$(COMPILE) --upgrade --group dev --extra union --extra llm --extra plot --extra table --extra serve --extra ray --extra export --extra tensorboard --constraint lock/base.txt --output-file lock/dev.txt
	$(subst pyproject.toml,--group pyproject.toml:robots --no-deps,$(COMPILE)) --upgrade --output-file lock/robots.txt

# The first line names the sources by their digest, which a test compares.
bundle: ## Put the scripts of the pages into one file anew (needs Node)
	@test -d $(WEB)/node_modules || npm --prefix $(WEB) ci --no-audit --no-fund
	@cd $(WEB) && rm -f bundle.js && \
	digest=$$(LC_ALL=C; cat *.js package.json | sha256sum | cut -c 1-16) && \
	npx esbuild main.js --bundle --minify --format=iife --target=es2022 --charset=ascii \
		--legal-comments=none --banner:js="/* $$digest. RoboMoRe (MIT). Includes three.js, https://threejs.org, MIT, Copyright 2010-2026 three.js authors. */" \
		--outfile=bundle.js

clean: ## Remove .venv and caches; runs/ stays
	rm -rf $(VENV) .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# The stamps lie in .venv, so that removing it is all it takes to start anew.
$(VENV)/.made:
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 15))' || { \
		echo "RoboMoRe's locked packages are for Python 3.11 to 3.14; '$(PYTHON)' is $$($(PYTHON) --version 2>&1)." >&2; \
		echo "Name another one, for example: make $(MAKECMDGOALS) PYTHON=python3.12" >&2; exit 2; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
		echo "'$(PYTHON)' cannot make virtual environments; on Debian and Ubuntu: apt install python3-venv" >&2; exit 2; }
	@echo "Setting up $(VENV) (once; it downloads some 200 MB)"
	@$(PYTHON) -m venv $(VENV)
	@touch $@

$(VENV)/.run: lock/base.txt pyproject.toml $(VENV)/.made
	@$(PIP) install --no-deps --require-hashes --requirement lock/base.txt
	@$(PIP) install --no-index --no-build-isolation --no-deps --editable .
	@touch $@

$(VENV)/.dev: lock/dev.txt $(VENV)/.run
	@$(PIP) install --no-deps --require-hashes --requirement lock/dev.txt
	@touch $@
