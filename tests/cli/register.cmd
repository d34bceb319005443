# a mesh into the board's frame: from masks, from marks, and what cannot be placed
@ mkdir photos masks wrong
@ printf '"$@" >said 2>&1; code=$?; sed "s/-\\{0,1\\}[0-9][0-9]*\\.[0-9]*/N/g; s/[0-9]* degrees/N degrees/; s/[0-9]* %%/N %%/" said; exit $code\n' > plain
@ names="p0 p1 p2 p3 p4 p5 p6 p7"; make_input figure-views photos 320 240 $names; make_input figure-masks masks 320 240 $names
@ make_input poses transforms.json 320 240 p0 p1 p2 p3 p4 p5 p6 p7
@ make_input figure metres.obj 1; make_input figure mm.obj 1000
@ for i in 0 1 2 3 4 5 6 7; do make_input mask wrong/p$i.png 320 240; done
@ sheen import masked photos --poses transforms.json --masks masks
@ sheen import bare photos --poses transforms.json
@ cp -r masked told; cp -r masked marked; cp -r masked kept

# unit and up axis found, and said
sh plain sheen register masked mm.obj
ls masked/registration masked/mesh*
sh plain sheen register told mm.obj --unit mm --up y
sheen register told mm.obj --unit mm --up y --json | grep -E '"(up|verdict|scale)"'

# marks, in the mesh's unit: alone, and with the masks after them
@ make_input figure-marks all.txt 320 240 1000 p0 p1 p2 p3 p4 p5 p6 p7; grep -E '#|p[02]' all.txt > marks.txt
sh plain sheen register bare mm.obj --points marks.txt
sh plain sheen register marked mm.obj --points marks.txt --unit mm
head -3 marks.txt > few.txt; sheen register bare mm.obj --points few.txt
printf 'p0 1 2 nan 4 5\n' > bad.txt; sheen register bare mm.obj --points bad.txt
: > none.txt; sheen register bare mm.obj --points none.txt
sed s/p0/q0/ marks.txt | grep q0 > other.txt; sheen register bare mm.obj --points other.txt
sheen register bare mm.obj --points missing.txt

# what turns alike: one of the places enters, exit code 3
@ make_input mesh ball.obj
@ mkdir round; make_input ball-masks round 320 240 p0 p1 p2 p3 p4 p5 p6 p7; sheen import turns photos --poses transforms.json --masks round
sh plain sheen register turns ball.obj --unit m --up z
ls turns/registration.json

# what does not fit leaves the session as it was
@ find kept -type f | grep -v /registration/ | sort | xargs cksum > before
sh plain sheen register kept metres.obj --unit mm
sh plain sheen register kept ball.obj --unit m --up z
@ cp -r bare others && sheen import others --masks wrong
sh plain sheen register others mm.obj --unit mm
: > empty.obj; sheen register kept empty.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\n' > points.obj; sheen register kept points.obj
printf 'v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > nan.obj; sheen register kept nan.obj
printf 'v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n' > dot.obj; sheen register kept dot.obj
find kept -type f | grep -v /registration/ | sort | xargs cksum | cmp before -
sheen register kept mm.obj --unit furlong
sheen register kept mm.obj --up w
sheen register kept mm.obj --up z --rt 0,0,0,0,0,0
sheen register kept mm.obj --pick a.txt --points marks.txt
