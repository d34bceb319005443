#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A test in a virtual machine with real drivers: run.sh NAME BUILD SECONDS
#
# Boots Debian's stock kernel in qemu without KVM, on the host's own file system (read-only), and runs guest/NAME.sh
# there. The verdict comes through a file: none is a failure. What cannot run is skipped (77), and said.
name=$1 build=$2 seconds=$3
here=$(cd "$(dirname "$0")" && pwd)
kernel=$build/vm
mkdir -p "$kernel"

exec 9>"$kernel/lock"
flock 9
sh "$here/kernel.sh" "$kernel" "$here/init" || exit
flock -u 9

share=$(mktemp -d)
trap 'rm -rf "$share"' EXIT
# The machine sees this host's files, but has a /tmp of its own: what lies there goes through the share.
cp -r "$here/guest" "$share/"
mkdir "$share/bin"
for program in sheen make_recording usbip_camera usbredir_camera hotplug; do
    find "$build" -type f -name "$program" -perm -100 -exec cp {} "$share/bin/" \; 2>/dev/null
done
cp "$here/../../udev/"*.rules "$share/" 2>/dev/null
cat >"$share/start.sh" <<EOF
PATH=/tmp/share/bin:/usr/sbin:/usr/bin:/sbin:/bin
export PATH KERNEL=/tmp/kernel HOME=/tmp
cd /tmp
( . /tmp/share/guest/lib.sh; . /tmp/share/guest/$name.sh; finish ) >/tmp/share/log 2>&1
code=\$?
echo \$code >/tmp/share/verdict.new
mv /tmp/share/verdict.new /tmp/share/verdict
sync
exec busybox poweroff -f
EOF

# A part of the test that runs on this side: before and beside the machine; and its function `afterwards`.
host=$here/host/$name.sh
extra=
beside=
if [ -f "$host" ]; then
    # shellcheck source=/dev/null
    . "$host"
fi
# shellcheck disable=SC2086 # a list of words
timeout -k 5 "$seconds" qemu-system-x86_64 -M q35 -accel tcg,thread=multi,tb-size=256 -cpu max -smp 1 -m 512 \
    -nodefaults -no-user-config -display none -no-reboot -serial stdio \
    -kernel "$kernel/vmlinuz" -initrd "$kernel/initramfs.gz" \
    -append "console=ttyS0 quiet panic=-1 mitigations=off tsc=reliable" \
    -fsdev local,id=r,path=/,security_model=none,readonly=on,multidevs=remap \
    -device virtio-9p-pci,fsdev=r,mount_tag=hostroot \
    -fsdev local,id=s,path="$share",security_model=none,multidevs=remap \
    -device virtio-9p-pci,fsdev=s,mount_tag=share \
    -fsdev local,id=k,path="$kernel",security_model=none,readonly=on,multidevs=remap \
    -device virtio-9p-pci,fsdev=k,mount_tag=kernel $extra </dev/null >"$share/console" 2>&1
if [ -n "$beside" ]; then
    kill "$beside" 2>/dev/null
fi

cat "$share/log" 2>/dev/null
if [ ! -f "$share/verdict" ]; then
    echo "the machine gave no verdict within $seconds s; the end of its console:"
    tail -n 30 "$share/console"
    exit 1
fi
verdict=$(cat "$share/verdict")
if [ "$verdict" = 0 ] && command -v afterwards >/dev/null; then
    afterwards || verdict=1
fi
exit "$verdict"
