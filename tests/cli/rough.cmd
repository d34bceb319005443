# photographs that show nothing are left out, and said; where none is left that is the answer
@ mkdir photos
@ make_input shiny photos 160 120 p0 p1 p2 p3 p4 p5 p6
@ make_input poses transforms.json 160 120 p0 p1 p2 p3 p4 p5 p6
@ make_input mesh ball.obj
@ cp -r photos lost && for i in 0 1 2 3 4 5 6; do make_input black lost/p$i.png photos/p$i.png; done
@ cp -r photos two && make_input black two/p0.png photos/p0.png && make_input black two/p5.png photos/p5.png
@ for s in lost two; do sheen import s-$s $s --poses transforms.json --mesh ball.obj; done
sheen fit s-two | grep -E '^([0-9]+ photographs|exposures|note: .*black)' | sed 's/,.*//'
sheen fit s-lost
ls s-lost | grep model
# pixels of a float file that are no number, infinite or absurd do not hide what the others show
@ mkdir floats
@ for i in 0 1 2 3 4 5 6; do make_input hot floats/p$i.exr photos/p$i.png; done
@ sheen import s-floats floats --poses transforms.json --mesh ball.obj
sheen fit s-floats | grep -c 'taken to be matte'
sheen render s-floats --view 0,37,0.5 -o front.png --size 40x30
# one photograph of another size
@ make_input flat photos/p4.png 40 30
sheen import s-sizes photos --poses transforms.json --mesh ball.obj
