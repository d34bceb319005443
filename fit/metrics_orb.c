// SPDX-License-Identifier: Apache-2.0
// metrics_orb.c - the Stanford-ORB measures; see metrics.h for their definition.
#include "fit/metrics.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct pair {
    const sheen_image *rendered, *photo;
    uint8_t *mask; // eroded
    size_t n, n_masked;
    double scale[3]; // of the rendered picture's channels
} pair;

// Pixels of the mask within `reach` px of (x, y) in both directions; those that do not exist are not counted.
static int masked_near(const uint8_t *mask, int x, int y, int reach, int width_px, int height_px,
                       int *n_exist)
{
    const int x0 = x < reach ? 0 : x - reach, x1 = x + reach < width_px ? x + reach : width_px - 1;
    const int y0 = y < reach ? 0 : y - reach, y1 = y + reach < height_px ? y + reach : height_px - 1;
    int n = 0;
    for (int v = y0; v <= y1; v++)
        for (int u = x0; u <= x1; u++)
            n += mask[(size_t)v * (size_t)width_px + (size_t)u] != 0;
    if (n_exist)
        *n_exist = (x1 - x0 + 1) * (y1 - y0 + 1);
    return n;
}

// 1 where all of the 5x5 neighbours that exist are in the mask; out holds zeros before.
static void erode(uint8_t *out, const uint8_t *mask, int width_px, int height_px)
{
    for (int y = 0; y < height_px; y++)
        for (int x = 0; x < width_px; x++) {
            const size_t i = (size_t)y * (size_t)width_px + (size_t)x;
            int n_exist;
            if (mask[i])
                out[i] = masked_near(mask, x, y, 2, width_px, height_px, &n_exist) == n_exist;
        }
}

static double photo_at(const pair *p, size_t i, size_t c)
{
    return fmax(0, (double)p->photo->data[3 * i + c]);
}

static double rendered_at(const pair *p, size_t i, size_t c)
{
    return (double)p->rendered->data[3 * i + c];
}

static double code(double x)
{
    return (double)sheen_transfer_encode(SHEEN_TRANSFER_SRGB, (float)x);
}

// A channel that is black is taken as 1 everywhere for the sake of its scale, as the benchmark does.
static void fit_scales(pair *p)
{
    for (size_t c = 0; c < 3; c++) {
        double ab = 0, bb = 0, a = 0;
        for (size_t i = 0; i < p->n; i++) {
            if (!p->mask[i])
                continue;
            const double r = rendered_at(p, i, c), q = photo_at(p, i, c);
            ab += r * q;
            bb += r * r;
            a += q;
        }
        p->scale[c] = bb > 1e-6 ? ab / bb : a / (double)p->n_masked;
    }
}

// mean(sRGB(photo)) / mean(photo), of the photograph clipped to 0..1.
static double brightening(const pair *p)
{
    double linear = 0, coded = 0;
    for (size_t i = 0; i < p->n; i++)
        for (size_t c = 0; c < 3 && p->mask[i]; c++) {
            const double q = fmin(1, photo_at(p, i, c));
            linear += q;
            coded += code(q);
        }
    return linear / (3 * (double)p->n) > 1e-8 ? coded / linear : 1;
}

static double psnr_db(const pair *p, double gain, double max, int coded)
{
    double sum = 0, flat = 0;
    for (size_t i = 0; i < p->n; i++)
        for (size_t c = 0; c < 3 && p->mask[i]; c++) {
            double r = fmin(max, fmax(0, rendered_at(p, i, c) * p->scale[c] * gain));
            double q = fmin(max, photo_at(p, i, c) * gain);
            if (coded) {
                r = code(r);
                q = code(q);
            }
            sum += (r - q) * (r - q);
            flat += (0.5 - q) * (0.5 - q);
        }
    const double n = 3 * (double)p->n;
    return fmax(-10 * log10(sum / n), -10 * log10(flat / n));
}

// One channel of the two pictures of the LDR measure.
static void channel(float *r, float *q, const pair *p, size_t c)
{
    for (size_t i = 0; i < p->n; i++) {
        const int in = p->mask[i];
        r[i] = in ? (float)code(fmin(1, fmax(0, rendered_at(p, i, c) * p->scale[c]))) : 0;
        q[i] = in ? (float)code(fmin(1, photo_at(p, i, c))) : 0;
    }
}

// Index with mirrored borders that do not repeat the edge: -1 is 1, n is n - 2.
static int mirrored(int i, int n)
{
    const int j = i < 0 ? -i : i >= n ? 2 * n - 2 - i : i;
    return j < 0 ? 0 : j >= n ? n - 1 : j;
}

// SSIM of one channel, summed over its pixels (Wang et al. 2004; C1 = 0.01^2, C2 = 0.03^2). Far from the mask, where
// both are 0, it is the same number everywhere.
static double ssim_sum(const float *r, const float *q, const uint8_t *mask, int width_px, int height_px)
{
    const double c1 = 1e-4, c2 = 9e-4, blank = c1 * c2 / (c1 * c2 + 1e-12);
    const double e = exp(-1 / (2 * 1.5 * 1.5)), side = e / (1 + 2 * e), mid = 1 / (1 + 2 * e);
    const double w[3] = {side, mid, side};
    double sum = 0;
    for (int y = 0; y < height_px; y++)
        for (int x = 0; x < width_px; x++) {
            if (!masked_near(mask, x, y, 1, width_px, height_px, NULL)) {
                sum += blank;
                continue;
            }
            double mr = 0, mq = 0, rr = 0, qq = 0, rq = 0;
            for (int dy = -1; dy <= 1; dy++)
                for (int dx = -1; dx <= 1; dx++) {
                    const size_t i = (size_t)mirrored(y + dy, height_px) * (size_t)width_px +
                                     (size_t)mirrored(x + dx, width_px);
                    const double k = w[dy + 1] * w[dx + 1], a = (double)r[i], b = (double)q[i];
                    mr += k * a;
                    mq += k * b;
                    rr += k * a * a;
                    qq += k * b * b;
                    rq += k * a * b;
                }
            const double above = (2 * mr * mq + c1) * (2 * (rq - mr * mq) + c2);
            const double below = (mr * mr + mq * mq + c1) * (rr - mr * mr + qq - mq * mq + c2);
            sum += fmax(-1, fmin(1, above / (below + 1e-12)));
        }
    return sum;
}

sheen_status sheen_orb_of(sheen_orb *out, const sheen_image *rendered, const sheen_image *photo,
                          const uint8_t *mask, sheen_err *err)
{
    assert(rendered->width_px == photo->width_px && rendered->height_px == photo->height_px);
    assert(rendered->n_channels == 3 && photo->n_channels == 3);
    pair p = {.rendered = rendered, .photo = photo, .n = (size_t)photo->width_px * (size_t)photo->height_px};
    sheen_status s = SHEEN_OK;
    p.mask = calloc(p.n, 1);
    float *r = calloc(p.n, sizeof *r), *q = calloc(p.n, sizeof *q);
    if (!p.mask || !r || !q) {
        s = sheen_fail_memory(err, 9.0 * (double)p.n, "an evaluation");
        goto done;
    }
    erode(p.mask, mask, photo->width_px, photo->height_px);
    for (size_t i = 0; i < p.n; i++)
        p.n_masked += p.mask[i];
    if (!p.n_masked) {
        s = sheen_fail(err, SHEEN_EDATA, "the object is too small in the picture to be scored");
        goto done;
    }
    fit_scales(&p);
    out->hdr_db = psnr_db(&p, brightening(&p), 4, 0);
    out->ldr_db = psnr_db(&p, 1, 1, 1);
    out->ssim = 0;
    for (size_t c = 0; c < 3; c++) {
        channel(r, q, &p, c);
        out->ssim += ssim_sum(r, q, p.mask, photo->width_px, photo->height_px) / (3 * (double)p.n);
    }

done:
    free(p.mask);
    free(r);
    free(q);
    return s;
}
