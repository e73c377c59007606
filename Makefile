# To start: `make demo` and `make test`. All files are written to .venv, build/ and demo-result/.
PYTHON ?= python3
SHELL = /bin/bash
UV = .venv/bin/uv --quiet
INSTALL = $(UV) pip install --python .venv/bin/python
# Libraries are compiled when they are first imported, and not by each program again.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test lint pytest matrix fuzz site docs bench clean

# uv installs in a sixth of pip's time.
.venv/bin/uv:
	$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11) and 'robolaser needs Python 3.11 or newer: make PYTHON=python3.12 demo')"
	$(PYTHON) -m venv .venv
	.venv/bin/python -m pip --disable-pip-version-check install --quiet 'uv>=0.5'

# Installed once, and again after a change of the dependencies.
.venv/installed: pyproject.toml | .venv/bin/uv
	$(INSTALL) --editable .
	touch $@

.venv/developing: .venv/installed requirements-dev.txt requirements-test.txt
	$(INSTALL) --editable '.[robots]' --requirement requirements-dev.txt
	touch $@

# From images of a real laser stripe and the robot's poses to a calibrated scanner.
demo: .venv/installed
	rm -rf demo-result
	.venv/bin/robolaser extract examples/etna-s2 --output demo-result/points
	.venv/bin/robolaser calibrate demo-result/points --with laser_roll --output demo-result/calibration

# Exact versions in a separate environment, so that no new release can break it.
build/lint/installed: requirements-lint.txt | .venv/bin/uv
	$(UV) venv --clear --python .venv/bin/python build/lint
	$(UV) pip install --python build/lint/bin/python --requirement requirements-lint.txt
	touch $@

lint: build/lint/installed
	build/lint/bin/ruff check .
	build/lint/bin/ruff format --check .
	build/lint/bin/mypy
	build/lint/bin/lint-imports

# Tests are collected by one processor: the other one lints meanwhile.
test:
	@$(MAKE) --no-print-directory --jobs 2 lint build/collected.txt
	@$(MAKE) --no-print-directory pytest

# Compiles libraries and tests once, and not in each worker at the same time; errors are shown by the tests.
build/collected.txt: .venv/developing
	@mkdir -p build
	-.venv/bin/pytest --collect-only --quiet > $@

# A third of the time is spent waiting for arms, cameras and processes: three files at a time keep two cores busy.
# build/durations.txt lists the slowest tests.
pytest: build/collected.txt
	set -o pipefail; .venv/bin/pytest -n 3 --dist loadfile --durations 25 --junitxml build/durations.xml | tee build/durations.txt

# Python 3.11 to 3.13, newest and lowest declared versions, each with a built wheel in a fresh environment. Takes an hour.
matrix: .venv/developing
	.venv/bin/python .ci/matrix.py

# Thousands of new random inputs for each parser and arm, and a thousand soak tests of arms with faults. Takes an hour
# or more; it can be stopped at any time.
fuzz: .venv/developing
	GENERATED=long .venv/bin/pytest $$(find tests -name 'test_generated_*.py') tests/cell/test_soak.py

.venv/documenting: .venv/developing
	$(INSTALL) --editable '.[docs]'
	touch $@

# The pages, with their links checked, in site/.
site: .venv/documenting
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --strict --quiet

docs: site
	.venv/bin/python docs/run_code_blocks.py

# The benchmarks that need only the repository; benchmarks/*/README.md give the commands of all.
bench: .venv/developing
	for one in whole rcga stripe coverage paper; do OMP_NUM_THREADS=1 .venv/bin/python benchmarks/$$one/run.py || exit 1; done

clean:
	rm -rf .venv build dist site demo-result
