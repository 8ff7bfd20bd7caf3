PYTHON ?= python3
BIN := .venv/bin

.PHONY: run test fuzz draws check pythons docs pictures verified format clean

run: .venv/.ready
	$(BIN)/ehamj run

test: .venv/.ready
	$(BIN)/python -m pytest

fuzz: .venv/.ready
	PYTHONPATH=tests $(BIN)/python -m fuzz $(FUZZ)

draws: .venv/.ready
	PYTHONPATH=tests $(BIN)/python -m draws $(DRAWS)

check: .venv/.ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

pythons: .venv/.ready
	.ci/wheel --all

docs: .venv/.ready
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict
	@echo "The site is in site/; open site/index.html, with no server and no network."

verified: .venv/.ready
	PYTHONPATH=docs/_build $(BIN)/python -m handbook.verified

pictures: .venv/.ready
	$(BIN)/python docs/_build/pictures.py $(PICTURES)

format: .venv/.ready
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf .venv runs dist build site .mypy_cache .ruff_cache .pytest_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

.venv/.ready: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "ehamj needs Python 3.11 or newer; try: make PYTHON=python3.12")'
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev,docs]'
	touch $@
