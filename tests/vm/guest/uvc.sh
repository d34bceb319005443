# SPDX-License-Identifier: Apache-2.0
# uvc.sh - the kernel's uvcvideo with a simulated USB camera: bytes, settings, the lock, unplugged and back.
id=/dev/v4l/by-id/usb-sheen_Simulated_UVC_Camera_UVC-0001-video-index0

plug() { # SESSION [deaf]
    usbip_camera "$1" 0 $2 2>camera.log &
    camera=$!
    wait_for 10 test -e $id
}

unplug() {
    kill $camera
    wait $camera 2>/dev/null
    wait_for 10 test ! -e $id
}

recorded_setting() { # SESSION CONTROL_NUMBER: of its last frame
    last=$(find "$1/frames" -name '*.json' | sort | tail -n 1)
    tr -d ' \n' <"$last" | sed -n "s/.*\[$2,\(-\{0,1\}[0-9]*\)\].*/\1/p"
}

load uvcvideo
load vhci-hcd
start_udev
for format in YUYV MJPG; do
    make_recording $format.session $format 320 240 6
    check "a camera with $format is plugged in" plug $format.session
    check "$format is recorded" captures got.$format "v4l2:$id?lock=off" 8
    check "$format: byte by byte, in order, $(counted dropped) dropped" in_order got.$format $format.session 3
    check "$format is listed by its lasting name" sh -c "sheen devices >out; grep -q $id out && grep -q 'serial UVC-0001' out"
    check "$format: unplugged" unplug
done

plug -
check "a camera that obeys is locked" captures lit.session "v4l2:$id?exposure_ms=20" 3
check "the exposure that it has is the one of the sidecar" sh -c "grep '^set 1.4 ' camera.log | tail -n 1 | grep -q ' 200\$'"
check "which is 20 ms" test "$(recorded_setting lit.session 10094850)" = 200
check "white balance is fixed" test "$(recorded_setting lit.session 9963788)" = 0
check "proof is in the sidecar" grep -q '"lock": *"held"' lit.session/frames/000002.json
unplug
plug - deaf
check "a camera that only says so is refused" fails_with 'half the exposure' deaf.session "v4l2:$id?exposure_ms=20" 1
unplug

# Pulled out while it streams, and back as another node, because somebody still holds the old one.
plug YUYV.session
node=$(readlink -f $id)
sheen capture pulled.session --device "v4l2:$id?lock=off" --count 60 >/dev/null 2>err &
capture=$!
wait_for 20 test -f pulled.session/frames/000003.json
exec 7<"$node"
unplug
sleep 1
check "plugged in again" plug YUYV.session
check "as another node: $(readlink -f $id) after $node" test "$(readlink -f $id)" != "$node"
wait $capture
code=$?
exec 7<&-
if [ $code != 0 ]; then # it gave up: the same command goes on
    check "what happened is said" grep -q 'gone' err
    check "it goes on where it was" captures pulled.session "v4l2:$id?lock=off" $((60 - $(frames_in pulled.session)))
fi
check "all sixty" test "$(frames_in pulled.session)" = 60
check "of the recording" all_recorded pulled.session YUYV.session
unplug
