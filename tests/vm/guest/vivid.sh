# SPDX-License-Identifier: Apache-2.0
# vivid.sh - the kernel's own test driver: two cameras at once, each of its faults, its driver taken away, and a recording
# sent through its output and back.
size='format=YUYV&size=640x480'

set_control() { # NODE CONTROL
    v4l2-ctl -d "$1" -c "$2"
}

# A capture of 40 frames during which something happens. A camera that goes for good is not waited for.
patience=300
during() { # SESSION NODE COMMAND...
    session=$1 node=$2
    shift 2
    rm -rf "$session"
    sheen capture "$session" --device "v4l2:$node?lock=off&$size" --count 40 --patience $patience --json >out 2>err &
    capture=$!
    wait_for 10 test -f "$session/frames/000004.json" || return 1
    "$@"
    wait $capture
    code=$?
    [ $code = 0 ] || [ $code = 1 ]
}

# What had been accepted is whole, and the session goes on.
goes_on() { # SESSION NODE
    before=$(frames_in "$1")
    captures "$1" "v4l2:$2?lock=off&$size" 3 && [ "$(frames_in "$1")" = $((before + 3)) ] &&
        sheen capture copy.session --device "replay:$1" >/dev/null 2>err && rm -rf copy.session
}

load vivid n_devs=2 node_types=0x1,0x1 num_inputs=1,1 input_types=0x0,0x0
check "two nodes" wait_for 5 test -c /dev/video1
sheen devices --json >out 2>err
check "two cameras are listed, with their places" test "$(grep -oE 'platform:vivid-00[01]' out | sort -u | wc -l)" = 2

sheen capture b.session --device "v4l2:/dev/video1?lock=off&$size" --count 20 >/dev/null 2>err.b &
beside=$!
check "twenty frames from one" captures a.session "v4l2:/dev/video0?lock=off&$size" 20
check "what its numbers lack is what was counted as dropped: $(counted dropped)" gaps_are a.session "$(counted dropped)"
wait $beside
check "twenty from the other at the same time" test "$(frames_in b.session)" = 20
check "no lock without a control of the exposure" fails_with 'cannot be locked' c.session "v4l2:/dev/video0?$size" 1
check "busy, and who has it" sh -c '
    v4l2-ctl -d /dev/video0 --stream-mmap --stream-count=200 >/dev/null 2>&1 &
    sleep 1
    . /tmp/share/guest/lib.sh
    fails_with "v4l2-ctl (process" d.session "v4l2:/dev/video0?lock=off" 1
    code=$?
    kill $!
    wait
    exit $code'

check "a damaged buffer" during f1.session /dev/video0 set_control /dev/video0 inject_v4l2_buf_flag_error=1
check "is counted and not kept" test "$(counted flagged)" = 1
check "QBUF fails once" during f2.session /dev/video0 set_control /dev/video0 inject_vidioc_qbuf_error=1
check "all frames all the same" test "$(frames_in f2.session)" = 40
check "a fatal streaming error" during f3.session /dev/video0 set_control /dev/video0 inject_fatal_streaming_error=1
check "the session goes on" goes_on f3.session /dev/video0
check "a disconnect" during f4.session /dev/video0 set_control /dev/video0 disconnect=1
check "the session goes on" goes_on f4.session /dev/video0
for call in reqbufs streamon; do
    set_control /dev/video0 inject_vidioc_${call}_error=1
    captures "$call.session" "v4l2:/dev/video0?lock=off&$size" 2
    code=$?
    check "$call fails once: done, or said" test $code = 0 -o $code = 1
    check "and then it works" captures "$call.session" "v4l2:/dev/video0?lock=off&$size" 2
done
set_control /dev/video0 percentage_of_dropped_buffers=30
check "a third of the frames are lost" captures g.session "v4l2:/dev/video0?lock=off&$size" 30
check "and counted: $(counted dropped)" test "$(counted dropped)" -gt 3
set_control /dev/video0 percentage_of_dropped_buffers=0
set_control /dev/video0 wrap_sequence_number=1
# It begins at 4294967168: 128 frames to go.
check "sequence numbers wrap" captures h.session "v4l2:/dev/video0?lock=off&format=YUYV&size=320x180" 140
check "and nothing is thought lost" test "$(counted dropped)" = 0 -a "$(counted late)" = 0
set_control /dev/video0 wrap_sequence_number=0
for kind in 1 2; do
    set_control /dev/video0 wrap_timestamp=$kind
    check "timestamps that wrap ($kind)" captures i$kind.session "v4l2:/dev/video0?lock=off&$size" 5
done
set_control /dev/video0 wrap_timestamp=0

unbind() {
    echo vivid.0 >/sys/bus/platform/drivers/vivid/unbind
}
patience=0
check "the driver is taken away" during j.session /dev/video0 unbind
check "which is said" grep -q 'gone\|no ./dev/video' err
echo vivid.0 >/sys/bus/platform/drivers/vivid/bind
check "it comes back" wait_for 5 sh -c 'v4l2-ctl -d /dev/video0 --all || v4l2-ctl -d /dev/video2 --all'
modprobe -d "$KERNEL" -r vivid

# A recording into its output and out of its input. The two ends do not keep step: frames repeat and skip.
load vivid n_devs=1 node_types=0x101 num_inputs=1 input_types=0x3 num_outputs=1 output_types=0x1
wait_for 5 test -c /dev/video1
v4l2-ctl -d /dev/video0 --set-edid type=hdmi >/dev/null
for node in 0 1; do
    v4l2-ctl -d /dev/video$node --set-dv-bt-timings index=0 >/dev/null
done
v4l2-ctl -d /dev/video0 -c loop_video=1,osd_text_mode=2
for format in YUYV RGGB NV12; do
    make_recording $format.session $format 640 480 5
    cat $format.session/frames/*.raw >bytes
    v4l2-ctl -d /dev/video1 --set-fmt-video-out "width=640,height=480,pixelformat=$format" >/dev/null
    v4l2-ctl -d /dev/video0 --set-fmt-video "pixelformat=$format" >/dev/null
    v4l2-ctl -d /dev/video1 --stream-out-mmap=4 --stream-from=bytes --stream-loop >/dev/null 2>&1 &
    player=$!
    sleep 1
    check "$format through the driver" captures looped.$format "v4l2:/dev/video0?lock=off&format=$format&size=640x480" 8
    check "$format is what was recorded" all_recorded looped.$format $format.session
    kill $player
    wait $player 2>/dev/null
done
v4l2-ctl -d /dev/video0 -c dv_timings_signal_mode=1
captures signal.session "v4l2:/dev/video0?lock=off" 2
check "no signal: done, or said" test $? -le 1
