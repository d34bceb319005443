# every stage says what it lacks or cannot do, exits with 1, and leaves the session as it was
@ mkdir photos flats
@ for i in 0 1 2 3; do make_input picture photos/p$i.png 64 48 $i; make_input flat flats/f$i.png 64 48; done
@ make_input camera lens.cameramodel 64 48
@ make_input poses transforms.json 64 48 p0 p1 p2 p3 f0 f1 f2 f3
@ make_input board board.json
@ make_input mesh ball.obj
@ make_input mesh far.obj 50000
@ sheen import bare photos
sheen calibrate bare
sheen pose bare
sheen fit bare
sheen render bare --view 0,0 -o x.png
sheen eval bare
sheen run bare
sheen calibrate photos/p0.png
sheen calibrate photos/p0.png --board board.json
sheen calibrate nowhere.png --board board.json
sheen calibrate bare --board board.json
sheen pose nowhere
sheen view nowhere

# pictures without a board
@ sheen import s photos --board board.json --camera lens.cameramodel
@ find s -type f | sort | xargs cksum > before
sheen calibrate s
sheen pose s
find s -type f | sort | xargs cksum | cmp before -

# one view only; no highlight; a mesh that no camera sees; a session whose files were damaged meanwhile
@ sheen import one photos/p0.png --poses transforms.json --mesh ball.obj
sheen fit one
@ sheen import flat flats --poses transforms.json --mesh ball.obj
sheen fit flat --method paper
sheen fit flat | grep -E "^(lights|note)"
@ sheen import far photos --poses transforms.json --mesh far.obj
sheen fit far
@ sheen import ok photos --poses transforms.json --mesh ball.obj
@ cp -r ok empty-mesh && : > empty-mesh/mesh.obj
sheen fit empty-mesh
@ cp -r ok cut-frame && head -c 200 ok/frames/p1.png > cut-frame/frames/p1.png
sheen fit cut-frame
@ cp -r ok no-frame && rm no-frame/frames/p*.png
sheen fit no-frame
@ cp -r ok empty-camera && : > empty-camera/camera.cameramodel
sheen fit empty-camera
@ cp -r ok wide-camera && make_input camera wide-camera/camera.cameramodel 128 48
sheen fit wide-camera
@ cp -r ok nan-poses && sed -i 's/"rt_cam_board": .0*/"rt_cam_board": [NaN, /' nan-poses/poses.json
sheen fit nan-poses
@ cp -r ok bad-mask && mkdir bad-mask/masks && make_input mask bad-mask/masks/p2.png 60 48
sheen fit bad-mask
for s in one flat far empty-mesh cut-frame no-frame empty-camera wide-camera nan-poses bad-mask; do ls -A $s; done | sort | uniq -c | sed 's/^ *//'
sheen run s --json

# what is asked of the commands
sheen fit ok --method magic
sheen fit ok --loss square
sheen fit ok --texels 1
sheen render ok
sheen render ok --view 1,2
sheen render ok --view 1 -o x.png
sheen render ok --view 1,2 -o x.gif
sheen render ok --view 1,2 --orbit x.mp4
sheen render ok --view 1,2 -o x.png --size 10x10
sheen render ok --view 1,2 -o x.png --layer gold
sheen render ok --view 1,2 -o x.png --layer depth
sheen render ok --orbit x.mp4 --layer mask
sheen render ok --orbit x.mp4 --background none
sheen render ok --view 1,2 -o x.png --tint red
sheen render ok --view 1,2 -o x.png --holes plug
sheen render ok --view 1,2 -o x.png --background 1,1
sheen export ok
sheen export ok -o x.stl
sheen export ok -o x.html --texels 1
sheen eval ok --against photos
sheen eval ok --holdout 2 --against photos --poses transforms.json
sheen register ok ball.obj --rt 1,2,3
sheen register ok ball.obj --rt 0,0,1.5,0.01,0,0 --json
cat ok/registration.json
sheen register ok missing.obj
