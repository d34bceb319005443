# SPDX-License-Identifier: Apache-2.0
# A thin front: each line installs what is missing from Debian, builds with CMake's presets, and runs.
# `make` alone builds the program. docs/development.md explains the presets behind it.

CTEST_PARALLEL_LEVEL ?= $(shell nproc)
export CTEST_PARALLEL_LEVEL

.PHONY: build demo test check install format clean

build:
	tools/install-packages build test
	cmake --preset release
	cmake --build --preset release --target sheen

# The whole chain on the sample session, from recorded frames to pictures.
demo: build
	tools/demo

# Every quick test, in a build with asserts.
test:
	tools/install-packages build test
	cmake --workflow --preset dev

# What a change must pass: compilers, sanitizers, linters, fuzz corpora, slow tests.
check:
	.ci/run

install: build
	cmake --build --preset release
	cmake --install build/release $(if $(PREFIX),--prefix $(PREFIX))

format:
	tools/format

clean:
	rm -rf build
