// SPDX-License-Identifier: Apache-2.0
// refined_nodes.c - the step that estimates lights as nodes of the hemisphere, as the paper does, but shadowed by the mesh.
#include "fit/refined_state.h"

static int is_hidden(void *self, size_t i_sample, const float l_world[3])
{
    const sheen_refined_state *r = self;
    const sheen_shading *sh = &r->shading[r->node_samples.view[i_sample]];
    return sheen_shade_hidden(sh, r->node_samples.p_obj + 3 * i_sample,
                              r->node_samples.n_world + 3 * i_sample, l_world);
}

sheen_status sheen_refined_nodes(sheen_refined_state *r, float consistency, sheen_err *err)
{
    sheen_hemisphere_release(&r->f->combined);
    sheen_status s = sheen_hemisphere_combine(&r->f->combined, r->f->partials, r->f->n_views,
                                              (float)r->f->threshold_lin, consistency, err);
    if (s)
        return s;
    if (!r->f->combined.n_assigned)
        return sheen_fail(err, SHEEN_EDATA, "no highlight is left once the surroundings are accounted for");
    // From above again: the first fit stops short on either side. Where there was none, from the hemisphere.
    r->o.sigma0_rad = r->f->model.lights.count ? 2 * r->f->model.sigma_rad : 0;
    s = sheen_paper_lights(r->f, &r->node_samples, &r->o,
                           sheen_extension_in(r->o.without, SHEEN_EXTENSION_SHADOWS) ? is_hidden : NULL, r,
                           err);
    sheen_samples_release(&r->node_samples);
    return s;
}
