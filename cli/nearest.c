// SPDX-License-Identifier: Apache-2.0
// nearest.c - what a mistyped word was probably meant to be: the fewest insertions, removals, changes and swaps.
#include <string.h>

#include "cli/cli.h"

enum { MAX_WORD = 40 };

static size_t min2(size_t a, size_t b)
{
    return a < b ? a : b;
}

// Damerau-Levenshtein distance (optimal string alignment) of two words of at most MAX_WORD letters.
static size_t distance(const char *a, const char *b)
{
    const size_t n = strlen(a), m = strlen(b);
    size_t d[MAX_WORD + 1][MAX_WORD + 1];
    for (size_t i = 0; i <= n; i++)
        for (size_t j = 0; j <= m; j++) {
            if (!i || !j) {
                d[i][j] = i + j;
                continue;
            }
            const size_t changed = d[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            d[i][j] = min2(changed, 1 + min2(d[i - 1][j], d[i][j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                d[i][j] = min2(d[i][j], d[i - 2][j - 2] + 1);
        }
    return d[n][m];
}

const char *sheen_cli_nearest(const char *word, const char *const *candidates)
{
    const size_t n = strlen(word);
    const char *best = NULL;
    size_t best_distance = n < 4 ? 2 : 3; // must be better than this
    if (n < 2 || n > MAX_WORD)
        return NULL;
    for (; *candidates; candidates++) {
        if (strlen(*candidates) > MAX_WORD)
            continue;
        const size_t d = !strncmp(word, *candidates, n) ? 1 : distance(word, *candidates);
        if (d < best_distance) {
            best = *candidates;
            best_distance = d;
        }
    }
    return best;
}
