# make setup     a virtual environment with everything, and OpenGL libraries where missing
# make snapshot  snapshot.png of the built-in scene, without a display
# make view      fly through it in a window
# make test      all tests            make hard-cases   only the scenes known to be hard
# make test-slow  those that take minutes: 10^8 rays, thousands of frames, long flights
# make fuzz      damaged files by the thousand; FUZZ_SEED and FUZZ_COUNT say which, how many
# make bench     accuracy against time, into bench/; an hour a scene on two cores, or minutes
#                with BENCH_FLAGS=--quick
# make bench-passes  milliseconds of every pass, beside the published method
# make bench-estimators  error of visibility against time, every estimator
# make bench-effects  what planning saves in each scene, against the full pipeline
# make bench-fidelity  how far materials are from path tracing; MODELS="a.glb b.glb"
# make bench-light  how far gi and bounce are from path tracing; SCENES="room-1 model.glb"
# make bench-light-cost  what gi takes: time to prepare a scene, memory; SCENES="stairs a.glb"
# make bench-rays  rays per second of the reference tracers
# make bench-large  models of up to ten million triangles: first picture, hierarchy, memory
# make bench-motion  errors, flicker, lag and ghosts in motion; MOTION_FLAGS=--quick
# make bench-walk  the temporal error of gi along a walk, against path tracing; SCENES="stairs"
# make bench-python  processor time that Python takes to issue a frame
# make bench-input  milliseconds from a key or the mouse to its answer in the window
# make bench-gpu  tests, pass times, rays and images on a GPU, into bench/gpu; eight minutes
# make bench-peers  VTK, three.js and ours in one room; THREE=DIR: of the npm package three
# make bench-presets  the ladder of presets, some minutes a scene; SCENES="stairs a.glb"
# make bench-against  time of frames over those of COMMIT=398b93d; SCENES="corner stairs"
# make bench-promises  whether --budget-ms and --max-error keep what they promise
# make pictures  the pictures of README and docs/
# make lint      ruff, mypy and every shader
# make clean     remove what can be made again, .venv excepted
#
# Overridable: PYTHON (makes the venv), VENV (where), EXTRAS (which), or PY to use an
# interpreter that has everything already: make test PY=python3

PYTHON ?= python3
VENV ?= .venv
EXTRAS ?= all
SCENE ?= cornell_meso
BENCH_SCENES ?= cornell_meso courtyard stairs benchmarks/metals.toml
BENCH_FLAGS ?=
FUZZ_SEED ?= 0
FUZZ_COUNT ?= 1000
GPU_FLAGS ?=
SCENES ?=
COMMIT ?= HEAD
AGAINST_FLAGS ?=
MOTION_FLAGS ?=
THREE ?=

ifeq ($(origin PY), undefined)
PY := $(VENV)/bin/python
READY := $(VENV)/.ssdo_gl-ready
endif

.DELETE_ON_ERROR:
.PHONY: setup snapshot view test test-slow fuzz hard-cases pictures bench bench-passes bench-estimators bench-effects bench-fidelity bench-light bench-light-cost bench-rays bench-large bench-motion bench-walk bench-python bench-input bench-peers bench-presets bench-promises bench-against bench-gpu lint style clean

setup: $(READY)

# Holds as long as the dependencies do not change; the install is editable, so code may.
$(VENV)/.ssdo_gl-ready: pyproject.toml .ci/setup .ci/packages
	PYTHON="$(PYTHON)" VENV="$(VENV)" EXTRAS="$(EXTRAS)" .ci/setup
	@touch $@

snapshot: $(READY)
	$(PY) -m ssdo_gl $(SCENE) --snapshot snapshot.png

view: $(READY)
	$(PY) -m ssdo_gl $(SCENE)

# A process of tests keeps one core busy. Shares change hands late: the tests of a file have
# fixtures in common.
test: $(READY)
	$(PY) -m pytest -q -n auto --maxprocesses 4 --dist worksteal

test-slow: $(READY)
	$(PY) -m pytest -q -m slow

fuzz: $(READY)
	$(PY) -m pytest -q -m fuzz tests/fuzz --fuzz-seed $(FUZZ_SEED) --fuzz-count $(FUZZ_COUNT)

hard-cases: $(READY)
	$(PY) -m pytest -q tests/hard_cases

bench: $(READY)
	for scene in $(BENCH_SCENES); do \
		$(PY) -m ssdo_gl $$scene --bench bench/$$(basename $$scene .toml) $(BENCH_FLAGS) || exit 1; \
	done

bench-passes: $(READY)
	$(PY) -m benchmarks.pass_times $(SCENE)

bench-estimators: $(READY)
	$(PY) -m benchmarks.all_estimators bench/estimators $(ESTIMATOR_FLAGS)

bench-effects: $(READY)
	$(PY) -m benchmarks.planning_gain $(SCENES)

bench-fidelity: $(READY)
	$(PY) -m benchmarks.render_fidelity $(MODELS)

bench-light: $(READY)
	$(PY) -m benchmarks.all_light $(SCENES)

bench-light-cost: $(READY)
	$(PY) -m benchmarks.far_field_cost $(SCENES)

bench-rays: $(READY)
	$(PY) -m benchmarks.ray_speed

bench-large: $(READY)
	$(PY) -m benchmarks.large $(COUNTS)

bench-motion: $(READY)
	$(PY) -m benchmarks.motion_errors $(MOTION_FLAGS)

bench-walk: $(READY)
	$(PY) -m benchmarks.walk_errors $(SCENES)

bench-python: $(READY)
	$(PY) -m benchmarks.python_time $(SCENE)

bench-input: $(READY)
	$(PY) -m benchmarks.input_latency $(SCENE)

bench-gpu: $(READY)
	$(PY) -m benchmarks.gpu bench/gpu $(GPU_FLAGS)

bench-peers: $(READY)
	$(PY) -m benchmarks.peers bench/peers $(if $(THREE),--three $(THREE))

bench-presets: $(READY)
	$(PY) -m benchmarks.rungs bench/presets $(SCENES)

bench-against: $(READY)
	$(PY) -m benchmarks.against_commit $(COMMIT) $(SCENES) $(AGAINST_FLAGS)

bench-promises: $(READY)
	$(PY) -m benchmarks.promises

pictures: $(READY)
	$(PY) .github/pictures/make_pictures.py

lint: style
	$(PY) -m pytest -q -n auto --maxprocesses 4 tests/shaders/test_lint.py

style: $(READY)
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy

clean:
	rm -rf build dist bench snapshot.png .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find ssdo_gl tests -name __pycache__ -type d -prune -exec rm -rf {} +
