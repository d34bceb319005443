// SPDX-License-Identifier: Apache-2.0
// irradiance.c - the harmonics' part of the diffuse light; shade.c adds the lamps, which take rays.
#include "render/irradiance.h"

#include "base/vec.h"

int sheen_irradiance_terms(int degree)
{
    return (degree + 1) * (degree + 1);
}

void sheen_irradiance_ambient(float rgb[3], const sheen_irradiance *e, const float n_world[3])
{
    double basis[SHEEN_AMBIENT_TERMS];
    const int n = sheen_irradiance_terms(e->degree);
    sheen_ambient_basis(basis, n_world);
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int k = 0; k < n; k++)
            sum += basis[k] * e->rgb[k][c];
        rgb[c] = sum > 0 ? (float)sum : 0;
    }
}

float sheen_irradiance_lamp_cosine(float to_lamp_world[3], const sheen_irradiance_lamp *lamp,
                                   const float x_m[3], const float n_world[3])
{
    for (int i = 0; i < 3; i++)
        to_lamp_world[i] = lamp->l_world[i] - lamp->inverse_distance_per_m * x_m[i];
    const float length = sheen_normalizef(to_lamp_world), cosine = sheen_dotf(n_world, to_lamp_world);
    return cosine > 0 && length > 0 ? cosine / (length * length) : 0;
}
