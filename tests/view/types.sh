#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The viewer's TypeScript has no type error: types.sh ROOT WORK (esbuild only strips the types)
mkdir -p "$2" && cp "$1"/view/* "$2" && cd "$2" || exit 1
npm ci --ignore-scripts --no-audit --no-fund --loglevel=error && node_modules/.bin/tsc --noEmit
