// SPDX-License-Identifier: Apache-2.0
// export.h - the forms in which `sheen export` writes a model, each in its file export_<form>.c.
#ifndef SHEEN_CLI_EXPORT_H
#define SHEEN_CLI_EXPORT_H

#include "cli/cli.h"
#include "cli/stages.h"
#include "render/page.h"

typedef struct sheen_export_args {
    const char *output, *title;
    double max_loss_db, max_size_kb;
    int texels_per_edge; // 0: all
    int quantizer;       // -1: the finest that fits
    int n_lights;        // of a glTF file
    int n_photographs;   // in a page
    int n_threads;
} sheen_export_args;

// Each writes its files, says what was made and what it lost, and notes a missed limit.
sheen_status sheen_export_page(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                               const sheen_cli_view *v, sheen_err *err);

sheen_status sheen_export_obj(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                              const sheen_cli_view *v, sheen_err *err);
sheen_status sheen_export_ply(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                              const sheen_cli_view *v, sheen_err *err);
sheen_status sheen_export_transforms(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                                     const sheen_cli_view *v, sheen_err *err);
sheen_status sheen_export_colmap(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                                 const sheen_cli_view *v, sheen_err *err);
sheen_status sheen_export_gltf(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                               const sheen_cli_view *v, sheen_err *err);

// The given title, or the session's folder without the ending that our examples give it.
void sheen_export_title(char title[256], const sheen_export_args *a, const sheen_session *s);
// [n_vertices][4]: the texture at each vertex in sRGB; alpha 0 where no photograph saw it. The caller frees *out. ENOMEM.
sheen_status sheen_export_vertex_colours(uint8_t **out, const sheen_model *m, sheen_err *err);
// Azimuth and elevation from which an object is looked at first (export_first_view.c).
sheen_status sheen_export_first_view(double look_deg[2], const sheen_cli_view *v, const sheen_session *s,
                                     sheen_err *err);
// What a page shows besides the model: where the board is, and the camera's field of view.
void sheen_export_page_view(sheen_page_view *out, const sheen_cli_view *v);

#endif
