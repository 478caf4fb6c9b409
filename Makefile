# `make demo` and `make test` are all a fresh machine needs: both make .venv first.
SHELL := bash
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready
PIP := $(BIN)/python -m pip --disable-pip-version-check install
# The files go to the cores one by one: what the tests of a file share is made once. One thread of BLAS for each: more
# would wait for cores that the other workers use.
PYTEST := OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest
SPREAD := -n auto --dist loadfile

.PHONY: demo gallery test slow kills timing warm lint pictures precision calibrate figures notebooks docs clean

demo: $(READY)
	@echo "mbsd3d: running the demos; figures, pages and data go to out/"
	@$(BIN)/mbsd3d demo --all --out out

gallery: $(READY)
	@$(BIN)/mbsd3d gallery --out site

test: warm
	$(PYTEST) $(SPREAD) -m "not slow and not timing"

slow: warm
	$(PYTEST) $(SPREAD) -m "slow and not timing"

# Everything that is killed in `make slow`, at the count of moments that SECURITY.md states.
kills: warm
	MBSD3D_TEST_KILLS=30 $(PYTEST) -m slow tests/slow/test_kills.py tests/slow/test_killed_commands.py

timing: warm
	$(BIN)/python -m pytest -m timing

# Compiled once here, and not by each worker.
warm: $(READY)
	@$(BIN)/mbsd3d warmup

# Two other roundings than this processor's, for all tests of numbers: the quick suite without these files.
.PHONY: test-generic test-perturbed
NOT_NUMBERS := browser camera cli demos drawing engine_drawings engine_pages errors film files gltf importers live \
  model_files mujoco_refusals pictures player plots precision report shape_files style sweep_losses view
NUMBERS := -m "not slow and not timing" $(NOT_NUMBERS:%=--ignore-glob='*/test_%.py')
# No fused multiply-add, no vectors, the BLAS of an old processor; kernels compiled so have a folder of their own.
GENERIC := NUMBA_CPU_NAME=generic NUMBA_CPU_FEATURES= OPENBLAS_CORETYPE=Nehalem \
  MBSD3D_CACHE="$${XDG_CACHE_HOME:-$$HOME/.cache}/mbsd3d-generic"

test-generic: $(READY)
	$(GENERIC) $(BIN)/mbsd3d warmup
	$(GENERIC) $(PYTEST) $(SPREAD) $(NUMBERS)

# Masses and inertias differ by a few units in the last place from what the tests give: tests/helpers/noise.py. The workers of
# sweeps are processes of their own and have no noise.
test-perturbed: $(READY)
	MBSD3D_TEST_NOISE=1e-15 $(PYTEST) $(SPREAD) $(NUMBERS) --ignore-glob='*/test_sweep.py'

pictures: $(READY)
	$(BIN)/python docs/make_pictures.py docs/pictures
	$(BIN)/python docs/make_joint_pictures.py docs/pictures/joints
	$(BIN)/python docs/make_page_pictures.py
	$(BIN)/python docs/make_example_pictures.py
	$(BIN)/python docs/make_demo_pictures.py
	$(BIN)/python docs/make_notebooks.py

# All films of the gallery on one sheet, to be looked at: out/contact.png. Names the films that show too little.
.PHONY: contact
contact: $(READY)
	$(BIN)/python docs/make_contact_sheet.py out/contact.png

# The lessons of docs/teaching as notebooks.
notebooks: $(READY)
	$(BIN)/python docs/make_notebooks.py

# The pages of docs/ as a site that needs no network: out/docs/index.html.
docs: $(READY)
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs out/docs

# The same pages as one PDF with contents, map and index, printed by Chromium: out/book/mbsd3d.pdf.
.PHONY: book
book: $(READY)
	$(BIN)/python docs/make_book.py out/book

precision: $(READY)
	$(BIN)/python -m validation.benchmark --part precision --out out/benchmark --pictures docs/pictures

# Thousands of runs with known truth against what the certificate says of them; the table of docs/theory/certificate.md.
# A thousand random mechanisms written in the formats of other programs and read back, a thousand models of MuJoCo, and a
# thousand mechanisms with stops and freewheels against equations of their own. Two hundred fits, whose intervals must hold
# the truth as often as they say.
calibrate: warm
	$(BIN)/python -m validation.calibration --out out/calibration --docs
	MBSD3D_TEST_FITS=200 $(PYTEST) -m slow tests/sweeps/test_fit.py
	MBSD3D_TEST_EXPORTED_MODELS=1000 $(PYTEST) $(SPREAD) -m slow tests/slow/test_exported_models.py
	MBSD3D_TEST_RANDOM_MJCF=1000 $(PYTEST) $(SPREAD) tests/files/test_random_mjcf.py
	MBSD3D_TEST_RANDOM_MACHINES=1000 $(PYTEST) $(SPREAD) -m slow tests/slow/test_random_machines.py

# Every picture and table of README.md and docs/ from measurement, on an idle machine: ten minutes.
figures: pictures precision
	$(BIN)/python -m validation.benchmark --part speed --out out/benchmark
	$(BIN)/python -m validation.benchmark.texts out/benchmark

# What the short tests run of each file: kernels as plain Python, all else compiled as users have it. One report of both,
# out/coverage/index.html; there is no threshold.
COVERED := --cov=mbsd3d --cov=bicycle --cov=engines --cov=validation --cov-append --cov-report=
KERNEL_TESTS := tests/kernels tests/equations
.PHONY: coverage
coverage: warm
	rm -f .coverage
	NUMBA_DISABLE_JIT=1 $(PYTEST) $(SPREAD) -m "not slow and not timing" $(COVERED) $(KERNEL_TESTS)
	$(PYTEST) $(SPREAD) -m "not slow and not timing" $(COVERED)
	$(BIN)/python -m coverage html -q -d out/coverage
	$(BIN)/python -m coverage report --skip-covered --sort=cover | tail -40

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	@mkdir -p out && $(BIN)/python tests/types/blocks.py README.md > out/readme_blocks.py
	$(BIN)/mypy
	$(BIN)/mypy out/readme_blocks.py

clean:
	rm -rf .venv out site build *.egg-info .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# The stamp is younger than both files once they are installed, so the next call has nothing to do.
$(READY): requirements.txt pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || \
	  { echo "mbsd3d needs Python 3.11 or newer: install one and call 'make PYTHON=python3.12 $(MAKECMDGOALS)'"; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || \
	  { echo "this Python has no venv module: install it (Debian, Ubuntu: apt install python3-venv) and call make again"; exit 1; }
	@test -x $(BIN)/pip || { echo "mbsd3d: making the environment .venv"; $(PYTHON) -m venv .venv; }
	@echo "mbsd3d: installing $$(grep -vc '^#' requirements.txt) packages into .venv, once: one to three minutes"
	@set -o pipefail; $(PIP) -r requirements.txt | while read -r word name rest; do case $$word in \
	  Collecting|Processing|Downloading|Using) printf '\r  %-70.70s' "$${name##*/}" ;; \
	  Installing) printf '\r  %-70s\n' "unpacking ..." ;; \
	esac; done
	@$(PIP) -q --no-deps --no-build-isolation -e .
	@echo "mbsd3d: installed"
	@touch $@
