#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# One step of the tests of pages and glTF files in Chromium: run.sh STEP SHEEN WORK [MAKE_INPUT CHANGE_MODEL]
#
#     sessions   a drawn ball fitted by each method, and a figure without its mesh's place
#     viewer     the ball's pages, and the page of marks
#     gltf       its glTF files
#
# WORK is a build folder with what npm brought (its node_modules); sessions, pages and screenshots stay in it. Exits
# with 77, which CTest counts as skipped, where there is no Chromium.
step=$1 sheen=$2 work=$3 make_input=$4 change_model=$5
sessions=$work/sessions pages=$work/pages
here=$(cd "$(dirname "$0")" && pwd)
chromium=$(command -v chromium) || {
    echo "skipped: Chromium is not installed (package chromium)"
    exit 77
}
[ -d "$work/node_modules/playwright-core" ] || {
    echo "npm could not bring what the test is made with: see the test view_packages"
    exit 1
}

make_sessions() (
    cp "$here"/*.mjs "$here"/*.js "$work" || exit 1 # once, here: the other steps may run at the same time
    rm -rf "$sessions"
    mkdir -p "$sessions/photos" "$sessions/figure" && cd "$sessions" || exit 1
    "$make_input" shiny photos 320 240 p0 p1 p2 p3 p4 p5 p6 &&
        "$make_input" poses transforms.json 320 240 p0 p1 p2 p3 p4 p5 p6 &&
        "$make_input" mesh ball.obj &&
        "$sheen" import ball.session photos/p?.png --poses transforms.json --mesh ball.obj &&
        cp -r ball.session refined.session &&
        "$sheen" fit ball.session --method paper &&
        "$sheen" fit refined.session --method refined || exit 1
    for change in bent turned; do
        cp -r refined.session $change.session &&
            "$change_model" $change $change.session changed &&
            rm -r $change.session/model &&
            mv changed $change.session/model || exit 1
    done
    "$make_input" figure-views figure 640 480 p0 p1 p2 p3 p4 p5 p6 p7 &&
        "$make_input" poses figure.json 640 480 p0 p1 p2 p3 p4 p5 p6 p7 &&
        "$make_input" figure figure.obj 1000 &&
        "$make_input" figure-marks all.txt 640 480 1000 p0 p1 p2 p3 p4 p5 p6 p7 &&
        grep -E "^p[02]" all.txt >marks.txt &&
        "$sheen" import figure.session figure --poses figure.json
)

page_test() {
    test=$1
    shift
    node "$work/$test.mjs" "$chromium" "$sheen" "$pages" "$@"
}

cd "$sessions" 2>/dev/null || [ "$step" = sessions ] || exit 1
case $step in
sessions) make_sessions ;;
viewer)
    page_test test_viewer ball.session refined.session bent.session turned.session &&
        page_test test_pick figure.session figure.obj marks.txt
    ;;
gltf) page_test test_gltf ball.session refined.session bent.session ;;
esac
