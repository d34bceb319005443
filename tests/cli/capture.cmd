# a recorded session plays into another; what is there is not recorded twice
@ mkdir photos masks
@ for i in 1 2 3; do make_input picture photos/p$i.png 32 24 $i; done
@ make_input mask masks/p2.png 32 24
@ sheen import recorded photos --masks masks
@ make_input picture t.png 32 24 9 && sheen import recorded t.png --role test
sheen capture s --device replay:recorded --count 2
sheen capture s --device replay:recorded
sheen capture s --device replay:recorded
diff -r recorded/frames s/frames && diff -r recorded/masks s/masks && echo same
sheen capture tests --device 'replay:recorded?role=test' --json
sheen capture calib --device 'replay:recorded?role=calibration'
sheen capture s --device 'replay:recorded?speed=2'
# a damaged recording, a damaged session, one from the future
@ echo x >> recorded/frames/p2.png
sheen capture t --device replay:recorded
find t -type f | sort
@ cp -r s damaged && echo '{' > damaged/frames/p1.json
sheen import damaged photos
@ cp -r s future && sed -i 's,sheen-session/1,sheen-session/7,' future/session.json
sheen capture future --device replay:s
ls
