// SPDX-License-Identifier: Apache-2.0
// vec.h - 3-vectors: the few operations that geometry and shading are made of.
#ifndef SHEEN_BASE_VEC_H
#define SHEEN_BASE_VEC_H

#include <math.h>

static inline double sheen_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void sheen_cross(double out[3], const double a[3], const double b[3])
{
    const double x = a[1] * b[2] - a[2] * b[1];
    const double y = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
}

static inline void sheen_sub(double out[3], const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] - b[i];
}

static inline double sheen_norm(const double a[3])
{
    return sqrt(sheen_dot(a, a));
}

// Scales a to length 1 and returns the length it had; a zero vector stays zero.
static inline double sheen_normalize(double a[3])
{
    const double n = sheen_norm(a);
    if (n > 0)
        for (int i = 0; i < 3; i++)
            a[i] /= n;
    return n;
}

static inline float sheen_dotf(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void sheen_crossf(float out[3], const float a[3], const float b[3])
{
    const float x = a[1] * b[2] - a[2] * b[1];
    const float y = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
}

static inline void sheen_subf(float out[3], const float a[3], const float b[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] - b[i];
}

static inline float sheen_normalizef(float a[3])
{
    const float n = sqrtf(sheen_dotf(a, a));
    if (n > 0)
        for (int i = 0; i < 3; i++)
            a[i] /= n;
    return n;
}

// Unit a and b at right angles to the unit direction d, a = e x d / |e x d| (e: the axis of d's smallest component, the
// first of equals), b = d x a. Files with normal maps rely on it.
static inline void sheen_axes_aboutf(float a[3], float b[3], const float d[3])
{
    float e[3] = {0, 0, 0};
    const float x = fabsf(d[0]), y = fabsf(d[1]), z = fabsf(d[2]);
    e[x <= y && x <= z ? 0 : y <= z ? 1 : 2] = 1;
    sheen_crossf(a, e, d);
    sheen_normalizef(a);
    sheen_crossf(b, d, a);
}

// The direction in which v (pointing away from the surface) is mirrored about
// the unit normal n: 2 (n.v) n - v.
static inline void sheen_mirrorf(float out[3], const float n[3], const float v[3])
{
    const float k = 2.0f * sheen_dotf(n, v);
    for (int i = 0; i < 3; i++)
        out[i] = k * n[i] - v[i];
}

#endif
