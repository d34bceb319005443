// SPDX-License-Identifier: Apache-2.0
// exact_shade.c - the specular light of an exact scene, in double precision, written out from the formulas.
#include <math.h>

#include "base/vec.h"
#include "tests/fit/exact_scene.h"

enum { DISC_POINTS = 37 };

static const double f0 = 0.04;

// Smith's shadowing and masking for GGX, height-correlated, times 4 cos_i cos_r over what makes it 1 straight on.
static double ggx_visibility(double cos_i, double cos_r, double alpha)
{
    const double a2 = alpha * alpha;
    const double i = cos_r * sqrt(a2 + (1 - a2) * cos_i * cos_i),
                 r = cos_i * sqrt(a2 + (1 - a2) * cos_r * cos_r);
    return 2 * cos_i * cos_r / (i + r);
}

// Reflected radiance for a unit light: D F G / (4 cos_r), scaled to 1 where normal, camera and light fall together.
static double ggx(const double n[3], const double v[3], const double l[3], const double h[3], double alpha)
{
    const double cos_i = sheen_dot(n, l), cos_r = sheen_dot(n, v), cos_h = sheen_dot(n, h),
                 a2 = alpha * alpha;
    double across[3];
    sheen_cross(across, n, h);
    const double below = a2 * cos_h * cos_h + sheen_dot(across, across); // (a2 - 1) cos^2 + 1
    const double D = a2 * a2 / (below * below);
    const double F = 1 + (1 / f0 - 1) * pow(1 - sheen_dot(v, h), 5);
    return D * F * ggx_visibility(cos_i, cos_r, alpha) / cos_r;
}

// Eq. (7): the Gaussian of the angle between normal and bisector, over cos(theta_r) held at 0.2.
static double lobe(const double n[3], const double v[3], const double h[3], double sigma_rad)
{
    double across[3];
    sheen_cross(across, n, h);
    const double alpha_rad = atan2(sheen_norm(across), sheen_dot(n, h)), cos_r = sheen_dot(n, v);
    return exp(-alpha_rad * alpha_rad / (2 * sigma_rad * sigma_rad)) / (cos_r > 0.2 ? cos_r : 0.2);
}

// Point k of a sunflower's spiral on the light's disc (k 0: its middle), as a place relative to a light at distance 1.
static void disc_point(double x[3], const exact_light *light, int k)
{
    const double golden_rad = 2.399963229728653;
    const double r = k ? tan(light->radius_rad) * sqrt((k - 0.5) / (DISC_POINTS - 1)) : 0, a = k * golden_rad;
    double across[3], along[3];
    const double up[3] = {0, 0, 1};
    sheen_cross(across, up, light->v_world);
    sheen_normalize(across);
    sheen_cross(along, light->v_world, across);
    for (int i = 0; i < 3; i++)
        x[i] = light->v_world[i] + r * (cos(a) * across[i] + sin(a) * along[i]);
}

// Term of one point of a light; *alpha_rad: angle between normal and bisector.
static double point_term(double *alpha_rad, const exact_scene *s, const exact_light *light, int k,
                         const double p[3], const double n[3], const double v[3])
{
    double l[3], h[3], falloff = 1, across[3];
    disc_point(l, light, k);
    if (isfinite(light->distance_m)) {
        for (int i = 0; i < 3; i++)
            l[i] = light->distance_m * l[i] - p[i];
        const double d = light->distance_m / sheen_norm(l);
        falloff = d * d;
    }
    sheen_normalize(l);
    for (int i = 0; i < 3; i++)
        h[i] = l[i] + v[i];
    sheen_normalize(h);
    sheen_cross(across, n, h);
    *alpha_rad = atan2(sheen_norm(across), sheen_dot(n, h));
    if (!(sheen_dot(n, l) > 0))
        return 0;
    return falloff * (s->o.ggx_alpha > 0 ? ggx(n, v, l, h, s->o.ggx_alpha) : lobe(n, v, h, s->o.sigma_rad));
}

void exact_room(double rgb[3], const exact_scene *s, const double v_world[3])
{
    const double up = fmax(0, v_world[2]), side = 1 + sheen_dot(v_world, s->room_side_world) / 3;
    for (int c = 0; c < 3; c++)
        rgb[c] = s->room_rgb[c] * up * side;
}

void exact_specular(double rgb[3], const exact_scene *s, const double p[3], const double n[3],
                    const double v[3], const int hidden[EXACT_LIGHTS])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    if (!(sheen_dot(n, v) > 0))
        return;
    for (int i = 0; i < EXACT_LIGHTS; i++) {
        const exact_light *light = &s->lights[i];
        if (hidden[i])
            continue;
        double alpha_rad, other_rad;
        double term = point_term(&alpha_rad, s, light, 0, p, n, v);
        // Further off its width does not show, and the Gaussian has ended
        const double width = s->o.ggx_alpha > 0 ? s->o.ggx_alpha : s->o.sigma_rad;
        if (light->radius_rad > 0 && alpha_rad < 7 * width + light->radius_rad) {
            for (int k = 1; k < DISC_POINTS; k++)
                term += point_term(&other_rad, s, light, k, p, n, v);
            term /= DISC_POINTS;
        }
        for (int c = 0; c < 3; c++)
            rgb[c] += term * light->rgb[c];
    }
}
