// SPDX-License-Identifier: Apache-2.0
// v4l2_quirks.c - the table of cameras that are known to claim what is not so, each with who says so.
//
// Of colours it has none: the cameras that the kernel lists as naming a wrong pixel format are mended by its driver
// (uvc_ids in uvc_driver.c: 2833:0201 and 2833:0211), and full range in MJPEG, which several were reported for
// (pikvm/ustreamer issue 157), is what is taken without a word.
#include "capture/v4l2_quirks.h"

#include <stddef.h>
#include <string.h>

typedef struct quirk {
    const char *usb_id; // vendor and product; NULL: any
    const char *name;   // part of the camera's name; "": any
    const char *options;
} quirk;

static const quirk quirks[] = {
    // Drivers that offer 500 ms: beyond these the picture stays as it is. PhotonVision, classes ArduOV9281CameraSettables,
    // ArduOV2311..., ArduOV9782..., InnoOV9281..., See3Cam24CUGSettables ("property limits are incorrect").
    {"0c45:6366", "OV9281", "exposure_most_ms=7.5"},
    {"0c45:6366", "OV2311", "exposure_most_ms=14"},
    {"0c45:6366", "OV9782", "exposure_most_ms=6"},
    {"0c45:636d", "USB Camera", "exposure_most_ms=50"},
    {"2560:c128", "", "exposure_most_ms=60"},
    // Say yes to every exposure, and take the nearest of eight. PhotonVision, class LifeCam3kCameraSettables.
    {NULL, "LifeCam HD-3000", "exposures_ms=0.5,1,2,3.9,7.8,15.6,31.2,62.5"},
    {NULL, "LifeCam Cinema", "exposures_ms=0.5,1,2,3.9,7.8,15.6,31.2,62.5"},
};

const char *sheen_v4l2_quirk(const char *identity, const char *name)
{
    const size_t n = strcspn(identity, " ");
    for (size_t i = 0; i < sizeof quirks / sizeof *quirks; i++) {
        const quirk *q = &quirks[i];
        if (q->usb_id && (strlen(q->usb_id) != n || strncmp(q->usb_id, identity, n) != 0))
            continue;
        if (strstr(name, q->name))
            return q->options;
    }
    return NULL;
}
