# a model that was damaged, or made to harm, costs one sentence and exit 1 in each command that reads it
@ mkdir photos
@ for i in 0 1 2 3; do make_input picture photos/p$i.png 64 48 $i; done
@ make_input camera lens.cameramodel 64 48
@ make_input poses transforms.json 64 48 p0 p1 p2 p3
@ make_input mesh ball.obj
@ sheen import ok photos --poses transforms.json --mesh ball.obj
@ sheen fit ok
sheen render ok --view 0,30 --size 64x48 -o ok.png
@ for s in nodes lamps frequency nan infinite sharp texels triangles cut board; do cp -r ok $s; done

# ten million nodes, a hundred thousand lamps, a lattice of no size
@ seq -s, 0 9999999 > many
@ sed -i -e '/"index"/{s/.*/"index": [/' -e 'r many' -e 'a ],' -e '}' nodes/model/model.json
@ awk '/"light_rgb"/ { l = "{\"direction_world\": [0, 0, 1], \"inverse_distance_per_m\": 0, \"radius_rad\": 0, \"rgb\": [1, 1, 1]}"; printf "\"lamps\": {\"origin_world\": [0, 0, 0], \"tail\": 0, \"fresnel\": 0, \"lights\": [%s", l; for (i = 1; i < 100000; i++) printf ", %s", l; print "]}," } { print }' ok/model/model.json > lamps/model/model.json
@ sed -i 's/"frequency": [0-9]*/"frequency": 2000000000/' frequency/model/model.json
sheen render nodes --view 0,30 -o x.png
sheen render lamps --view 0,30 -o x.png
sheen render frequency --view 0,30 -o x.png

# numbers that are none, or none that a surface has
@ sed -i 's/"sigma_rad": [^,]*/"sigma_rad": NaN/' nan/model/model.json
@ sed -i 's/"k_s": [^,]*/"k_s": 1e999/' infinite/model/model.json
@ sed -i 's/"sigma_rad": [^,]*/"sigma_rad": 1e-300/' sharp/model/model.json
sheen render nan --view 0,30 -o x.png
sheen render infinite --view 0,30 -o x.png
sheen render sharp --view 0,30 -o x.png

# a texture of no texels, of another mesh, cut off, and another picture in its place
@ sed -i 's/"texels_per_edge": [0-9]*/"texels_per_edge": 0/' texels/model/model.json
@ sed -i 's/"n_triangles": 1840/"n_triangles": 1/' triangles/model/model.json
@ head -c 3000 ok/model/texture.exr > cut/model/texture.exr
@ cp ok/model/board.exr board/model/texture.exr
sheen render texels --view 0,30 -o x.png
sheen render triangles --view 0,30 -o x.png
sheen render cut --view 0,30 -o x.png 2>&1 | sed 's|: Preparing.*||'
sheen render board --view 0,30 -o x.png
ls x.png x.glb

# a mesh of one triangle is a model like any other
@ printf 'v 0.1 -0.1 0.03\nv 0.1 0.1 0.03\nv -0.1 0 0.03\nf 1 2 3\n' > one.obj
@ sheen import one photos --poses transforms.json --mesh one.obj
@ sheen fit one
sheen render one --view 0,30 --size 64x48 -o one.png
@ sheen export one -o one.glb
@ sheen export one -o one.obj

# lenses for which a format has a place, and those for which pictures are straightened
@ lens() { cp -r one $1; sed -i "s/PINHOLE/$2/; s/23.5,\]/23.5, $3]/" $1/camera.cameramodel; }; lens five OPENCV5 "0.01, 0, 0.001, 0, 0.002"; lens eight OPENCV8 "0.01, 0, 0.001, 0, 0.002, 0, 0.003, 0"; lens cahvor CAHVOR "0, 0, 0, 0.01, 0"; lens splined SPLINED_STEREOGRAPHIC_order=3_Nx=4_Ny=4_fov_x_deg=40 "$(yes 0.01, | head -n 32 | tr -d '\n')"
for k in one five eight cahvor splined; do sheen export $k -o $k/out/colmap/; tail -n 1 $k/out/colmap/sparse/0/cameras.txt; done
for k in one five eight cahvor splined; do sheen export $k -o $k/out/transforms.json; grep -E 'camera_model|"k1"' $k/out/transforms.json; done
