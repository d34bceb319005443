# SPDX-License-Identifier: Apache-2.0
# libcamera.sh - this side of the test: the simulated camera, plugged in while share/plugged exists. Sourced by run.sh.
# libcamera takes a USB camera for one only behind a controller of the machine's firmware, which vhci_hcd is not.
if [ ! -x "$share/bin/usbredir_camera" ]; then
    echo "no libusbredirparser-dev, or no libcamera-dev, when this was built"
    exit 77
fi
"$share/bin/make_recording" "$share/recorded.session" YUYV 320 240 6
"$share/bin/usbredir_camera" "$share/recorded.session" "$share/usb" "$share/plugged" 2>"$share/camera.log" &
beside=$!
extra="-device qemu-xhci,id=xhci -chardev socket,id=ur,path=$share/usb,server=on,wait=off -device usb-redir,chardev=ur,bus=xhci.0"
