# SPDX-License-Identifier: Apache-2.0
# udev.sh - the project's rules under the real systemd-udevd: a turntable (CDC-ACM), a camera's raw USB node, and what
# libusb tells of plugging.
property() { # NODE NAME
    udevadm info --query=property --name="$1" | sed -n "s/^$2=//p"
}

# A line to the controller and its answer. Without clocal an open waits for a carrier.
talks() {
    stty -F "$1" raw -echo clocal
    stty -F /dev/ttyGS0 raw -echo clocal
    timeout 10 sh -c 'exec 4<>/dev/ttyGS0; head -n 1 <&4 >heard; echo ok >&4; sleep 1' &
    timeout 10 sh -c "exec 3<>$1; sleep 1; echo version >&3; head -n 1 <&3 >answer"
    wait $!
    grep -q ok answer && grep -q version heard
}

load_gadget
load uvcvideo
load vhci-hcd
start_udev
hotplug >events &
listener=$!
make_gadget
plug_gadget
check "the turntable has its name" wait_for 10 test -c /dev/sheen/turntable
check "which leads to the serial port" test "$(readlink -f /dev/sheen/turntable)" = /dev/ttyACM0
check "of the group dialout, and nobody else's: $(stat -c '%A %G' /dev/ttyACM0)" \
    test "$(stat -c '%a %G' /dev/ttyACM0)" = '660 dialout'
check "ModemManager leaves it alone" test "$(property /dev/ttyACM0 ID_MM_DEVICE_IGNORE)" = 1
check "the person at the machine may use it" sh -c "udevadm info /dev/ttyACM0 | grep -q 'TAGS=.*:uaccess:'"
check "libusb tells of it" wait_for 5 grep -q '^arrived 1d6b:0104' events
check "it can be talked to" talks /dev/sheen/turntable
unplug_gadget
check "unplugged: the name is gone" wait_for 10 test ! -e /dev/sheen/turntable
check "libusb tells of that" wait_for 5 grep -q '^left 1d6b:0104' events
plug_gadget
check "plugged in again: the name is back" wait_for 10 test -c /dev/sheen/turntable

usbip_camera - 0 2>camera.log &
camera=$!
check "a camera is plugged in" wait_for 10 test -c /dev/video0
udevadm settle -t 10
sheen devices --json >out 2>err
check "sheen lists it with its port" grep -q '"usb_port": *"[0-9]' out
for usb in /sys/bus/usb/devices/*; do
    [ "$(cat "$usb/serial" 2>/dev/null)" = UVC-0001 ] && break
done
raw=$(printf '/dev/bus/usb/%03d/%03d' "$(cat "$usb/busnum")" "$(cat "$usb/devnum")")
check "its raw node is the group video's, and nobody else's: $(stat -c '%A %G' "$raw")" \
    test "$(stat -c '%a %G' "$raw")" = '660 video'
check "the person at the machine may reset it" sh -c "udevadm info $raw | grep -q 'TAGS=.*:uaccess:'"
check "the pictures' node too: $(stat -c '%A %G' /dev/video0)" test "$(stat -c '%a %G' /dev/video0)" = '660 video'
other=$(find /dev/bus/usb -type c ! -path "$raw" | head -n 1)
check "other USB devices are left alone: $(stat -c '%A %G' "$other")" test "$(stat -c '%G' "$other")" = root
kill $camera $listener
