// SPDX-License-Identifier: Apache-2.0
// replay_corpus.c - stands in for libFuzzer: gives every file of a folder, and every way to cut it short,
// to the fuzz target.
//
// Cut files are the fault that happens most (a full disk, an interrupted copy), so each input is tried at
// up to 64 lengths as well. The input lies at the end of its own allocation, where AddressSanitizer sees
// the first byte read beyond it.
#include <dirent.h>
#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fuzz/fuzz.h"

enum { MAX_INPUT_BYTES = 64 << 20, N_CUTS = 64 };

static int give(const uint8_t *data, size_t size_bytes)
{
    uint8_t *copy = malloc(size_bytes ? size_bytes : 1);
    if (!copy)
        return -1;
    if (size_bytes)
        memcpy(copy, data, size_bytes);
    LLVMFuzzerTestOneInput(copy, size_bytes);
    free(copy);
    return 0;
}

static int replay(const char *path)
{
    int result = -1;
    uint8_t *data = NULL;
    FILE *f = fopen(path, "rb");
    if (!f)
        goto done;
    data = malloc(MAX_INPUT_BYTES);
    if (!data)
        goto done;
    const size_t size_bytes = fread(data, 1, MAX_INPUT_BYTES, f);
    if (ferror(f) || !feof(f))
        goto done;
    result = give(data, size_bytes);
    const size_t n_cuts = size_bytes < N_CUTS ? size_bytes : N_CUTS;
    for (size_t i = 0; i < n_cuts && !result; i++)
        result = give(data, size_bytes * i / n_cuts);

done:
    if (result)
        fprintf(stderr, "cannot replay '%s': %s\n", path, strerror(errno));
    free(data);
    if (f)
        fclose(f);
    return result;
}

int main(int argc, char **argv)
{
    DIR *dir = argc == 2 ? opendir(argv[1]) : NULL;
    if (!dir) {
        fprintf(stderr, "usage: %s CORPUS_FOLDER\n", argv[0]);
        return 2;
    }
    int n_files = 0, bad = 0;
    for (const struct dirent *entry; (entry = readdir(dir));) {
        if (entry->d_name[0] == '.')
            continue;
        char path[4096];
        const int n = snprintf(path, sizeof path, "%s/%s", argv[1], entry->d_name);
        bad |= n < 0 || (size_t)n >= sizeof path || replay(path);
        n_files++;
    }
    closedir(dir);
    printf("%d inputs replayed from '%s'\n", n_files, argv[1]);
    return bad || n_files == 0; // an empty corpus tests nothing
}
