// SPDX-License-Identifier: Apache-2.0
// extensions.c - names of the extensions.
#include "fit/extensions.h"

#include <string.h>

static const char *const names[SHEEN_EXTENSION_COUNT] = {"lamps", "shadows", "board", "ambient",   "fresnel",
                                                         "tail",  "regions", "poses", "exposures", "normals"};

const char *sheen_extension_name(sheen_extension e)
{
    return names[e];
}

static int is_word(const char *text, size_t length, const char *word)
{
    return strlen(word) == length && !strncmp(text, word, length);
}

sheen_status sheen_extensions_parse(sheen_extensions *out, const char *text, sheen_err *err)
{
    *out = 0;
    for (const char *at = text; *at;) {
        const size_t length = strcspn(at, ",");
        sheen_extensions bits = 0;
        for (int e = 0; e < SHEEN_EXTENSION_COUNT; e++)
            if (is_word(at, length, names[e]))
                bits = 1u << e;
        if (is_word(at, length, "align"))
            bits = 1u << SHEEN_EXTENSION_POSES | 1u << SHEEN_EXTENSION_EXPOSURES;
        if (!bits)
            return sheen_fail(
                err, SHEEN_EARG,
                "unknown extension '%.*s': there are lamps, shadows, board, ambient, fresnel, tail, "
                "regions, poses, exposures, normals, and align for poses and exposures",
                (int)(length < 40 ? length : 40), at);
        *out |= bits;
        at += length + (at[length] == ',');
    }
    return SHEEN_OK;
}
