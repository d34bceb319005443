# pictures that cannot be calibrated from, each with its sentence; a folder, a table of corners, other programs' files
@ data=$(dirname $cmd)/../data/penguin; mkdir few alike all blank; cp $data/calibration-board.json board.json
@ data=$(dirname $cmd)/../data/penguin; cp $data/frames/cal*.jpg all; cp all/cal0[0-3].jpg few
@ for i in 0 1 2 3 4 5; do cp all/cal05.jpg alike/a$i.jpg; done
@ for i in 0 1 2 3 4 5; do make_input picture blank/p$i.png 320 240 $i; done
@ sheen board -o other.pdf --paper a3 --first-id 300
@ mkdir mixed && cp all/cal0[0-5].jpg mixed && make_input picture mixed/z.png 320 240 1
sheen calibrate few --board board.json
sheen calibrate blank --board board.json
sheen calibrate all --board other.json
@ sed 's/tag36h11/tag25h9/' board.json > family.json
sheen calibrate all --board family.json
sheen calibrate mixed --board board.json
sheen calibrate alike --board board.json > said; echo "exit code $?"
tail -1 said | sed 's/.*: //'
sheen calibrate nowhere --board board.json
sheen calibrate all
sheen calibrate all --board board.json --model fisheye
sheen calibrate all --board board.json -o x.ini
sheen calibrate all --board board.json -o x.kalibr.yaml
sheen calibrate all --board board.json --model opencv4 -o x.kalibr.yaml --report x.html | tail -1 | cut -c 1-4
grep -c '<section>' x.html
sheen calibrate s --live
sheen calibrate all --device replay:s
printf '# filename x y level\nf0 - - -\n' > c.vnl
sheen calibrate c.vnl --board board.json
sheen calibrate c.vnl --board board.json --size 1280x960

# live, from a recording in which the board stands still twice each time
@ mkdir twice; for f in all/cal0*.jpg all/cal1[0-1].jpg; do n=$(basename $f .jpg); cp $f twice/${n}a.jpg; cp $f twice/${n}b.jpg; done
@ sheen import recorded twice --role calibration
sheen calibrate s --live --device replay:recorded
sheen calibrate s --live --device replay:recorded --board board.json --accuracy-px 0.05 > said
sed 's/ to 0\.[0-9]* px/ to N px/; s/ (then .*//' said | head -16
grep -c ' taken' said
@ sed 's/\(intrinsics.: \[\) [0-9.]*/\1 nan/' s/camera.cameramodel > nan.cameramodel
sheen import t all/cal00.jpg --camera nan.cameramodel

# another camera, another focus: in one calibration, and in frames that are to be posed
@ cp s/calibration-board.json s/board.json && cp all/cal05.jpg extra.jpg && sheen import s extra.jpg
@ sed -i 's/"role": "calibration"/"role": "calibration", "device": "Cam A (usb-1)"/' s/frames/cal*.json
@ sed -i 's/"role": "input"/"role": "input", "device": "Cam B (usb-1)"/' s/frames/extra.json
sheen calibrate s >/dev/null && grep -a taken s/camera.cameramodel
sheen pose s | sed 's/ [0-9.]* mm/ N mm/g'
@ sed -i 's/Cam A (usb-1)/Cam C (usb-1)/' s/frames/cal05b.json
sheen calibrate s
# the lens turned since: residuals have grown
@ sed -i 's/Cam [A-C] (usb-1)/Cam A (usb-2)/' s/frames/*.json
@ sheen calibrate s && sed -i 's/\(intrinsics.: \[\) [0-9.]*/\1 1460/' s/camera.cameramodel
sheen pose s | sed 's/ [0-9.]* mm/ N mm/g'
