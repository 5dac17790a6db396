# Two commands do everything on a fresh machine: make book, make test.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
JB     := build . --all --config book/_config.yml --toc book/_toc.yml -W -n --keep-going
CODE   := $(shell find mobility_imu data book/_ext -type f -not -path '*/__pycache__/*')
BOOKS  := $(shell find notebooks -name '*.ipynb' -not -path '*/.ipynb_checkpoints/*')

.PHONY: book test lint lab bench lock clean help
help:                     ## list the commands
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/' | expand -t 10

book: _build/.source      ## set up, execute every notebook, build the HTML strictly
	$(BIN)/jupyter-book $(JB)
	@echo; echo "The book is at file://$(CURDIR)/_build/html/index.html"

# The execution cache sees only a notebook's own cells: forget it when package or data change.
_build/.source: $(VENV)/.installed $(CODE)
	rm -rf _build && mkdir -p _build && touch $@

test: $(VENV)/.installed  ## set up, run every test, doctest and notebook
	$(BIN)/python -m pytest -n 2 --nbmake --nbmake-timeout=300 tests mobility_imu notebooks book/index.ipynb

lint: $(VENV)/.installed  ## style, types, spelling, stripped notebooks
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/codespell
	$(BIN)/nbstripout --verify --keep-id $(BOOKS)

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

lock: $(VENV)/.installed  ## renew constraints.txt from this environment
	$(BIN)/python -m pip freeze --exclude-editable > constraints.txt

clean:                    ## forget built pages and executed notebooks
	rm -rf _build

$(VENV)/.installed: requirements.txt constraints.txt pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --disable-pip-version-check --quiet -r requirements.txt
	mkdir -p $(VENV)/etc/ipython
	echo "c.IPKernelApp.log_level = 'ERROR'  # kernels talk to this machine only: no notice of it" \
	    > $(VENV)/etc/ipython/ipython_kernel_config.py
	touch $@
