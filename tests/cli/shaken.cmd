# frames in which something moved during the exposure, a board that is not flat, one place only: in calibration and pose
@ data=$(dirname $cmd)/../data/penguin; cp $data/calibration-board.json board.json; mkdir blurred rolled some alike
@ data=$(dirname $cmd)/../data/penguin/frames; for i in 0 1 2 3 4 5 6 7; do make_input blurred blurred/b$i.png $data/cal0$i.jpg 30; done
@ data=$(dirname $cmd)/../data/penguin/frames; for i in 0 1 2 3 4 5 6 7; do make_input rolled rolled/r$i.png $data/cal0$i.jpg $((1 + i)); done
@ data=$(dirname $cmd)/../data/penguin/frames; cp $data/cal*.jpg some; cp blurred/b0.png rolled/r7.png some
sheen calibrate blurred --board board.json
sheen calibrate rolled --board board.json > said; echo "exit code $?"
tail -1 said | sed 's/[0-9.]* px/N px/g; s/[0-9.]* %/N %/g'
sheen calibrate some --board board.json --json > some.json; echo "exit code $?"
grep -A4 '"name": "\(b0\|r7\)"' some.json | grep -E '"(name|used|reason)"' | sed 's/[0-9.]* px/N px/; s/([0-9]* of [0-9]* corners/(N of N corners/'

# the same frames to be posed
@ data=$(dirname $cmd)/../data/penguin/frames; sheen calibrate $data/cal*.jpg --board board.json -o lens.cameramodel
@ data=$(dirname $cmd)/../data/penguin/frames; sheen import s $data/cal0?.jpg blurred/b0.png rolled/r7.png --board board.json --camera lens.cameramodel
sheen pose s --json > poses.json; echo "exit code $?"
sheen pose s --force | sed 's/ [0-9.]* mm/ N mm/g; s/[0-9.]* px/N px/g; s/[0-9.]* times/N times/'
@ data=$(dirname $cmd)/../data/penguin/frames; for i in 0 1 2 3 4 5; do cp $data/cal05.jpg alike/a$i.jpg; done
@ data=$(dirname $cmd)/../data/penguin/frames; sheen import t alike --board board.json --camera lens.cameramodel
sheen pose t > said; echo "exit code $?"
@ data=$(dirname $cmd)/../data/penguin/frames; sheen import u blurred --board board.json --camera lens.cameramodel
sheen pose u
