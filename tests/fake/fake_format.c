// SPDX-License-Identifier: Apache-2.0
// fake_format.c - what the fake camera is and delivers: capabilities, its one format, size and rate, its one input.
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "tests/fake/fake_parts.h"

static int query_caps(const fake_v4l2 *f, struct v4l2_capability *c)
{
    memset(c, 0, sizeof *c);
    snprintf((char *)c->driver, sizeof c->driver, "fake");
    snprintf((char *)c->card, sizeof c->card, "Fake Camera");
    snprintf((char *)c->bus_info, sizeof c->bus_info, "usb-0000:00:14.0-1");
    c->version = 6 << 16 | 1 << 8;
    c->device_caps = V4L2_CAP_STREAMING | V4L2_CAP_EXT_PIX_FORMAT |
                     (f->faults.no_capture ? V4L2_CAP_META_CAPTURE : V4L2_CAP_VIDEO_CAPTURE);
    // Of the whole device, as the kernel says it: what other nodes can do counts here.
    c->capabilities = c->device_caps | V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_DEVICE_CAPS;
    return 0;
}

static bool is_jpeg(uint32_t fourcc)
{
    return fourcc == V4L2_PIX_FMT_MJPEG || fourcc == V4L2_PIX_FMT_JPEG;
}

// The kernel's own words for it, which v4l2-compliance knows.
static void describe(char *text, size_t size_bytes, uint32_t fourcc)
{
    static const struct {
        uint32_t fourcc;
        const char *text;
    } plain[] = {
        {V4L2_PIX_FMT_YUYV, "YUYV 4:2:2"},        {V4L2_PIX_FMT_NV12, "Y/CbCr 4:2:0"},
        {V4L2_PIX_FMT_GREY, "8-bit Greyscale"},   {V4L2_PIX_FMT_Y10, "10-bit Greyscale"},
        {V4L2_PIX_FMT_Y12, "12-bit Greyscale"},   {V4L2_PIX_FMT_Y16, "16-bit Greyscale"},
        {V4L2_PIX_FMT_RGB24, "24-bit RGB 8-8-8"}, {V4L2_PIX_FMT_BGR24, "24-bit BGR 8-8-8"},
        {V4L2_PIX_FMT_MJPEG, "Motion-JPEG"},      {V4L2_PIX_FMT_JPEG, "JFIF JPEG"},
    };
    static const char *const order[] = {"BGBG/GRGR", "GBGB/RGRG", "GRGR/BGBG", "RGRG/GBGB"};
    static const struct {
        uint32_t fourcc[4];
        const char *bits, *packed;
    } mosaics[] = {
        {{V4L2_PIX_FMT_SBGGR8, V4L2_PIX_FMT_SGBRG8, V4L2_PIX_FMT_SGRBG8, V4L2_PIX_FMT_SRGGB8}, "8", ""},
        {{V4L2_PIX_FMT_SBGGR10, V4L2_PIX_FMT_SGBRG10, V4L2_PIX_FMT_SGRBG10, V4L2_PIX_FMT_SRGGB10}, "10", ""},
        {{V4L2_PIX_FMT_SBGGR10P, V4L2_PIX_FMT_SGBRG10P, V4L2_PIX_FMT_SGRBG10P, V4L2_PIX_FMT_SRGGB10P},
         "10",
         " Packed"},
        {{V4L2_PIX_FMT_SBGGR12, V4L2_PIX_FMT_SGBRG12, V4L2_PIX_FMT_SGRBG12, V4L2_PIX_FMT_SRGGB12}, "12", ""},
        {{V4L2_PIX_FMT_SBGGR12P, V4L2_PIX_FMT_SGBRG12P, V4L2_PIX_FMT_SGRBG12P, V4L2_PIX_FMT_SRGGB12P},
         "12",
         " Packed"},
        {{V4L2_PIX_FMT_SBGGR14, V4L2_PIX_FMT_SGBRG14, V4L2_PIX_FMT_SGRBG14, V4L2_PIX_FMT_SRGGB14}, "14", ""},
        {{V4L2_PIX_FMT_SBGGR16, V4L2_PIX_FMT_SGBRG16, V4L2_PIX_FMT_SGRBG16, V4L2_PIX_FMT_SRGGB16}, "16", ""},
    };
    snprintf(text, size_bytes, "the only one");
    for (size_t i = 0; i < sizeof plain / sizeof *plain; i++)
        if (plain[i].fourcc == fourcc)
            snprintf(text, size_bytes, "%s", plain[i].text);
    for (size_t i = 0; i < sizeof mosaics / sizeof *mosaics; i++)
        for (int k = 0; k < 4; k++)
            if (mosaics[i].fourcc[k] == fourcc)
                snprintf(text, size_bytes, "%s-bit Bayer %s%s", mosaics[i].bits, order[k], mosaics[i].packed);
}

static int format(fake_v4l2 *f, struct v4l2_format *v, bool set)
{
    if (v->type != V4L2_BUF_TYPE_VIDEO_CAPTURE)
        return EINVAL;
    if (set && f->n_buffers)
        return EBUSY;
    memset(&v->fmt, 0, sizeof v->fmt);
    v->fmt.pix.width = (uint32_t)f->width_px;
    v->fmt.pix.height = (uint32_t)f->height_px;
    v->fmt.pix.pixelformat = f->fourcc;
    v->fmt.pix.field = V4L2_FIELD_NONE;
    v->fmt.pix.bytesperline = is_jpeg(f->fourcc) ? 0 : (uint32_t)f->stride_bytes;
    v->fmt.pix.sizeimage = (uint32_t)fake_v4l2_frame_bytes(f);
    v->fmt.pix.colorspace = f->color.colorspace;
    v->fmt.pix.priv = V4L2_PIX_FMT_PRIV_MAGIC;
    v->fmt.pix.xfer_func = f->color.xfer_func;
    v->fmt.pix.ycbcr_enc = f->color.ycbcr_enc;
    v->fmt.pix.quantization = f->color.quantization;
    return 0;
}

static int enum_format(const fake_v4l2 *f, struct v4l2_fmtdesc *d)
{
    if (d->index || d->type != V4L2_BUF_TYPE_VIDEO_CAPTURE)
        return EINVAL;
    memset(d, 0, sizeof *d);
    d->type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    d->pixelformat = f->fourcc;
    d->flags = is_jpeg(f->fourcc) ? V4L2_FMT_FLAG_COMPRESSED : 0;
    describe((char *)d->description, sizeof d->description, f->fourcc);
    return 0;
}

static int enum_size(const fake_v4l2 *f, struct v4l2_frmsizeenum *e)
{
    if (e->index || e->pixel_format != f->fourcc)
        return EINVAL;
    memset(&e->discrete, 0, sizeof *e - offsetof(struct v4l2_frmsizeenum, discrete));
    e->type = V4L2_FRMSIZE_TYPE_DISCRETE;
    e->discrete.width = (uint32_t)f->width_px;
    e->discrete.height = (uint32_t)f->height_px;
    return 0;
}

static struct v4l2_fract interval(const fake_v4l2 *f)
{
    return (struct v4l2_fract){(uint32_t)(f->interval_ns / 1000), 1000000};
}

static int enum_interval(const fake_v4l2 *f, struct v4l2_frmivalenum *e)
{
    if (e->index || e->pixel_format != f->fourcc || e->width != (uint32_t)f->width_px ||
        e->height != (uint32_t)f->height_px)
        return EINVAL;
    memset(&e->discrete, 0, sizeof *e - offsetof(struct v4l2_frmivalenum, discrete));
    e->type = V4L2_FRMIVAL_TYPE_DISCRETE;
    e->discrete = interval(f);
    return 0;
}

static int rate(const fake_v4l2 *f, struct v4l2_streamparm *p)
{
    if (p->type != V4L2_BUF_TYPE_VIDEO_CAPTURE)
        return EINVAL;
    memset(&p->parm, 0, sizeof p->parm);
    p->parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
    p->parm.capture.timeperframe = interval(f);
    return 0;
}

static int enum_input(struct v4l2_input *in)
{
    if (in->index)
        return EINVAL;
    memset(in, 0, sizeof *in);
    snprintf((char *)in->name, sizeof in->name, "Camera 1");
    in->type = V4L2_INPUT_TYPE_CAMERA;
    return 0;
}

int fake_format_call(fake_v4l2 *f, unsigned long request, void *arg)
{
    switch (request) {
    case VIDIOC_QUERYCAP:
        return query_caps(f, arg);
    case VIDIOC_ENUM_FMT:
        return enum_format(f, arg);
    case VIDIOC_ENUM_FRAMESIZES:
        return enum_size(f, arg);
    case VIDIOC_ENUM_FRAMEINTERVALS:
        return enum_interval(f, arg);
    case VIDIOC_G_FMT:
    case VIDIOC_TRY_FMT:
    case VIDIOC_S_FMT:
        return format(f, arg, request == VIDIOC_S_FMT);
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM:
        return rate(f, arg);
    case VIDIOC_ENUMINPUT:
        return enum_input(arg);
    case VIDIOC_G_INPUT:
        *(int *)arg = 0;
        return 0;
    case VIDIOC_S_INPUT:
        return *(const int *)arg ? EINVAL : 0;
    default:
        return ENOTTY;
    }
}
