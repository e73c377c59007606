# Two commands for a newcomer: `make demo` and `make test`. Everything stays in .venv, build/ and demo-result/.
PYTHON ?= python3
SHELL = /bin/bash
PIP = .venv/bin/python -m pip --disable-pip-version-check

.PHONY: demo test lint matrix fuzz site docs bench clean

# Installed once, and again when the dependencies change.
.venv/installed: pyproject.toml
	$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11) and 'robolaser needs Python 3.11 or newer: make PYTHON=python3.12 demo')"
	$(PYTHON) -m venv .venv
	$(PIP) install --quiet --editable .
	touch $@

.venv/developing: .venv/installed requirements-dev.txt requirements-test.txt
	$(PIP) install --quiet --editable '.[robots]' --requirement requirements-dev.txt
	touch $@

# From images of a real laser stripe and the robot's poses to a calibrated scanner.
demo: .venv/installed
	rm -rf demo-result
	.venv/bin/robolaser extract examples/etna-s2 --output demo-result/points
	.venv/bin/robolaser calibrate demo-result/points --with laser_roll --output demo-result/calibration

# Exact versions in an environment of their own, so that nobody's release can break it.
build/lint/installed: requirements-lint.txt
	$(PYTHON) -m venv --clear build/lint
	build/lint/bin/python -m pip --disable-pip-version-check install --quiet --requirement requirements-lint.txt
	touch $@

lint: build/lint/installed
	build/lint/bin/ruff check .
	build/lint/bin/ruff format --check .
	build/lint/bin/mypy
	build/lint/bin/lint-imports

# A third of the time is waiting for arms, cameras and processes: three files at a time keep two cores busy.
# build/durations.txt says what took long.
test: lint .venv/developing
	@mkdir -p build
	.venv/bin/python -m compileall -q robolaser  # else each program that a test starts compiles it for itself
	set -o pipefail; .venv/bin/pytest -n 3 --dist loadfile --durations 25 --junitxml build/durations.xml | tee build/durations.txt

# Python 3.11 to 3.13, newest and lowest declared versions, each from a built wheel in a fresh environment. Takes an hour.
matrix: .venv/developing
	.venv/bin/python .ci/matrix.py

# Generated input for parsers and arms, thousands of examples each, other ones each time, and a thousand bad days of
# arms. Takes an hour and more; stop it at any time.
fuzz: .venv/developing
	GENERATED=long .venv/bin/pytest $$(find tests -name 'test_generated_*.py') tests/cell/test_soak.py

.venv/documenting: .venv/developing
	$(PIP) install --quiet --editable '.[docs]'
	touch $@

# The pages with their links checked, below site/.
site: .venv/documenting
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --strict --quiet

docs: site
	.venv/bin/python docs/run_code_blocks.py

# What needs nothing beside the repository; benchmarks/*/README.md say how to run each, and the others.
bench: .venv/developing
	for one in whole rcga stripe coverage paper; do OMP_NUM_THREADS=1 .venv/bin/python benchmarks/$$one/run.py || exit 1; done

clean:
	rm -rf .venv build dist site demo-result
