#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A file includes its own folder and lower layers, nothing else: layers.sh ROOT
# Siblings (capture, calib, render; pose, fit) never include each other.
cd "$1" || exit 2

# What each layer may include beside itself.
lower() {
    case $1 in
    base) echo ;;
    capture | calib | render) echo base ;;
    pose | fit) echo base capture calib render ;;
    cli) echo base capture calib render pose fit ;;
    esac
}

bad=0
for module in base capture calib render pose fit cli; do
    [ -d $module ] || continue
    allowed=" $module $(lower $module) "
    while read -r file include; do
        [ -n "$file" ] || continue
        case $include in
        */*) folder=${include%%/*} ;;
        *) folder="(none)" ;;
        esac
        case $allowed in
        *" $folder "*) ;;
        *)
            echo "$file must not include \"$include\""
            bad=1
            ;;
        esac
    done <<EOF
$(grep -rHoE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"[^"]+"' $module | sed -E 's/:[^"]*"([^"]+)"/ \1/')
EOF
done
exit $bad
