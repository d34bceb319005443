# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=sh disable=SC2154 # build, share
# The pictures of a turn are drawn, and the model of what the machine recorded is fitted, on this side, where it is quicker.
"$(find "$build" -type f -name make_turn -perm -100)" "$share/turn.session" 640 480 36 || exit

afterwards() {
    if "$share/bin/sheen" fit "$share/shot.session" --texels 3 --frequency 20 --samples 4000 >"$share/fit" 2>&1 &&
        grep -q '"rt_world_cam"' "$share/shot.session/model/model.json"; then
        echo "ok: a model is fitted: $(grep k_S "$share/fit")"
    else
        cat "$share/fit"
        echo "FAILED: a model is fitted"
        return 1
    fi
}
