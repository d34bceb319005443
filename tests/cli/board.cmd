# a board to print, its measures, and what does not fit
sheen board
sheen board -o board.png
sheen board -o board.pdf --paper a4 --square-mm 25
sheen board -o board.pdf --first-id 560
sheen board -o board.pdf --paper a4 --blank-mm 80
sheen board -o ring.svg --paper a4 --squares 6x5 --count 2
sheen board -o board.pdf --measured-mm 215.1
sheen board -o board.pdf --measured-mm 100
sheen board -o none.pdf --measured-mm 100
ls
