// SPDX-License-Identifier: Apache-2.0
// pack_avif.c - the one door to libavif.
//
// Colour is kept at full resolution (4:4:4): at half of it, as lossy WebP has it, the small patches of a global texture
// smear into each other. Luma and chroma by BT.601 in full range, the only matrix that all browsers decode alike.
#include "render/pack_avif.h"

#include <avif/avif.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

enum { SPEED = 6, DEPTH = 8 }; // speed: 0 (small) to 10

static sheen_status refuse_size(int width_px, int height_px, sheen_err *err)
{
    if (width_px >= 1 && height_px >= 1 && width_px <= SHEEN_AVIF_MAX_SIDE_PX &&
        height_px <= SHEEN_AVIF_MAX_SIDE_PX)
        return SHEEN_OK;
    return sheen_fail(err, SHEEN_EARG, "an AVIF picture of %d x %d px is out of range (1 to %d a side)",
                      width_px, height_px, SHEEN_AVIF_MAX_SIDE_PX);
}

static sheen_status failed(avifResult result, const char *verb, int width_px, int height_px, sheen_err *err)
{
    return sheen_fail(err, result == AVIF_RESULT_OUT_OF_MEMORY ? SHEEN_ENOMEM : SHEEN_EUNSUP,
                      "libavif cannot %s a picture of %d x %d px: %s", verb, width_px, height_px,
                      avifResultToString(result));
}

// libavif only reads what it is lent here.
static void lend(avifRGBImage *to, const avifImage *image, const uint8_t *rgb)
{
    avifRGBImageSetDefaults(to, image);
    to->format = AVIF_RGB_FORMAT_RGB;
    to->depth = DEPTH;
    memcpy(&to->pixels, &rgb, sizeof rgb);
    to->rowBytes = 3 * image->width;
}

static sheen_status encode(uint8_t **out, size_t *size_bytes, avifImage *image, const uint8_t *rgb,
                           int quantizer, int n_threads, sheen_err *err)
{
    avifRGBImage from;
    avifRWData coded = AVIF_DATA_EMPTY;
    avifEncoder *encoder = avifEncoderCreate();
    if (!encoder)
        return sheen_fail_memory(err, 1e5, "an encoder");
    encoder->maxThreads = n_threads > 0 ? n_threads : sheen_cpu_count();
    encoder->speed = SPEED;
    encoder->minQuantizer = encoder->maxQuantizer = quantizer;
    lend(&from, image, rgb);
    avifResult result = avifImageRGBToYUV(image, &from);
    if (result == AVIF_RESULT_OK)
        result = avifEncoderWrite(encoder, image, &coded);
    sheen_status s = SHEEN_OK;
    if (result != AVIF_RESULT_OK)
        s = failed(result, "code", (int)image->width, (int)image->height, err);
    else if (!(*out = malloc(coded.size + 1)))
        s = sheen_fail_memory(err, (double)coded.size, "a picture");
    if (!s) {
        memcpy(*out, coded.data, coded.size);
        *size_bytes = coded.size;
    }
    avifRWDataFree(&coded);
    avifEncoderDestroy(encoder);
    return s;
}

sheen_status sheen_avif_encode(uint8_t **out, size_t *size_bytes, const uint8_t *rgb, int width_px,
                               int height_px, int quantizer, int n_threads, sheen_err *err)
{
    *out = NULL;
    *size_bytes = 0;
    sheen_status s = refuse_size(width_px, height_px, err);
    if (s)
        return s;
    avifImage *image = avifImageCreate((uint32_t)width_px, (uint32_t)height_px, DEPTH,
                                       AVIF_PIXEL_FORMAT_YUV444);
    if (!image)
        return sheen_fail_memory(err, 1e3, "a picture");
    image->colorPrimaries = AVIF_COLOR_PRIMARIES_BT709;
    image->transferCharacteristics = AVIF_TRANSFER_CHARACTERISTICS_SRGB;
    image->matrixCoefficients = AVIF_MATRIX_COEFFICIENTS_BT601;
    image->yuvRange = AVIF_RANGE_FULL;
    s = encode(out, size_bytes, image, rgb, quantizer, n_threads, err);
    avifImageDestroy(image);
    return s;
}

static sheen_status decode(uint8_t **rgb, avifDecoder *decoder, int width_px, int height_px, sheen_err *err)
{
    avifRGBImage to;
    if (avifDecoderParse(decoder) != AVIF_RESULT_OK)
        return sheen_fail(err, SHEEN_EFORMAT, "the texture is no AVIF picture");
    const avifImage *image = decoder->image;
    if (image->width != (uint32_t)width_px || image->height != (uint32_t)height_px)
        return sheen_fail(err, SHEEN_EFORMAT, "the texture is %u x %u px, not %d x %d", image->width,
                          image->height, width_px, height_px);
    if (avifDecoderNextImage(decoder) != AVIF_RESULT_OK)
        return sheen_fail(err, SHEEN_EFORMAT, "the texture is damaged or cut short");
    const size_t room_bytes = 3 * (size_t)width_px * (size_t)height_px;
    if (!(*rgb = malloc(room_bytes)))
        return sheen_fail_memory(err, (double)room_bytes, "a picture");
    lend(&to, image, *rgb);
    const avifResult result = avifImageYUVToRGB(image, &to);
    if (result == AVIF_RESULT_OK)
        return SHEEN_OK;
    free(*rgb);
    *rgb = NULL;
    return failed(result, "decode", width_px, height_px, err);
}

sheen_status sheen_avif_decode(uint8_t **rgb, const void *data, size_t size_bytes, int width_px,
                               int height_px, sheen_err *err)
{
    *rgb = NULL;
    sheen_status s = refuse_size(width_px, height_px, err);
    if (s)
        return s;
    avifDecoder *decoder = avifDecoderCreate();
    if (!decoder)
        return sheen_fail_memory(err, 1e5, "a decoder");
    const size_t n = (size_t)width_px * (size_t)height_px; // nothing larger is begun
    if (n < AVIF_DEFAULT_IMAGE_SIZE_LIMIT)
        decoder->imageSizeLimit = (uint32_t)n;
    decoder->ignoreExif = decoder->ignoreXMP = AVIF_TRUE;
    decoder->maxThreads = 1;
    if (avifDecoderSetIOMemory(decoder, data, size_bytes) != AVIF_RESULT_OK)
        s = sheen_fail_memory(err, 1e3, "a decoder");
    else
        s = decode(rgb, decoder, width_px, height_px, err);
    avifDecoderDestroy(decoder);
    return s;
}
