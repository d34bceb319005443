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
    int n_threads;
} sheen_export_args;

// Each writes its files, says what was made and what it lost, and notes a missed limit.
sheen_status sheen_export_page(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                               const sheen_cli_view *v, sheen_err *err);

// What a page shows besides the model: where the board is, and the camera's field of view.
void sheen_export_page_view(sheen_page_view *out, const sheen_cli_view *v);

#endif
