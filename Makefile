# Every target sets up what it needs in .venv; it takes Python >= 3.11 and a Rust toolchain.
PYTHON ?= python3
VENV := .venv
# placo needs an older pinocchio than the other benches.
RATES := .venv-rates
BIN := $(VENV)/bin
LEFT_OUT := not all could be installed (see above); the comparisons leave out what is missing and say so
BENCHES := peers native faults rates manipulability singular_poses predictions stability identify instructions
BENCH = $(BIN)/python
RUST := $(shell find crates Cargo.toml -name '*.rs' -o -name 'Cargo.toml')

.PHONY: run test bench $(BENCHES:%=bench-%) lint wheel clean

run: $(VENV)/develop $(VENV)/extras ## the main job: a rocking RAVEN held by PD + dynamic gravity
	$(BIN)/ravengc run

test: $(VENV)/develop $(VENV)/extras $(VENV)/test $(VENV)/peers ## everything that must hold
	cargo test -p gravcomp
	cargo check -p gravcomp --no-default-features
	$(BIN)/python -m pytest -n auto --dist worksteal

bench: $(VENV)/develop $(VENV)/extras $(VENV)/peers $(VENV)/native $(RATES)/ready ## the timing budget, and the peers in interleaved runs
	cargo bench -p gravcomp
	$(MAKE) --keep-going --jobs=1 $(BENCHES:%=bench-%)

$(BENCHES:%=bench-%): bench-%: ## one of them; `make bench` has set up what it needs
	$(BENCH) benches/$*.py $(OPTIONS)

bench-rates: BENCH := PYTHONPATH=python $(RATES)/bin/python
bench-stability: OPTIONS := --cases 1000

lint: $(VENV)/develop $(VENV)/extras $(VENV)/lint ## one policy for both languages
	cargo fmt --all --check
	cargo clippy --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --no-deps -p gravcomp
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	cd $(VENV) && bin/python -m mypy.stubtest ravengc._core

wheel: $(VENV)/tools ## dist/*.whl, for any processor of this machine's kind
	$(BIN)/maturin build --release --out dist

clean:
	rm -rf $(VENV) $(RATES) target dist

$(VENV)/tools: Makefile
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip "maturin>=1.9,<2"
	touch $@

$(VENV)/develop: $(VENV)/tools pyproject.toml $(RUST)
	$(BIN)/maturin develop --release --quiet
	touch $@

$(VENV)/extras: $(VENV)/develop pyproject.toml
	$(BIN)/python -m pip install --quiet "mujoco>=3.3" "matplotlib>=3.8" "rosbags>=0.10" "distributed>=2024.1" "pyarrow>=15" "viser>=1.1" \
		"clarabel>=0.9" "scipy>=1.11" "sympy>=1.13"
	touch $@

$(VENV)/test: $(VENV)/tools pyproject.toml
	$(BIN)/python -m pip install --quiet --group test
	touch $@

$(VENV)/lint: $(VENV)/tools pyproject.toml
	$(BIN)/python -m pip install --quiet --group lint
	touch $@

# What this machine cannot have is tried again the next time.
$(VENV)/peers: $(VENV)/tools pyproject.toml
	if $(BIN)/python -m pip install --quiet --group peers; then touch $@; else echo "$@: $(LEFT_OUT)"; fi

$(VENV)/native: $(VENV)/tools pyproject.toml
	if $(BIN)/python -m pip install --quiet --group native; then touch $@; else echo "$@: $(LEFT_OUT)"; fi

$(RATES)/ready: Makefile pyproject.toml
	$(PYTHON) -m venv $(RATES)
	$(RATES)/bin/python -m pip install --quiet --upgrade pip "numpy>=1.26" "rich>=13"
	if $(RATES)/bin/python -m pip install --quiet --group rates; then touch $@; else echo "$@: $(LEFT_OUT)"; fi
