# what a person meets first, and what a mistyped command line is told
sheen --version | sed 's/[0-9.]*$/N/'
sheen
sheen frobnicate
sheen improt
sheen import --help
sheen import
sheen import s
sheen import s x.png --maks y
sheen import s x.png --zzz
sheen import s x.png --camera
sheen import s x.png --json=yes
sheen import s x.png --role king
sheen import s x.png --transfer ultraviolet
sheen import s x.png --moving moon
sheen capture s
sheen capture s --device replay:x --count none
sheen capture s --device replay:x --count 0
sheen capture s t --device replay:x
sheen capture s --device gphoto:x
sheen capture s --device v4l2:/dev/no-camera
sheen capture s --device replay:nowhere
sheen capture s --json --count
sheen capture s --json --device replay:nowhere
ls
# what does not go together
sheen capture s --device v4l2:/dev/video0 --auto --bracket 3
sheen capture s --device v4l2:/dev/video0 --dark --flat
sheen capture s --device v4l2:/dev/video0 --flat --count 3
