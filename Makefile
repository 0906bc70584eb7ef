# make demo: the main job on a real part. make test: all tests. Both set up what is missing, once.

PART := openamr-motor-bracket
OUT := out

.PHONY: all demo test check clean

all: demo

demo: .venv/.run-ready
	cargo build --release --locked
	mkdir -p $(OUT)
	tools/with-tools.sh target/release/midshell mesh examples/parts/$(PART).step \
		-o $(OUT)/$(PART).vtu -o $(OUT)/$(PART).inp -o $(OUT)/$(PART).bdf -o $(OUT)/$(PART).msh \
		--json $(OUT)/$(PART).json --timings

# One group after the other; a failure in one does not keep the rest from running.
test: .venv/.test-ready
	@status=0; \
	for group in \
		'--lib --bins --test architecture --test attempts --test audit --test bad_facets --test bad_input --test bad_solids --test beside_gmsh --test cli --test facets --test import --test keep_edge --test sizes --test small --test washers' \
		'--test export' \
		'--test fixtures'; \
	do \
		tools/with-tools.sh cargo test --locked --no-fail-fast $$group || status=1; \
	done; \
	exit $$status

check:
	.ci/run

.venv/.run-ready: tools/setup.sh tools/requirements-run.txt tools/requirements-optional.txt
	tools/setup.sh run

.venv/.test-ready: .venv/.run-ready tests/python/requirements.txt
	tools/setup.sh test

clean:
	cargo clean
	rm -rf $(OUT) .venv
