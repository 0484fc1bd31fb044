# One entry for people: each target sets up what it needs, from Python and make alone.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

DOCS := $(VENV)/.docs

.PHONY: docs help demo test check format paper bench torture friction mutants verify release clean

help:  ## list the targets
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12

$(READY): pyproject.toml constraints.txt setup.py $(wildcard tendon_cli/kernel/*.[chp]*)
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "tendon needs Python 3.11 or later; set PYTHON=..."; exit 1; }
	@$(PYTHON) -m venv $(VENV)
	@$(PIP) --upgrade pip
	@echo "Setting up $(VENV), about a minute ..."
	@PYTHONWARNINGS="ignore:Editable installation" $(PIP) -e . --group dev
	@$(BIN)/python -m compileall -q tendon_cli  # as pip does with what it installs; many containers have Python not do it
	@touch $@

demo: $(READY)  ## sweep the suit of the README and answer for it, then run a study of the paper
	@$(BIN)/tendon sweep configs/suit.toml --overwrite
	@echo
	@$(BIN)/tendon design configs/suit.toml --overwrite
	@$(BIN)/tendon report results/suit-design >/dev/null
	@$(BIN)/tendon sweep configs/paper/fig07.toml --overwrite --quiet
	@echo; echo "Where tendons go slack: results/suit/slack_map.png"
	@echo "The answer as a page:   results/suit-design/report.html"
	@echo "A run of the paper:     results/fig07"
	@echo "The documentation:      make docs, then docs/_build/index.html"

test: $(READY)  ## run all tests
	@echo "Running all tests, about six minutes on two cores ..."
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -q -n auto --dist worksteal -m "not torture"

check: $(READY)  ## lint and check types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(READY)  ## format the code
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

$(DOCS): $(READY)
	@echo "Installing what builds the pages ..."
	@PYTHONWARNINGS="ignore:Editable installation" $(PIP) -e '.[docs]' --group dev
	@touch $@

docs: $(DOCS)  ## make the figures of the documentation and build it, to be read in docs/_build/index.html
	@echo "1 of 3: making the figures of the pages, about a minute"
	@$(BIN)/python docs/figures.py
	@echo "2 of 3: building the pages"
	@$(BIN)/python -m sphinx -q -W --keep-going -j auto -b html docs docs/_build
	@echo "3 of 3: looking for signs that cannot be typed, and for links that need the network"
	@! grep -nE '(–|—)(arm|reversal|set|json|[a-z]+-[a-z]+)\b|[“”‘]' docs/_build/*.html || { echo "typographic signs in what is to be typed"; exit 1; }
	@! grep -lE '(<script|<link|<img)[^>]*(src|href)="(https?:)?//' docs/_build/*.html || { echo "these pages need the network"; exit 1; }
	@echo "The documentation: docs/_build/index.html"

paper: $(READY)  ## reproduce the paper into results/paper: every figure, and a check of every finding and claim
	$(BIN)/python -m verification.paper

bench: $(READY)  ## measure ratios against the machine's limit, an expert's script and C; BENCH=--quick for a look
	$(BIN)/python -m benchmarks.bench $(BENCH)

TORTURE := $(VENV)/.torture

$(TORTURE): $(READY)
	@$(PIP) --group readers --group release
	@$(PIP) --only-binary atheris --group torture || echo "atheris cannot be installed here; what needs it is skipped"
	@touch $@

torture: $(TORTURE)  ## the whole of what the tests sample
	$(BIN)/python -m pytest -q -n auto -m torture

friction: $(READY)  ## fit every simulated rig, table in verification/friction.md; SEEDS=40 for a look
	@nice $(BIN)/python -m verification.friction_rigs.torture $(SEEDS:%=--seeds %) --write verification/friction.md

mutants: $(READY)  ## put random faults into copies of the package and see whether the tests notice; MUTANTS="--count 60"
	nice $(BIN)/python -m tools.mutants $(MUTANTS)

release: $(READY)  ## build sdist and wheel (manylinux on Linux) into dist/ and check what they hold
	$(PIP) --group release
	rm -rf dist build
	$(BIN)/python -m tools.release dist

clean:  ## remove the environment and caches, never results
	rm -rf $(VENV) $(VERIFY) .mypy_cache .ruff_cache .pytest_cache .hypothesis build dist *.egg-info tendon_cli/kernel/_native.*

VERIFY := .venv-verify
MUJOCO := $(VERIFY)/.ready

$(MUJOCO): pyproject.toml constraints.txt verification/requirements.txt
	@rm -f $@
	@$(PYTHON) -m venv $(VERIFY)
	@pip="$(VERIFY)/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt"; \
	if why=$$($$pip --only-binary mujoco -r verification/requirements.txt 2>&1); then $$pip -e . && touch $@; \
	else echo "skipped, nothing was compared: MuJoCo cannot be installed here ($$(echo "$$why" | grep -m1 ERROR))"; fi

verify: $(MUJOCO)  ## compare with MuJoCo, an engine nobody here wrote
	@test ! -e $(MUJOCO) || $(VERIFY)/bin/python -m verification.against_mujoco
	@test ! -e $(MUJOCO) || $(VERIFY)/bin/python -m verification.excursions
