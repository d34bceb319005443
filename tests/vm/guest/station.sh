# SPDX-License-Identifier: Apache-2.0
# station.sh - an object from the table to the model: a UVC camera sees a table that a Grbl controller turns, behind a
# CDC-ACM line; the cable is pulled at every step in turn. The fit itself is made outside (host/station.sh).
id=/dev/v4l/by-id/usb-sheen_Simulated_UVC_Camera_UVC-0001-video-index0
turn=/tmp/share/turn.session
steps=6

shoot() {
    sheen capture shot.session --like $turn --device "v4l2:$id?lock=off" --turntable /dev/sheen/turntable \
        --steps $steps >out 2>err
}

payload() { # SESSION FRAME
    sed -n 's/.*"payload_digest": *"\([0-9a-f]*\)".*/\1/p' "$1/frames/$2.json"
}

# The stored picture is, byte by byte, the one of that angle of the table.
shows_its_angle() { # STEP
    [ -n "$(payload shot.session "r1-00$1")" ] &&
        [ "$(payload shot.session "r1-00$1")" = "$(payload $turn "$(printf 'a%03d' $(($1 * 36 / steps)))")" ]
}

# The tags show what was commanded, within a tenth of a degree.
angles_agree() {
    cat shot.session/frames/*.json | tr ',' '\n' |
        awk -F: '/table_asked_deg/ { asked = $2 } /table_measured_deg/ { n++; d = $2 - asked; if (d < 0) d = -d; bad = bad || d > 0.1 }
            END { exit bad || n != '$steps' }'
}

load_gadget
load uvcvideo
load vhci-hcd
start_udev
make_gadget
plug_gadget
check "the turntable is there" wait_for 10 test -c /dev/sheen/turntable
usbip_camera $turn 0 table=/dev/ttyGS0 2>camera.log &
camera=$!
check "the camera is there" wait_for 20 test -e $id
sheen devices >out 2>err
check "both are listed" sh -c "grep -q 'the turntable' out && grep -q $id out"

step=1
while [ $step -lt $steps ]; do
    shoot &
    capture=$!
    wait_for 60 test -f shot.session/frames/r1-00$((step - 1)).json
    sleep 1 # on its way to the next
    unplug_gadget
    wait $capture
    code=$?
    check "pulled before step $step: it says so" sh -c "[ $code = 1 ] && grep -q 'turntable' err && grep -q 'is gone' err"
    plug_gadget
    wait_for 10 test -c /dev/sheen/turntable
    step=$((step + 1))
done
check "it goes on and ends complete" shoot
check "with all frames" test "$(frames_in shot.session)" = $steps
step=0
while [ $step -lt $steps ]; do
    check "frame $step shows its angle" shows_its_angle $step
    step=$((step + 1))
done
check "the tags agree with the commands" angles_agree
check "nothing is left to do" shoot
kill $camera
check "the frames have poses" sh -c "sheen pose shot.session >out 2>err"
cp -r shot.session /tmp/share/
