# SPDX-License-Identifier: Apache-2.0
# lib.sh - what the tests in the machine share. Sourced; every check says what it wanted.
failures=0
checks=0

check() { # WHAT COMMAND...
    what=$1
    shift
    checks=$((checks + 1))
    if "$@"; then
        echo "ok: $what ($(cut -d " " -f 1 /proc/uptime))"
    else
        echo "FAILED: $what"
        [ ! -s err ] || sed 's/^/    /' err
        failures=$((failures + 1))
    fi
}

finish() {
    echo "$checks checks, $failures failed ($(cut -d. -f1 /proc/uptime) s after the machine's start)"
    [ "$failures" = 0 ] && [ "$checks" != 0 ]
}

load() {
    modprobe -d "$KERNEL" "$@"
}

# Waits for at most so many seconds until a command succeeds.
wait_for() { # SECONDS COMMAND...
    tries=$(($1 * 10))
    shift
    while [ $tries -gt 0 ]; do
        "$@" >/dev/null 2>&1 && return 0
        sleep 0.1
        tries=$((tries - 1))
    done
    return 1
}

start_udev() { # with the rules of the project beside the system's
    mkdir -p /run/udev/rules.d
    cp /tmp/share/*.rules /run/udev/rules.d/
    /lib/systemd/systemd-udevd --daemon
    udevadm trigger --action=add --subsystem-match=video4linux --subsystem-match=usb --subsystem-match=tty
    udevadm settle -t 20
}

# A capture that must work, and one that must fail with status 1 and a sentence that has this in it.
captures() { # SESSION URI COUNT
    sheen capture "$1" --device "$2" --count "$3" --json >out 2>err
}

fails_with() { # WORDS SESSION URI COUNT
    words=$1
    shift
    captures "$@"
    [ $? = 1 ] && grep -q "$words" err && ! grep -q 'Sanitizer' err
}

# camera_frames of the last capture's answer
counted() { # WHICH
    sed -n "s/.*\"$1\": *\([0-9]*\).*/\1/p" out | head -n 1
}

frames_in() { # SESSION
    find "$1/frames" -name '*.json' | wc -l
}

gaps_are() { # SESSION MOST: the driver's numbers of its frames rise, and lack at most so many
    cat "$1"/frames/*.json | sed -n 's/.*"sequence": *\([0-9]*\).*/\1/p' |
        awk -v most="$2" 'FNR > 1 { lack += $1 - last - 1; bad = bad || $1 <= last } { last = $1 } END { exit bad || lack > most }'
}

digests() { # SESSION: of its payloads, in the order of their names
    for sidecar in "$1"/frames/*.json; do
        sed -n 's/.*"payload_digest": *"\([0-9a-f]*\)".*/\1/p' "$sidecar"
    done
}

# Every frame of SESSION is one of the recorded ones.
all_recorded() { # SESSION RECORDING
    digests "$2" | sort -u >recorded
    digests "$1" >got
    [ -s got ] && ! sort -u got | comm -23 - recorded | grep -q .
}

# And each is the successor of the one before, in a loop. Ones that were dropped are jumped over: at most so many.
in_order() { # SESSION RECORDING MOST_JUMPED
    digests "$2" >recorded
    digests "$1" >got
    awk -v most="$3" 'NR == FNR { place[$1] = NR; n = NR; next }
        !($1 in place) { bad = 1 }
        FNR > 1 { jumped += (place[$1] - last - 1 + n) % n }
        { last = place[$1] }
        END { print "jumped over " jumped + 0; exit bad || FNR < 2 || jumped > most }' recorded got
}

gadget=/sys/kernel/config/usb_gadget/turntable

make_gadget() { # a turntable at the machine's own USB: its end is /dev/ttyGS0
    mount -t configfs configfs /sys/kernel/config
    mkdir $gadget
    cd $gadget || return
    echo 0x1d6b >idVendor
    echo 0x0104 >idProduct
    mkdir -p strings/0x409 configs/c.1 functions/acm.0
    echo TT-0001 >strings/0x409/serialnumber
    echo 'Turntable' >strings/0x409/product
    echo sheen >strings/0x409/manufacturer
    ln -s functions/acm.0 configs/c.1/
    cd /tmp || return
}

plug_gadget() {
    echo dummy_udc.0 >$gadget/UDC
}

unplug_gadget() {
    echo "" >$gadget/UDC
}

load_gadget() { # before start_udev: its drivers, and the rule that names it
    echo 'SUBSYSTEM=="tty", ATTRS{idVendor}=="1d6b", ATTRS{idProduct}=="0104", ATTRS{serial}=="TT-0001", ENV{SHEEN_TURNTABLE}="1"' \
        >/tmp/share/59-turntable.rules
    load dummy_hcd
    load libcomposite
    load usb_f_acm
    load cdc_acm
}
