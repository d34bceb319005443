# a table turned, and somebody carried the camera about it: noticed, and not fitted
@ data=$(dirname $cmd)/../data/penguin; cp -r $data walked; chmod -R u+w walked; rm walked/frames/test*; sheen calibrate walked
sheen pose walked --json > said; echo "exit code $?"; grep '"moved"' said
@ sed -i 's/"moving": "camera"/"moving": "object"/' walked/session.json
@ for i in 0 1 2 3 4 5 6 7; do sed -i "s/\"table_asked_deg\": null/\"table_asked_deg\": $((45 * i))/" walked/frames/in0$i.json; done
sheen pose walked --force --json > said; echo "exit code $?"; grep '"moved"' said
sheen run walked --no-film
ls walked/model
