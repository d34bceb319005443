// SPDX-License-Identifier: Apache-2.0
// extensions.h - what the refined method adds to the paper's, each with a name and a switch.
//
// Every extension is used by itself where it pays (docs/algorithm.md says by which test); a switch takes it out altogether.
#ifndef SHEEN_FIT_EXTENSIONS_H
#define SHEEN_FIT_EXTENSIONS_H

#include "base/status.h"

typedef enum sheen_extension {
    SHEEN_EXTENSION_LAMPS,     // lights with place and extent; without: the hemisphere's nodes
    SHEEN_EXTENSION_SHADOWS,   // the mesh hides lights from its own surface
    SHEEN_EXTENSION_BOARD,     // the plane z = 0 is mirrored
    SHEEN_EXTENSION_AMBIENT,   // so is a smooth room above it
    SHEEN_EXTENSION_FRESNEL,   // highlights grow at grazing angles
    SHEEN_EXTENSION_TAIL,      // and have GGX's tail
    SHEEN_EXTENSION_REGIONS,   // k_S by colour of texture
    SHEEN_EXTENSION_POSES,     // poses made to agree on the surface
    SHEEN_EXTENSION_EXPOSURES, // so exposures and white balance
    SHEEN_EXTENSION_NORMALS,   // finer than the mesh's
    SHEEN_EXTENSION_COUNT
} sheen_extension;

// A bit for each extension that is left out.
typedef unsigned sheen_extensions;

const char *sheen_extension_name(sheen_extension e); // "lamps", ...

static inline int sheen_extension_in(sheen_extensions without, sheen_extension e)
{
    return !(without >> e & 1);
}

// From names with commas between them ("lamps,tail"); "align" is poses and exposures. EARG, with the names there are.
sheen_status sheen_extensions_parse(sheen_extensions *out, const char *text, sheen_err *err);

#endif
