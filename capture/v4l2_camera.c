// SPDX-License-Identifier: Apache-2.0
// v4l2_camera.c - a node's capabilities, and the negotiation of format, size and rate.
#include "capture/v4l2_camera.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include <linux/videodev2.h>

#include "base/pixel_format.h"
#include "capture/v4l2_error.h"

static const uint32_t max_frame_bytes = 512u << 20;
static const int64_t usual_interval_ns = 33333333;

static sheen_status check_capabilities(char device[128], const sheen_v4l2_io *io, int fd, const char *path,
                                       sheen_err *err)
{
    struct v4l2_capability c;
    memset(&c, 0, sizeof c);
    if (sheen_v4l2_ioctl(io, fd, VIDIOC_QUERYCAP, &c) < 0)
        return errno == ENOTTY || errno == EINVAL
                   ? sheen_fail(err, SHEEN_EUNSUP, "'%s' is no camera: 'sheen devices' lists the cameras",
                                path)
                   : sheen_v4l2_fail(err, errno, "ask about", path);
    const uint32_t caps = c.capabilities & V4L2_CAP_DEVICE_CAPS ? c.device_caps : c.capabilities;
    if (!(caps & V4L2_CAP_VIDEO_CAPTURE))
        return sheen_fail(
            err, SHEEN_EUNSUP,
            "'%s' captures no video (a camera has other nodes, too): 'sheen devices' lists those that do",
            path);
    if (!(caps & V4L2_CAP_STREAMING))
        return sheen_fail(err, SHEEN_EUNSUP, "'%s' cannot stream: its driver is too old", path);
    snprintf(device, 128, "%.31s (%.31s)", (const char *)c.card, (const char *)c.bus_info);
    return SHEEN_OK;
}

sheen_status sheen_v4l2_camera_open(int *fd_out, char device[128], const sheen_v4l2_io *io, const char *path,
                                    sheen_err *err)
{
    int fd;
    do
        fd = io->open(io->self, path);
    while (fd < 0 && errno == EINTR);
    if (fd < 0)
        return sheen_v4l2_fail(err, errno, "open", path);
    const sheen_status s = check_capabilities(device, io, fd, path, err);
    if (s)
        io->close(io->self, fd);
    *fd_out = s ? -1 : fd;
    return s;
}

bool sheen_v4l2_is_jpeg(uint32_t fourcc)
{
    return fourcc == V4L2_PIX_FMT_MJPEG || fourcc == V4L2_PIX_FMT_JPEG;
}

bool sheen_v4l2_is_recorded(uint32_t fourcc)
{
    return sheen_v4l2_is_jpeg(fourcc) || sheen_pixels_known(fourcc);
}

void sheen_v4l2_fourcc_text(char text[8], uint32_t fourcc)
{
    for (int i = 0; i < 4; i++) {
        const char c = (char)(fourcc >> (8 * i) & 0x7f);
        text[i] = '?';
        if (c >= ' ' && c < 0x7f)
            text[i] = c;
    }
    memcpy(text + 4, fourcc >> 31 ? "-BE" : "", fourcc >> 31 ? 4 : 1);
}

// The camera's formats in one line; the first that sheen records is *first (0: none).
static void list_formats(char text[200], uint32_t *first, const sheen_v4l2_io *io, int fd)
{
    text[0] = 0;
    *first = 0;
    for (uint32_t i = 0; i < 64; i++) {
        struct v4l2_fmtdesc d;
        char name[8];
        memset(&d, 0, sizeof d);
        d.index = i;
        d.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        if (sheen_v4l2_ioctl(io, fd, VIDIOC_ENUM_FMT, &d) < 0)
            return;
        sheen_v4l2_fourcc_text(name, d.pixelformat);
        const size_t n = strlen(text);
        snprintf(text + n, 200 - n, "%s%s", n ? " " : "", name);
        if (!*first && sheen_v4l2_is_recorded(d.pixelformat))
            *first = d.pixelformat;
    }
}

static sheen_status fail_format(const sheen_v4l2_options *o, const struct v4l2_pix_format *got,
                                const sheen_v4l2_io *io, int fd, sheen_err *err)
{
    char offered[200], name[8];
    uint32_t first;
    list_formats(offered, &first, io, fd);
    sheen_v4l2_fourcc_text(name, got->pixelformat);
    return sheen_fail(
        err, SHEEN_EUNSUP,
        "'%.100s' does not offer that: it would give %s of %lu x %lu px; its formats are %s, and "
        "'sheen devices' lists their sizes",
        o->path, name, (unsigned long)got->width, (unsigned long)got->height,
        offered[0] ? offered : "unknown");
}

static sheen_status set_format(struct v4l2_pix_format *pix, const sheen_v4l2_options *o,
                               const sheen_v4l2_io *io, int fd, sheen_err *err)
{
    struct v4l2_format f;
    memset(&f, 0, sizeof f);
    f.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (sheen_v4l2_ioctl(io, fd, VIDIOC_G_FMT, &f) < 0)
        return sheen_v4l2_fail(err, errno, "ask for the format of", o->path);
    if (o->fourcc)
        f.fmt.pix.pixelformat = o->fourcc;
    else if (!sheen_v4l2_is_recorded(f.fmt.pix.pixelformat)) {
        char offered[200];
        list_formats(offered, &f.fmt.pix.pixelformat, io, fd);
        if (!f.fmt.pix.pixelformat)
            return sheen_fail(err, SHEEN_EUNSUP, "'%.100s' has no format that sheen records: only %s",
                              o->path, offered);
    }
    if (o->width_px) {
        f.fmt.pix.width = (uint32_t)o->width_px;
        f.fmt.pix.height = (uint32_t)o->height_px;
    }
    const uint32_t fourcc = f.fmt.pix.pixelformat, width = f.fmt.pix.width, height = f.fmt.pix.height;
    f.fmt.pix.field = V4L2_FIELD_NONE;
    f.fmt.pix.bytesperline = f.fmt.pix.sizeimage = 0;
    f.fmt.pix.colorspace = V4L2_COLORSPACE_DEFAULT; // and what follows from it: the driver says what it is
    f.fmt.pix.xfer_func = f.fmt.pix.ycbcr_enc = f.fmt.pix.quantization = f.fmt.pix.flags = 0;
    if (sheen_v4l2_ioctl(io, fd, VIDIOC_S_FMT, &f) < 0)
        return errno == EINVAL ? fail_format(o, &f.fmt.pix, io, fd, err)
                               : sheen_v4l2_fail(err, errno, "set the format of", o->path);
    *pix = f.fmt.pix;
    if (pix->pixelformat != fourcc || (o->width_px && (pix->width != width || pix->height != height)))
        return fail_format(o, pix, io, fd, err);
    if (pix->field != V4L2_FIELD_NONE && pix->field != V4L2_FIELD_ANY)
        return sheen_fail(err, SHEEN_EUNSUP,
                          "'%.100s' gives interlaced pictures: it is no camera for measuring", o->path);
    return SHEEN_OK;
}

static sheen_status check_sizes(sheen_v4l2_format *f, const struct v4l2_pix_format *pix, const char *path,
                                sheen_err *err)
{
    if (pix->width < 1 || pix->height < 1 || pix->width > SHEEN_IMAGE_MAX_SIDE_PX ||
        pix->height > SHEEN_IMAGE_MAX_SIDE_PX || !pix->sizeimage || pix->sizeimage > max_frame_bytes ||
        pix->bytesperline > 16 * SHEEN_IMAGE_MAX_SIDE_PX)
        return sheen_fail(
            err, SHEEN_EIO, "'%.100s' claims frames of %lu x %lu px and %lu bytes: its driver is wrong", path,
            (unsigned long)pix->width, (unsigned long)pix->height, (unsigned long)pix->sizeimage);
    f->fourcc = pix->pixelformat;
    f->width_px = (int)pix->width;
    f->height_px = (int)pix->height;
    f->size_bytes = pix->sizeimage;
    f->stride_bytes = 0;
    f->needed_bytes = 0;
    f->color = (sheen_colorimetry){pix->colorspace, 0, 0, 0};
    if (pix->priv == V4L2_PIX_FMT_PRIV_MAGIC) // older drivers leave the rest undefined
        f->color = (sheen_colorimetry){pix->colorspace, pix->xfer_func, pix->ycbcr_enc, pix->quantization};
    if (sheen_v4l2_is_jpeg(f->fourcc))
        return SHEEN_OK;
    f->stride_bytes = (int)pix->bytesperline;
    if (!f->stride_bytes)
        f->stride_bytes = (int)sheen_pixels_stride(f->fourcc, f->width_px);
    const sheen_pixel_layout layout = {f->fourcc, f->width_px, f->height_px, f->stride_bytes, f->color};
    f->needed_bytes = sheen_pixels_size(&layout);
    if (!f->needed_bytes || f->needed_bytes > f->size_bytes)
        return sheen_fail(err, SHEEN_EIO,
                          "'%.100s' claims rows of %d bytes and frames of %zu: its driver is wrong", path,
                          f->stride_bytes, f->size_bytes);
    return SHEEN_OK;
}

static sheen_status set_rate(sheen_v4l2_format *f, const sheen_v4l2_options *o, const sheen_v4l2_io *io,
                             int fd, sheen_err *err)
{
    struct v4l2_streamparm p;
    memset(&p, 0, sizeof p);
    p.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    f->interval_ns = usual_interval_ns;
    if (o->rate_hz > 0) {
        p.parm.capture.timeperframe.numerator = 1000;
        p.parm.capture.timeperframe.denominator = (uint32_t)(1000 * o->rate_hz + 0.5);
    }
    if (sheen_v4l2_ioctl(io, fd, o->rate_hz > 0 ? VIDIOC_S_PARM : VIDIOC_G_PARM, &p) < 0) {
        if (errno == ENODEV)
            return sheen_v4l2_fail(err, errno, "set the rate of", o->path);
        return o->rate_hz > 0 ? sheen_fail(err, SHEEN_EUNSUP, "'%.100s' has no choice of rates", o->path)
                              : SHEEN_OK;
    }
    const struct v4l2_fract t = p.parm.capture.timeperframe;
    if (!t.numerator || !t.denominator)
        return SHEEN_OK;
    const double interval_s = (double)t.numerator / t.denominator;
    if (interval_s < 100)
        f->interval_ns = (int64_t)(1e9 * interval_s);
    if (o->rate_hz > 0 && (interval_s * o->rate_hz < 0.99 || interval_s * o->rate_hz > 1.01))
        return sheen_fail(
            err, SHEEN_EUNSUP,
            "'%.100s' gives %.4g frames a second at this size, not %.4g: 'sheen devices' lists its rates",
            o->path, 1 / interval_s, o->rate_hz);
    return SHEEN_OK;
}

sheen_status sheen_v4l2_camera_configure(sheen_v4l2_format *f, const sheen_v4l2_options *o,
                                         const sheen_v4l2_io *io, int fd, sheen_err *err)
{
    struct v4l2_pix_format pix = {0};
    *f = (sheen_v4l2_format){0};
    sheen_status s = set_format(&pix, o, io, fd, err);
    if (!s)
        s = check_sizes(f, &pix, o->path, err);
    sheen_v4l2_options_color(&f->color, o);
    return s ? s : set_rate(f, o, io, fd, err);
}
