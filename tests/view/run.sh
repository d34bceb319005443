#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fits a drawn ball by each method, exports it, and looks at the pages and glTF files in Chromium, then at the page of marks: run.sh SHEEN MAKE_INPUT WORK
# WORK is a build folder with what npm brought (its node_modules); pages and screenshots stay in WORK/pages. Exits
# with 77, which CTest counts as skipped, where there is no Chromium.
sheen=$1 make_input=$2 work=$3
here=$(cd "$(dirname "$0")" && pwd)
chromium=$(command -v chromium) || {
    echo "skipped: Chromium is not installed (package chromium)"
    exit 77
}
[ -d "$work/node_modules/playwright-core" ] || {
    echo "npm could not bring what the test is made with: see the test view_packages"
    exit 1
}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
(
    cd "$scratch" || exit 1
    mkdir photos
    "$make_input" shiny photos 320 240 p0 p1 p2 p3 p4 p5 p6 &&
        "$make_input" poses transforms.json 320 240 p0 p1 p2 p3 p4 p5 p6 &&
        "$make_input" mesh ball.obj &&
        "$sheen" import ball.session photos/p?.png --poses transforms.json --mesh ball.obj &&
        cp -r ball.session refined.session &&
        "$sheen" fit ball.session --method paper &&
        "$sheen" fit refined.session --method refined &&
        mkdir figure &&
        "$make_input" figure-views figure 640 480 p0 p1 p2 p3 p4 p5 p6 p7 &&
        "$make_input" poses figure.json 640 480 p0 p1 p2 p3 p4 p5 p6 p7 &&
        "$make_input" figure figure.obj 1000 &&
        "$make_input" figure-marks all.txt 640 480 1000 p0 p1 p2 p3 p4 p5 p6 p7 && grep -E "^p[02]" all.txt >marks.txt &&
        "$sheen" import figure.session figure --poses figure.json
) || exit 1
cp "$here"/*.mjs "$here"/*.js "$work" || exit 1
node "$work/test_viewer.mjs" "$chromium" "$sheen" "$work/pages" "$scratch/ball.session" "$scratch/refined.session" &&
    node "$work/test_gltf.mjs" "$chromium" "$sheen" "$work/pages" "$scratch/ball.session" "$scratch/refined.session" &&
    node "$work/test_pick.mjs" "$chromium" "$sheen" "$work/pages" "$scratch/figure.session" "$scratch/figure.obj" "$scratch/marks.txt"
