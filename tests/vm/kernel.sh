#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Debian's own kernel, unpacked and not installed, with an initramfs that enters the host's file system:
#
#     kernel.sh FOLDER INIT      makes FOLDER/{version,vmlinuz,initramfs.gz,lib/modules}, once
#
# Exit status 77: it cannot be had here, with the reason.
folder=$1 init=$2

give_up() {
    echo "no virtual machine: $*"
    exit 77
}

[ -f "$folder/version" ] && [ -n "$(find "$folder/initramfs.gz" -newer "$init" 2>/dev/null)" ] && exit 0
[ "$(uname -m)" = x86_64 ] || give_up "this machine is not an amd64"
for program in qemu-system-x86_64:qemu-system-x86 busybox:busybox-static modprobe:kmod cpio:cpio apt-get:apt; do
    command -v "${program%:*}" >/dev/null || [ -x "/sbin/${program%:*}" ] ||
        give_up "${program#*:} is not installed (tools/install-packages vm)"
done
PATH=$PATH:/sbin:/usr/sbin
mkdir -p "$folder" && cd "$folder" || exit 2

if [ ! -f version ]; then
    # The meta package names the one with the kernel, which changes with every security update.
    package=$(apt-cache depends linux-image-amd64 2>/dev/null | awk '/Depends:/ { print $2; exit }')
    if [ -z "$package" ]; then
        [ "$(id -u)" = 0 ] && apt-get -q update </dev/null >/dev/null 2>&1
        package=$(apt-cache depends linux-image-amd64 2>/dev/null | awk '/Depends:/ { print $2; exit }')
    fi
    [ -n "$package" ] || give_up "apt knows no linux-image-amd64 (apt-get update)"
    apt-get -q download "$package" </dev/null >download.log 2>&1 || give_up "$package cannot be downloaded"
    rm -rf unpacked lib
    dpkg -x "$package"_*.deb unpacked || exit 2
    version=${package#linux-image-}
    mv "unpacked/boot/vmlinuz-$version" vmlinuz
    mv unpacked/lib .
    rm -rf unpacked "$package"_*.deb
    depmod -b . "$version" || exit 2
    echo "$version" >version.new
    mv version.new version
fi

version=$(cat version)
rm -rf initramfs
mkdir -p initramfs/bin initramfs/modules initramfs/proc initramfs/sys initramfs/dev initramfs/mnt
cp "$(command -v busybox)" initramfs/bin/
cp "$init" initramfs/init
n=100
for module in virtio_pci 9pnet_virtio 9p; do
    for file in $(modprobe -d . -S "$version" --show-depends $module | awk '$1 == "insmod" { print $2 }'); do
        name=$(basename "$file")
        ls initramfs/modules/*-"$name" >/dev/null 2>&1 && continue
        cp "$file" "initramfs/modules/$n-$name"
        n=$((n + 1))
    done
done
(cd initramfs && find . | cpio -o -H newc --quiet | gzip -1) >initramfs.new && mv initramfs.new initramfs.gz
rm -rf initramfs
