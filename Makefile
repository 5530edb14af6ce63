# The whole project from a clean clone. Everything is installed into .venv and nowhere else.
#
#   make demo     install, then run the main job; results in runs/demo      (options: make demo ARGS="--data FOLDER")
#   make test     install the test extra, then run the default test suite   (options: make test ARGS="-k forces")
#   make validation   physics against measured crowds, minutes; writes docs/validation.md
#   make check    format, lint, types, layering, spelling
#   make clean    remove .venv and every cache; runs/ stays

PYTHON ?= python3
ARGS ?=
BIN := .venv/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet --editable

.PHONY: demo test validation check clean
.DEFAULT_GOAL := demo

demo: .venv/installed
	$(BIN)/crowdnav demo $(ARGS)

test: .venv/installed-test .venv/gymnasium-0.29.1
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses 2 --dist loadfile $(ARGS)

validation: .venv/installed-validation
	$(BIN)/python tests/validation/report.py

check: .venv/installed-check
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell

clean:
	rm -rf .venv .mypy_cache .ruff_cache .pytest_cache .import_linter_cache .hypothesis .benchmarks
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# The Gymnasium that CleanRL pinned, beside our own: one test runs the environment with it.
.venv/gymnasium-%: | .venv/bin/python
	$(BIN)/python -m pip --disable-pip-version-check install --quiet --no-deps --target $@ gymnasium==$*

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.version_info >= (3, 11) or sys.exit("make: expected Python 3.11 or newer, found %d.%d (%s); try: make PYTHON=python3.12" % (*sys.version_info[:2], sys.executable))'
	$(PYTHON) -m venv .venv

# The stamps make a second `make` start at once; a change of pyproject.toml installs again.
.venv/installed: pyproject.toml | .venv/bin/python
	@echo "Installing the packages and what they need into .venv (some minutes the first time)"
	$(PIP) .
	@touch $@

.venv/installed-%: pyproject.toml | .venv/bin/python
	@echo "Installing the packages and the extra '$*' into .venv (some minutes the first time)"
	$(PIP) '.[$*]'
	@touch $@ .venv/installed
