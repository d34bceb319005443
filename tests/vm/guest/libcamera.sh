# SPDX-License-Identifier: Apache-2.0
# libcamera.sh - libcamera with a USB camera: listed, recorded byte by byte, refused where it cannot be locked, unplugged.
load xhci-pci
load uvcvideo
start_udev
touch /tmp/share/plugged
check "a camera is plugged in" wait_for 20 test -c /dev/video0
udevadm settle -t 10
check "it is listed" sh -c 'sheen devices >out 2>err; grep -q "^libcamera:0 .*Simulated UVC Camera" out'
check "its white balance is not called locked, and V4L2 is named" \
    fails_with 'cannot be locked.*white balance.*v4l2:/dev/video' locked.session libcamera:0 1
check "frames are recorded" captures got.session 'libcamera:0?lock=off&format=YUYV&size=320x240' 12
check "byte by byte, in order, $(counted dropped) dropped" in_order got.session /tmp/share/recorded.session 6
check "with times that rise" sh -c "sed -n 's/.*\"t_ns\": *\([0-9]*\).*/\1/p' got.session/frames/*.json | sort -n -c"
check "a size that it has not is refused" fails_with 'does not offer' size.session 'libcamera:0?lock=off&size=64x64' 1
check "a camera that is not there" fails_with 'libcamera knows 1 camera' none.session 'libcamera:7' 1

sheen capture pulled.session --device 'libcamera:0?lock=off' --count 400 --patience 4 >/dev/null 2>err &
capture=$!
check "it streams" wait_for 20 test -f pulled.session/frames/000003.json
rm /tmp/share/plugged
wait $capture
check "unplugged: noticed" test $? = 1
check "and said" grep -q 'gone' err
check "what was recorded is whole" all_recorded pulled.session /tmp/share/recorded.session
touch /tmp/share/plugged
check "plugged in again" wait_for 20 test -c /dev/video0
udevadm settle -t 10
before=$(frames_in pulled.session)
check "the session goes on" captures pulled.session 'libcamera:0?lock=off' 3
check "with three more" test "$(frames_in pulled.session)" = $((before + 3))

# the same, but the capture waits for it
sheen capture waits.session --device 'libcamera:0?lock=off' --count 60 --patience 60 >out 2>err &
capture=$!
check "it streams again" wait_for 20 test -f waits.session/frames/000003.json
rm /tmp/share/plugged
check "unplugged: the person is asked" wait_for 30 grep -q 'plug it in again' err
touch /tmp/share/plugged
wait $capture
check "plugged in again, the capture goes on by itself" test $? = 0
check "and says so" grep -q 'the camera is there again' err
check "with all its frames" test "$(frames_in waits.session)" = 60
