# SPDX-License-Identifier: GPL-3.0-or-later
# `make demo` and `make test` set up what they need, once, and then do their job.

SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
.PHONY: help setup demo test evidence mutation lint types pytest drawn bench peers pictures site format clean

BIN := .venv/bin
READY := .venv/ready
TESTS_READY := .venv/ready-for-tests
EVIDENCE_READY := .venv/ready-for-evidence
ARGS ?=
# One more than there are processors: some tests wait for hosts that run in real time.
WORKERS ?= $(shell expr $$(getconf _NPROCESSORS_ONLN) + 1)
SIZE ?= evidence
N ?= 20

help: ## list what there is to make
	@grep -hE '^[a-z]+:.*##' Makefile | sed -E 's/:[^#]*## /\t/' | expand -t 10

setup: $(TESTS_READY) ## Debian packages where missing, .venv, the simulator's native part (LINUXCNC=1: and LinuxCNC; EVIDENCE=1: and other judges)

# What is asked for is looked for even where all else is ready.
ifneq ($(LINUXCNC)$(EVIDENCE),)
export LINUXCNC EVIDENCE
.PHONY: $(TESTS_READY)
endif

MADE_OF := pyproject.toml tools/setup.sh $(wildcard sim/native/*.[ch] sim/native/*/*.[ch])

# What the commands need.
$(READY): $(MADE_OF)
	@tools/setup.sh
	@touch $@

# And what only the tests need: checkers of C and Python, Arduino's core, hosts, a browser.
$(TESTS_READY): $(MADE_OF)
	@TESTS=1 tools/setup.sh
	@touch $(READY) $@

# And what only the whole evidence needs: other simulators, a second compiler, OctoPrint, LinuxCNC.
$(EVIDENCE_READY): $(TESTS_READY)
	@EVIDENCE=1 LINUXCNC=1 tools/setup.sh
	@touch $@

demo: $(READY) ## the whole way for the chamber: generate, compile, simulate, compare with the model
	@$(BIN)/heatwright verify spec/examples/chamber.yaml

test: lint types pytest ## what must hold before a change is shared (ARGS="-k name" for some of it)

evidence: export SUITE_SIZE := $(SIZE)
evidence: $(EVIDENCE_READY) pytest ## all the evidence, in an hour and a half (SIZE=full: with all its numbers, in hours)

lint: $(TESTS_READY)
	@echo "ruff"
	@$(BIN)/ruff check --quiet .
	@$(BIN)/ruff format --quiet --check .

types: $(TESTS_READY)
	@echo "mypy"
	@$(BIN)/mypy | sed 's#^\.typing/heatwright/##'
	@$(BIN)/mypy tools/*.py | sed 's#^\.typing/heatwright/##'

pytest: $(TESTS_READY)
	@$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal $(ARGS)

mutation: $(TESTS_READY) ## break the generated C in every small way (ARGS="host/pid_hold --file guard_air.c")
	@cd tests && ../$(BIN)/python -m mutation $(ARGS)

drawn: $(TESTS_READY) ## draw machines from nearly the whole language, and verify each (N=200; SUITE_SIZE=full: from all of it)
	@cd tests && ../$(BIN)/python -m any_machine --count $(N) $(ARGS)

bench: $(READY) ## how fast it is, in ratios (ARGS=--page: and docs/benchmarks.md, with its picture)
	@$(BIN)/python tools/bench $(ARGS)

peers: $(READY) ## what bench compares with: ESPHome and avr8js, in build/judges
	@PEERS=1 tools/setup.sh

pictures: $(TESTS_READY) ## the pictures of README and documents, in docs/pictures
	@$(BIN)/python tools/architecture.py
	@$(BIN)/python tools/pictures.py

site: $(TESTS_READY) ## the documents as a site, in build/site
	@$(BIN)/python tools/site.py

format: $(TESTS_READY) ## let ruff lay out the code
	@$(BIN)/ruff check --quiet --fix .
	@$(BIN)/ruff format --quiet .

clean: ## remove everything that make made here
	@rm -rf .venv .typing .pytest_cache .mypy_cache .ruff_cache .hypothesis build dist *.egg-info
