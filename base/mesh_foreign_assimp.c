// SPDX-License-Identifier: Apache-2.0
// mesh_foreign_assimp.c - the door to assimp: a child process reads the file and sends triangles through a pipe.
#include "base/mesh_foreign.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "base/file.h"
#include "base/mesh_build.h"

enum { MAX_CPU_S = 120, CHUNK = 4096 };

static const rlim_t MAX_MEMORY_BYTES = (rlim_t)6 << 30;

// What the child says first; then n_vertices * 3 floats and n_triangles * 3 indices.
typedef struct header {
    uint64_t n_vertices, n_triangles;
    char error[200]; // "": none
} header;

bool sheen_mesh_is_native(const char *path)
{
    const char *extension = sheen_path_extension(path);
    return !strcasecmp(extension, "ply") || !strcasecmp(extension, "obj") || !strcasecmp(extension, "glb");
}

static bool send_all(int fd, const void *data, size_t size_bytes)
{
    const char *at = data;
    while (size_bytes) {
        const ssize_t n = write(fd, at, size_bytes);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        at += n;
        size_bytes -= (size_t)n;
    }
    return true;
}

static bool receive_all(FILE *from, void *data, size_t size_bytes)
{
    return fread(data, 1, size_bytes, from) == size_bytes;
}

// ---- in the child

static void count(header *h, const struct aiScene *scene)
{
    for (unsigned m = 0; m < scene->mNumMeshes; m++) {
        h->n_vertices += scene->mMeshes[m]->mNumVertices;
        for (unsigned f = 0; f < scene->mMeshes[m]->mNumFaces; f++)
            h->n_triangles += scene->mMeshes[m]->mFaces[f].mNumIndices == 3;
    }
}

static bool send_vertices(int fd, const struct aiMesh *mesh)
{
    float block[3 * CHUNK];
    for (unsigned i = 0; i < mesh->mNumVertices;) {
        size_t n = 0;
        for (; n < CHUNK && i < mesh->mNumVertices; n++, i++) {
            block[3 * n] = mesh->mVertices[i].x;
            block[3 * n + 1] = mesh->mVertices[i].y;
            block[3 * n + 2] = mesh->mVertices[i].z;
        }
        if (!send_all(fd, block, 3 * n * sizeof *block))
            return false;
    }
    return true;
}

static bool send_triangles(int fd, const struct aiMesh *mesh, uint32_t first)
{
    uint32_t block[3 * CHUNK];
    size_t n = 0;
    for (unsigned i = 0; i < mesh->mNumFaces; i++) {
        if (mesh->mFaces[i].mNumIndices != 3)
            continue;
        for (size_t k = 0; k < 3; k++)
            block[3 * n + k] = first + mesh->mFaces[i].mIndices[k];
        if (++n == CHUNK) {
            if (!send_all(fd, block, sizeof block))
                return false;
            n = 0;
        }
    }
    return send_all(fd, block, 3 * n * sizeof *block);
}

static void serve(int fd, const char *path)
{
    header h = {0};
    const struct rlimit memory = {MAX_MEMORY_BYTES, MAX_MEMORY_BYTES}, time = {MAX_CPU_S, MAX_CPU_S},
                        none = {0, 0};
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) // which reserve more than any limit
    setrlimit(RLIMIT_AS, &memory);
#else
    (void)memory;
#endif
    setrlimit(RLIMIT_CPU, &time);
    setrlimit(RLIMIT_CORE, &none);
    const struct aiScene *scene = aiImportFile(path, aiProcess_Triangulate | aiProcess_PreTransformVertices |
                                                         aiProcess_SortByPType);
    if (scene)
        count(&h, scene);
    else
        snprintf(h.error, sizeof h.error, "%s",
                 aiGetErrorString()[0] ? aiGetErrorString() : "it cannot be read");
    bool going = send_all(fd, &h, sizeof h);
    for (unsigned m = 0; scene && m < scene->mNumMeshes && going; m++)
        going = send_vertices(fd, scene->mMeshes[m]);
    uint32_t first = 0;
    for (unsigned m = 0; scene && m < scene->mNumMeshes && going; m++) {
        going = send_triangles(fd, scene->mMeshes[m], first);
        first += scene->mMeshes[m]->mNumVertices;
    }
}

// ---- in the parent

// One line of plain text out of whatever the child said.
static void clean(char *text)
{
    for (char *c = text; *c; c++)
        if (*c < ' ' || *c > '~')
            *c = ' ';
}

static sheen_status receive(sheen_mesh *mesh, FILE *from, sheen_err *err)
{
    header h;
    sheen_mesh_build build = {0};
    if (!receive_all(from, &h, sizeof h))
        return sheen_fail(err, SHEEN_EFORMAT, "the file is damaged, or too large to read");
    h.error[sizeof h.error - 1] = 0;
    clean(h.error);
    if (h.error[0])
        return sheen_fail(err, SHEEN_EFORMAT, "not a mesh that is read here: %s", h.error);
    if (h.n_triangles > SHEEN_MESH_MAX_TRIANGLES || h.n_vertices > 3 * (uint64_t)SHEEN_MESH_MAX_TRIANGLES)
        return sheen_fail(err, SHEEN_EFORMAT, "more than %d triangles", (int)SHEEN_MESH_MAX_TRIANGLES);
    sheen_status s = sheen_mesh_build_reserve(&build, (size_t)h.n_vertices, (size_t)h.n_triangles, err);
    for (uint64_t i = 0; i < h.n_vertices && !s; i++) {
        float p[3];
        s = receive_all(from, p, sizeof p)
                ? sheen_mesh_build_vertex(&build, (const double[3]){(double)p[0], (double)p[1], (double)p[2]},
                                          NULL, err)
                : sheen_fail(err, SHEEN_EFORMAT, "the file is damaged");
    }
    for (uint64_t i = 0; i < h.n_triangles && !s; i++) {
        uint32_t t[3];
        s = receive_all(from, t, sizeof t)
                ? sheen_mesh_build_triangle(&build, t[0], t[1], t[2], (size_t)h.n_vertices, err)
                : sheen_fail(err, SHEEN_EFORMAT, "the file is damaged");
    }
    if (!s)
        s = sheen_mesh_build_finish(&build, mesh, err);
    sheen_mesh_build_release(&build);
    return s;
}

static sheen_status load_foreign(sheen_mesh *mesh, const char *path, sheen_err *err)
{
    int fds[2];
    if (access(path, R_OK))
        return sheen_fail(err, errno == EACCES ? SHEEN_EACCESS : SHEEN_EIO, "%s", strerror(errno));
    if (pipe(fds))
        return sheen_fail(err, SHEEN_EIO, "cannot start a reader: %s", strerror(errno));
    const pid_t child = fork();
    if (child < 0) {
        close(fds[0]);
        close(fds[1]);
        return sheen_fail(err, SHEEN_EIO, "cannot start a reader: %s", strerror(errno));
    }
    if (!child) {
        close(fds[0]);
        serve(fds[1], path);
        _exit(0);
    }
    close(fds[1]);
    FILE *from = fdopen(fds[0], "r");
    const sheen_status s = from ? receive(mesh, from, err) : sheen_fail_memory(err, BUFSIZ, "a reader");
    if (from) // a child that still writes gets SIGPIPE
        fclose(from);
    else
        close(fds[0]);
    while (waitpid(child, NULL, 0) < 0 && errno == EINTR)
        ;
    return s;
}

sheen_status sheen_mesh_load_any(sheen_mesh *mesh, const char *path, sheen_err *err)
{
    *mesh = (sheen_mesh){0};
    if (sheen_mesh_is_native(path))
        return sheen_mesh_load(mesh, path, err);
    const sheen_status s = load_foreign(mesh, path, err);
    return s ? sheen_wrap(err, s, "cannot read '%s'", path) : SHEEN_OK;
}
