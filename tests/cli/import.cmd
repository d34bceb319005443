# files enter a session, twice, and a faulty one leaves it as it was
@ mkdir photos masks
@ make_input picture photos/a.png 64 48 1
@ make_input picture photos/b.jpg 64 48 2
@ make_input picture photos/c.exr 64 48 3
@ make_input mask masks/a.png 64 48
@ make_input camera lens.cameramodel 64 48
@ make_input poses transforms.json 64 48 a b
@ make_input board board.json
@ make_input mesh ball.obj
sheen import s photos
sheen import s photos/*.png photos/b.jpg
sheen import s --camera lens.cameramodel --poses transforms.json --mesh ball.obj --masks masks --board board.json
sheen import s photos --json | tr -d ' \n'; echo
find s -type f | sort
cat s/frames/a.json
cat s/session.json | grep -v created

# faults
@ head -c 300 photos/a.png > cut.png
@ head -c 500 photos/b.jpg > cut.jpg
@ : > empty.png
@ echo '{' > bad.json
@ make_input picture other.png 32 48 1
@ make_input picture sub.png 64 48 9
@ mkdir same && cp sub.png same/a.png
@ make_input camera wide.cameramodel 128 48
@ make_input poses others.json 64 48 x y
@ sed '0,/0\.8/s/0\.8/NaN/' transforms.json > nan.json
@ sed '0,/0\.8/s/0\.8/0.7/' transforms.json > skewed.json
@ mkdir wrongmasks && make_input mask wrongmasks/a.png 60 48
@ mkdir nomasks && mkdir nopictures
@ head -c 200 ball.obj > cut.obj; echo 'f 1 2 900' >> cut.obj
@ find s -type f | sort | xargs cksum > before
sheen import s sub.png cut.png
sheen import s sub.png cut.jpg
sheen import s sub.png empty.png
sheen import s sub.png missing.png
sheen import s sub.png board.json
sheen import s sub.png other.png
sheen import s same/a.png
sheen import s sub.png nopictures
sheen import s photos/a.png --role test
sheen import s sub.png --camera wide.cameramodel
sheen import s sub.png --camera bad.json
sheen import s sub.png --poses bad.json
sheen import s sub.png --poses others.json
sheen import s sub.png --poses nan.json
sheen import s sub.png --poses skewed.json
sheen import s sub.png --masks wrongmasks
sheen import s sub.png --masks nomasks
sheen import s sub.png --masks nowhere
sheen import s sub.png --board bad.json
sheen import s sub.png --mesh cut.obj
sheen import s sub.png --mesh board.json
sheen import s cut.png --json
find s -type f | sort | xargs cksum | cmp before -
sheen import fresh cut.png
sheen import photos sub.png
ls
