# a drawn ball with known poses: fitted, drawn again, scored; a second run does nothing
@ mkdir photos
@ make_input shiny photos 160 120 p0 p1 p2 p3 p4 p5 p6
@ make_input poses transforms.json 160 120 p0 p1 p2 p3 p4 p5 p6
@ make_input mesh ball.obj
@ sheen import recorded photos/p[01356].png && sheen import recorded photos/p[24].png --role test
sheen capture s --device replay:recorded
sheen import s --poses transforms.json --mesh ball.obj
sheen run s --film-size 64x48 | grep -E '^(calibrate|pose|fit|eval|film|side by side|table|model)[: ]'
sheen run s
sheen run s --no-film --json | tr -d ' \n'; echo
sheen eval s --json | grep -c '"highlights_linear_db"'
sheen fit s --frequency 20 --json --timings | grep -E '"(photographs|nodes|step)":' | head -3
sheen run s --no-film | grep -E '^(fit|eval):'
# what moved the stamp: another test frame's mask, then nothing
@ mkdir masks && make_input mask masks/p2.png 160 120
@ sheen import s --masks masks
sheen run s --no-film | grep -E '^[a-z]+:'
# no room for its pictures: the old evaluation stays
trap '' XFSZ; ulimit -f 16; sheen eval s
sheen run s --no-film | grep -E '^eval:'
sheen render s --view 0,37,0.5 -o front.png
sheen render s --view=-30,20 -o side.exr --layer specular --size 100x80
sheen render s --poses transforms.json -o pictures --size 80x60 --format exr
sheen render s --poses transforms.json -o pictures --size 160x160
sheen render s --view 0,37,0.5 -o turned.png --turn-lights 90 --turn-axis 1,0,0 --k-s 2 --sigma 0.1 --tint 1,0.5,0.2 --background none --holes fill
# black, although the fit has filled it
sheen render s --view 180,-20,0.5 -o a.png --holes fill && sheen render s --view 180,-20,0.5 -o b.png --holes black
cmp -s a.png b.png || rm a.png b.png
sheen render s --view 0,37,0.5 -o sky.png --panorama turned.png
@ sheen export s -o lit.glb
sheen render s --view 0,37,0.5 -o sky.png --panorama lit-environment.hdr
sheen render s --view 0,37,0.5 -o depth.exr --layer depth --size 100x80
sheen render s --spin spin --count 3 --size 64x48 --layer normal
ls spin
sheen render s --orbit film.mp4 --seconds 0.2 --fps 10 --size 64x48 --layer diffuse --json
sheen eval s --against photos --poses transforms.json | grep -c '|'
sheen eval s --holdout 2 | grep -c '|'
ls . pictures s s/evaluation
