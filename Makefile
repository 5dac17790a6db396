# Two commands do everything on a fresh machine: make book, make test.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
JB     := build . --path-output ../.. --all --config book/_config.yml --toc book/_toc.yml \
          -W -n --keep-going
BOOKS  := $(shell find notebooks -name '*.ipynb' -not -path '*/.ipynb_checkpoints/*')

# Kept bytecode, whatever the shell says: without it each process compiles every import anew.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: book page look test lint check lab bench record lock clean help
help:                     ## list the commands
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/' | expand -t 10

# Each notebook runs once, for pages and tests alike; only what a change can reach runs again.
book: $(VENV)/.installed  ## set up, execute what changed, build the HTML strictly
	$(BIN)/python book/execute.py --assemble
	cd _build/source && $(CURDIR)/$(BIN)/jupyter-book $(JB)
	@echo; echo "The book is at file://$(CURDIR)/_build/html/index.html"

page: $(VENV)/.installed  ## build one page, not strictly: make page P=notebooks/walker/steps.ipynb
	$(BIN)/python book/page.py $(P)

look: $(VENV)/look/.installed ## look at every built page in Chromium, wide and narrow, light and dark
	$(VENV)/look/bin/python checks/look.py

test: $(VENV)/.installed  ## set up, run every test and doctest, and the notebooks that changed
	$(BIN)/python book/execute.py
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 \
	    $(BIN)/python -m pytest -n 2 --dist worksteal -p no:nbmake tests mobility_imu

lint: $(VENV)/.installed  ## style, types, spelling, stripped notebooks
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/codespell
	$(BIN)/nbstripout --verify --keep-id $(BOOKS)

check: $(VENV)/.installed ## slow checks, half an hour: all of them, or make check STEP=wheel
	$(BIN)/python checks/check.py $(STEP)

lab: $(VENV)/.installed   ## open the notebooks in JupyterLab
	$(BIN)/jupyter lab notebooks

bench: $(VENV)/.installed ## measure speed as ratios against named peers
	$(MAKE) --no-print-directory $(VENV)/gaitmap/.installed || echo "gaitmap: not installed"
	for b in benchmarks/bench_*.py; do $(BIN)/python $$b || exit 1; done

# A peer with dependencies of its own gets its own environment.
$(VENV)/gaitmap/.installed: benchmarks/requirements-gaitmap.txt
	$(PYTHON) -m venv $(VENV)/gaitmap
	$(VENV)/gaitmap/bin/python -m pip install --disable-pip-version-check --quiet -r $<
	touch $@

$(VENV)/look/.installed: checks/requirements-look.txt
	$(PYTHON) -m venv $(VENV)/look
	$(VENV)/look/bin/python -m pip install --disable-pip-version-check --quiet -r $<
	touch $@

record: $(VENV)/.installed ## compute again what data/recorded keeps (an hour)
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m mobility_imu.reproduction.recorded

lock:                     ## renew constraints.txt: the newest versions within the bounds, all extras
	rm -rf _build/lock && $(PYTHON) -m venv _build/lock
	_build/lock/bin/python -m pip install --disable-pip-version-check --quiet -e ".[dev,cluster]"
	_build/lock/bin/python -m pip freeze --exclude-editable > constraints.txt

clean:                    ## forget built pages, executed notebooks and wheels
	rm -rf _build build dist

# uv installs what pip would, in a tenth of the time. Where it can't be had or fails, and where pip
# has an index of its own, which uv does not read, pip does it.
# Python compiles what is imported; pip would compile everything, one file after the other.
PIP := $(BIN)/python -m pip install --disable-pip-version-check --quiet
UV := $(if $(PIP_INDEX_URL)$(PIP_NO_INDEX),false,$(PIP) "uv>=0.4,<1" 2>/dev/null)
$(VENV)/.installed: requirements.txt constraints.txt pyproject.toml setup.py
	$(PYTHON) -m venv $(VENV)
	$(UV) && $(BIN)/uv pip install --quiet --no-cache --python $(BIN)/python -r requirements.txt || \
	    $(PIP) --no-compile -r requirements.txt
	mkdir -p $(VENV)/etc/ipython
	echo "c.IPKernelApp.log_level = 'ERROR'  # kernels talk to this machine only: no notice of it" \
	    > $(VENV)/etc/ipython/ipython_kernel_config.py
	touch $@
