// SPDX-License-Identifier: Apache-2.0
// irradiance.c - the harmonics' part of the diffuse light; shade.c adds the lamps, which take rays.
#include "render/irradiance.h"

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
