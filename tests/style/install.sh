#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# `cmake --install` puts a program that runs, and the documents, under a prefix: install.sh ROOT CMAKE BUILD
cmake=$2
build=$3
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
"$cmake" --install "$build" --prefix "$prefix" >"$prefix/log" 2>&1 || {
    cat "$prefix/log"
    exit 1
}
version=$("$prefix/bin/sheen" --version) || exit 1
echo "$version" | grep -q '[0-9]\.[0-9]' || {
    echo "the installed program says its version is '$version'"
    exit 1
}
if [ -f "$build/sheen.1" ] && [ ! -f "$prefix/share/man/man1/sheen.1" ]; then
    echo "no manual page was installed"
    exit 1
fi
[ -f "$prefix/share/doc/sheen/LICENSE" ] || {
    echo "no licence was installed"
    exit 1
}
[ -f "$prefix/lib/udev/rules.d/60-sheen.rules" ] || {
    echo "no udev rules were installed"
    exit 1
}
