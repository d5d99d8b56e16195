# make demo        make the environment, fit the example, say where the report is
# make test        make the environment, run all tests
# make quick       the tests that are not slow: a minute and a half, for while one works
# make check       format, lint and types
# make docs        the documentation, in site/index.html
# make gallery     the pictures of the gallery, anew
# make benchmark   measure speed and memory against the stated targets

VENV := .venv
PYTHON ?= $(shell for p in python3.13 python3.12 python3.11 python3 python3.14; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && { echo $$p; break; }; done)
READY := $(VENV)/ready
PAGES := $(VENV)/pages

.PHONY: demo test quick check docs gallery benchmark clean

demo: $(READY)
	@$(VENV)/bin/diffwhitted fit examples/three_spheres.toml --target examples/three_spheres_antialiased.exr \
		--free 'glass.k_*' --free 'mirror.k_[adhs]' --free 'green.k_[adhs]' --free '*.phong_exponent' \
		--truth examples/three_spheres_truth.toml --out demo-output

test: $(READY)
	$(VENV)/bin/python -m pytest -q -n 2 --dist loadfile --no-loadscope-reorder --durations=15

quick: $(READY)
	$(VENV)/bin/python -m pytest -q -n 2 --dist loadfile --no-loadscope-reorder -m "not slow"

check: $(READY)
	$(VENV)/bin/ruff format --check
	$(VENV)/bin/ruff check
	$(VENV)/bin/pyright --pythonpath $(VENV)/bin/python

docs: $(PAGES)
	$(VENV)/bin/python docs/generated.py
	$(VENV)/bin/zensical build --strict
	@echo "site/index.html"

gallery: $(READY)
	$(VENV)/bin/python docs/make_gallery.py

benchmark: $(READY)
	$(VENV)/bin/python -m benchmarks

$(READY): pyproject.toml
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer is needed: sudo apt-get install python3 python3-venv"; exit 1; }
	@test -d $(VENV)/bin || $(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); \
		echo "The venv module of $(PYTHON) is missing: sudo apt-get install python3-venv, then try again"; exit 1; }
	$(VENV)/bin/python -m pip install -qq --disable-pip-version-check --upgrade pip
	$(VENV)/bin/python -m pip install -qq --disable-pip-version-check --editable '.[test,check]'
	@touch $@

$(PAGES): $(READY)
	$(VENV)/bin/python -m pip install -qq --disable-pip-version-check --editable '.[docs]'
	@touch $@

clean:
	rm -rf $(VENV) .cache demo-output site
