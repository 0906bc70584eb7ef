# make demo: the main job on a real part. make test: all tests. Both set up what is missing, once.

PART := openamr-motor-bracket
OUT := out
# Fixtures whose mesh does not meet every fact yet.
UNMET := mesh::rib_partial_fillet

.PHONY: all demo test fixtures check clean

all: demo

demo: .venv/.run-ready
	cargo build --release --locked
	mkdir -p $(OUT)
	tools/with-tools.sh target/release/midshell mesh examples/parts/$(PART).step \
		-o $(OUT)/$(PART).vtu -o $(OUT)/$(PART).inp -o $(OUT)/$(PART).bdf -o $(OUT)/$(PART).msh \
		--json $(OUT)/$(PART).json --timings

test: .venv/.test-ready
	tools/with-tools.sh cargo test --locked --no-fail-fast --lib --bins \
		--test architecture --test attempts --test bad_input --test bad_solids --test cli --test import
	tools/with-tools.sh cargo test --locked --no-fail-fast --test export
	tools/with-tools.sh cargo test --locked --no-fail-fast --test fixtures -- solid:: ideal:: defect:: mesh:: $(addprefix --skip ,$(UNMET))

# Every fixture, moved, scaled, reordered and threaded too: not all of them pass yet, see the State table of the README.
fixtures: .venv/.test-ready
	tools/with-tools.sh cargo test --locked --no-fail-fast --test fixtures --test export

check:
	.ci/run

.venv/.run-ready: tools/setup.sh tools/requirements-run.txt tools/requirements-optional.txt
	tools/setup.sh run

.venv/.test-ready: .venv/.run-ready tests/python/requirements.txt
	tools/setup.sh test

clean:
	cargo clean
	rm -rf $(OUT) .venv
