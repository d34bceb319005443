#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Programs of others take the fake camera for a camera: judges.sh WITH_CAMERA MAKE_RECORDING READ_OPENCV SHEEN JUDGE
# JUDGE: compliance, v4l2-ctl, ffmpeg, opencv, sheen. Each reads recorded frames back, byte by byte, from a stream whose
# first eight frames have a buffer each, so that a busy machine loses none of them.
with_camera=$1 make_recording=$2 read_opencv=$3 sheen=$4 judge=$5
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch" || exit 2
bad=0

need() {
    command -v "$1" >/dev/null || {
        echo "$1 is not installed"
        exit 77
    }
}

complain() {
    echo "$*"
    bad=1
}

# record FORMAT: frames/ of FORMAT.session, and all of them in a row as FORMAT.bytes.
record() {
    "$make_recording" "$1.session" "$1" 64 48 8 || exit 1
    cat "$1".session/frames/*.raw "$1".session/frames/*.jpg >"$1.bytes" 2>/dev/null
}

# same FORMAT FILE: what was read is what was recorded.
same() {
    cmp "$1.bytes" "$2" || complain "$judge: $1 came back as something else"
}

# Every layout of bytes, and every order of colours once.
formats='YUYV NV12 GREY Y10 Y12 Y16 RGB3 BGR3 MJPG RGGB BG10 pGAA GB12 pRCC GR14 RG16'

case $judge in
compliance)
    need v4l2-compliance
    for format in - $formats; do
        session=-
        if [ "$format" != - ]; then
            record "$format"
            session=$format.session
        fi
        for arguments in "" "-s 10"; do
            # shellcheck disable=SC2086 # an option and its value
            "$with_camera" $session "node=42;rate=60" v4l2-compliance -d /dev/video42 $arguments >log 2>&1
            code=$?
            tail -n 1 log | sed "s/^/$format: /"
            # A busy machine reads too late, and numbers lack then as with any camera.
            grep -E 'fail:|warn:|FAIL' log | grep -v 'warn: .*got sequence number' >against
            if [ $code != 0 ] || [ -s against ] || ! tail -n 1 log | grep -q 'Failed: 0, '; then
                cat against
                complain "v4l2-compliance $arguments refuses $format"
            fi
        done
    done
    # It must be able to fail: a camera that forgets what it is told is none.
    "$with_camera" - "node=42;fail_request=G_CTRL;fail_request_errno=EIO" v4l2-compliance -d /dev/video42 >log 2>&1 &&
        complain "v4l2-compliance takes anything"
    ;;
v4l2-ctl)
    need v4l2-ctl
    for format in $formats; do
        record "$format"
        "$with_camera" "$format.session" node=42 v4l2-ctl -d /dev/video42 --stream-mmap=8 --stream-count=8 \
            --stream-to=got >log 2>&1 || complain "v4l2-ctl: $(cat log)"
        same "$format" got
    done
    ;;
ffmpeg)
    need ffmpeg
    # All that it has a name for.
    for pair in YUYV:yuyv422:rawvideo NV12:nv12:rawvideo GREY:gray:rawvideo Y16:gray16le:rawvideo RGB3:rgb24:rawvideo \
        BGR3:bgr24:rawvideo RGGB:bayer_rggb8:rawvideo MJPG:mjpeg:mjpeg; do
        format=${pair%%:*} names=${pair#*:}
        record "$format"
        "$with_camera" "$format.session" node=42 ffmpeg -nostdin -loglevel error -f v4l2 -input_format "${names%:*}" \
            -i /dev/video42 -frames:v 8 -c:v copy -f "${names#*:}" -y got || complain "ffmpeg failed on $format"
        same "$format" got
    done
    ;;
opencv)
    # It begins where it likes, but what it reads are recorded frames, one after the other (slow ones: it has few buffers).
    for format in YUYV NV12 GREY Y16 RGB3 BGR3 MJPG; do
        record "$format"
        sha1sum "$format".session/frames/*.raw "$format".session/frames/*.jpg 2>/dev/null | cut -c 1-40 >recorded
        "$with_camera" "$format.session" "node=42;rate=10" "$read_opencv" /dev/video42 4 raw got. || complain "OpenCV failed on $format"
        sha1sum got.? | cut -c 1-40 >got
        cat recorded recorded | tr '\n' ' ' | grep -qE "^(.{41})*$(tr '\n' ' ' <got)" || complain "OpenCV reads other frames of $format"
        [ "$(wc -l <got)" = 4 ] || complain "OpenCV reads $(wc -l <got) frames of $format"
    done
    "$with_camera" MJPG.session "node=42;rate=10" "$read_opencv" /dev/video42 1 decoded picture. || complain "OpenCV failed"
    [ "$(wc -c <picture.0)" = $((64 * 48 * 3)) ] || complain "OpenCV decodes to $(wc -c <picture.0) bytes"
    ;;
sheen)
    for format in $formats; do
        record "$format"
        "$sheen" capture replayed.session --device "replay:$format.session" >log 2>&1 || complain "sheen: $(cat log)"
        "$with_camera" "$format.session" "node=42;swapped=2" "$sheen" capture live.session \
            --device 'v4l2:/dev/video42?lock=off' --count 8 >log 2>&1 || complain "sheen: $(cat log)"
        for kind in replayed live; do
            cat $kind.session/frames/*.raw $kind.session/frames/*.jpg >got 2>/dev/null
            same "$format" got
            # What develops the bytes is the same, too.
            grep -hE '"(width_px|height_px|fourcc|stride_bytes|transfer|payload_digest|sequence)"' \
                $kind.session/frames/*.json >$kind.text
        done
        cmp replayed.text live.text || complain "sheen: the sidecars of $format differ"
        rm -rf replayed.session live.session
    done
    ;;
*)
    exit 2
    ;;
esac
exit $bad
