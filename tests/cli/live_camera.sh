#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Calibrates live from a camera (a fake one behind /dev/video42, which shows the sample's board pictures three times each):
# live_camera.sh SHEEN WITH_CAMERA DATA. It must take frames that stand still, say what to do next, stop when the accuracy
# is reached, and leave a calibration that knows its camera.
sheen=$1 with_camera=$2 data=$3
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch" || exit 2
bad=0
complain() {
    echo "$*"
    cat said
    bad=1
}

mkdir shown
for i in 00 01 02 03 04 05 06 07 08 09 10 11 12 13 14 15; do
    for again in a b c; do cp "$data/frames/cal$i.jpg" "shown/$i$again.jpg"; done
done
"$sheen" import recorded shown >said 2>&1 || complain "cannot prepare"
mkdir -p config/sheen
cat >config/sheen/cameras.json <<END
{"schema": "sheen-cameras/1", "cameras": [{"camera": "Fake Camera", "options": "transfer=srgb"}]}
END
export XDG_CONFIG_HOME="$scratch/config"
"$with_camera" recorded "node=42;rate=4" "$sheen" calibrate live --live --device 'v4l2:/dev/video42?lock=off' \
    --board "$data/calibration-board.json" --accuracy-px 0.12 >said 2>&1
code=$?
[ "$code" = 0 ] || complain "exit code $code"
grep -q 'of this camera is known: transfer=srgb' said || complain "what is remembered of the camera was not used"
grep -q '^hold the board in the middle' said || complain "no first advice"
grep -q '^tilt the board' said || complain "no advice on tilts"
grep -q ': enough$' said || complain "it did not stop by itself"
n=$(find live/frames -name '*.jpg' | wc -l)
if [ "$n" -lt 5 ] || [ "$n" -gt 16 ]; then
    complain "$n frames were taken"
fi
grep -qa 'taken by' live/camera.cameramodel || complain "the calibration does not name its camera"

# a camera that is pulled out is a sentence, and what was taken stays
"$with_camera" recorded "node=42;rate=4;unplug_at=14" "$sheen" calibrate pulled --live \
    --device 'v4l2:/dev/video42?lock=off' --board "$data/calibration-board.json" --accuracy-px 0.12 >said 2>&1
code=$?
[ "$code" = 1 ] || complain "exit code $code where the camera was pulled out"
grep -q '^sheen: ' said || complain "nothing said about the camera"
[ -d pulled/frames ] || complain "what was taken is lost"
exit $bad
