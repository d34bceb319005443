// SPDX-License-Identifier: Apache-2.0
// pack_webp.c - the one door to libwebp.
//
// Lossy WebP halves the chroma and works in blocks of 16 pixels, which would smear the small patches of a global
// texture into each other; so its lossless code is used.
#include "render/pack_webp.h"

#include <stdlib.h>
#include <string.h>
#include <webp/decode.h>
#include <webp/encode.h>

// 0 (fast) to 6 (small).
enum { METHOD = 4 };

static sheen_status refuse_size(int width_px, int height_px, sheen_err *err)
{
    if (width_px >= 1 && height_px >= 1 && width_px <= SHEEN_WEBP_MAX_SIDE_PX &&
        height_px <= SHEEN_WEBP_MAX_SIDE_PX)
        return SHEEN_OK;
    return sheen_fail(err, SHEEN_EARG, "a WebP picture of %d x %d px is out of range (1 to %d a side)",
                      width_px, height_px, SHEEN_WEBP_MAX_SIDE_PX);
}

sheen_status sheen_webp_encode(uint8_t **out, size_t *size_bytes, const uint8_t *rgb, int width_px,
                               int height_px, sheen_err *err)
{
    WebPConfig config;
    WebPPicture picture;
    WebPMemoryWriter writer;
    *out = NULL;
    *size_bytes = 0;
    sheen_status s = refuse_size(width_px, height_px, err);
    if (s)
        return s;
    if (!WebPConfigInit(&config) || !WebPPictureInit(&picture))
        return sheen_fail(err, SHEEN_EUNSUP, "libwebp is of another version than its header");
    WebPMemoryWriterInit(&writer);
    config.lossless = 1;
    config.exact = 1;
    config.method = METHOD;
    config.quality = 75; // of a lossless code: effort
    picture.use_argb = 1;
    picture.width = width_px;
    picture.height = height_px;
    picture.writer = WebPMemoryWrite;
    picture.custom_ptr = &writer;
    if (!WebPPictureImportRGB(&picture, rgb, 3 * width_px) || !WebPEncode(&config, &picture))
        s = sheen_fail(err, SHEEN_ENOMEM, "libwebp cannot code a picture of %d x %d px (its error %d)",
                       width_px, height_px, (int)picture.error_code);
    WebPPictureFree(&picture);
    if (!s && !(*out = malloc(writer.size + 1)))
        s = sheen_fail_memory(err, (double)writer.size, "a picture");
    if (!s) {
        memcpy(*out, writer.mem, writer.size);
        *size_bytes = writer.size;
    }
    WebPMemoryWriterClear(&writer);
    return s;
}

sheen_status sheen_webp_decode(uint8_t **rgb, const void *data, size_t size_bytes, int width_px,
                               int height_px, sheen_err *err)
{
    int w = 0, h = 0;
    *rgb = NULL;
    const sheen_status s = refuse_size(width_px, height_px, err);
    if (s)
        return s;
    if (!WebPGetInfo(data, size_bytes, &w, &h))
        return sheen_fail(err, SHEEN_EFORMAT, "the texture is no WebP picture");
    if (w != width_px || h != height_px)
        return sheen_fail(err, SHEEN_EFORMAT, "the texture is %d x %d px, not %d x %d", w, h, width_px,
                          height_px);
    const size_t room_bytes = 3 * (size_t)w * (size_t)h;
    *rgb = malloc(room_bytes);
    if (!*rgb)
        return sheen_fail_memory(err, (double)room_bytes, "a picture");
    if (WebPDecodeRGBInto(data, size_bytes, *rgb, room_bytes, 3 * w))
        return SHEEN_OK;
    free(*rgb);
    *rgb = NULL;
    return sheen_fail(err, SHEEN_EFORMAT, "the texture's WebP picture is damaged or cut short");
}
