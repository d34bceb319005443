// SPDX-License-Identifier: Apache-2.0
// file.c - whole files and folders over POSIX; the only writes that sheen makes go through here.
#define _GNU_SOURCE // O_DIRECTORY, O_NOFOLLOW, renameat2, RENAME_EXCHANGE
#include "base/file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <xxhash.h>

static sheen_status fail_errno(sheen_err *err, const char *what, const char *path)
{
    const int e = errno;
    if (e == EACCES || e == EPERM || e == EROFS)
        return sheen_fail(err, SHEEN_EACCESS, "cannot %s '%s': %s", what, path, strerror(e));
    if (e == ENOSPC || e == EDQUOT)
        return sheen_fail(err, SHEEN_EIO, "cannot %s '%s': the disk is full; free some space and try again",
                          what, path);
    return sheen_fail(err, SHEEN_EIO, "cannot %s '%s': %s", what, path, strerror(e));
}

sheen_status sheen_path_join(char out[SHEEN_PATH_MAX], const char *dir, const char *name, sheen_err *err)
{
    const size_t n = strlen(dir);
    const char *slash = n && dir[n - 1] == '/' ? "" : "/";
    const int wanted = snprintf(out, SHEEN_PATH_MAX, "%s%s%s", dir, slash, name);
    if (wanted < 0 || wanted >= SHEEN_PATH_MAX)
        return sheen_fail(err, SHEEN_EARG, "path is too long: '%.80s...'", dir);
    return SHEEN_OK;
}

const char *sheen_path_base(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

const char *sheen_path_extension(const char *path)
{
    const char *dot = strrchr(sheen_path_base(path), '.');
    return dot ? dot + 1 : "";
}

bool sheen_file_exists(const char *path)
{
    struct stat st;
    return !stat(path, &st) && S_ISREG(st.st_mode);
}

bool sheen_dir_exists(const char *path)
{
    struct stat st;
    return !stat(path, &st) && S_ISDIR(st.st_mode);
}

// Reads `size_bytes`, or up to the end of a file that has shrunk meanwhile.
static bool read_all(int fd, uint8_t *data, size_t *size_bytes)
{
    size_t done = 0;
    while (done < *size_bytes) {
        const ssize_t n = read(fd, data + done, *size_bytes - done);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return false;
        if (!n)
            break;
        done += (size_t)n;
    }
    *size_bytes = done;
    return true;
}

sheen_status sheen_file_read(uint8_t **data_out, size_t *size_bytes_out, const char *path, size_t max_bytes,
                             sheen_err *err)
{
    *data_out = NULL;
    *size_bytes_out = 0;
    // O_NONBLOCK: opening a pipe that was named by mistake must not hang
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return fail_errno(err, "open", path);
    sheen_status s = SHEEN_OK;
    uint8_t *data = NULL;
    struct stat st;
    if (fstat(fd, &st)) {
        s = fail_errno(err, "read", path);
        goto done;
    }
    if (!S_ISREG(st.st_mode)) {
        s = sheen_fail(err, SHEEN_EIO, "cannot read '%s': not a regular file", path);
        goto done;
    }
    if ((uint64_t)st.st_size > max_bytes) {
        s = sheen_fail(err, SHEEN_EFORMAT, "'%s' is too large: %.0f MB, at most %.0f MB are read", path,
                       (double)st.st_size / 1e6, (double)max_bytes / 1e6);
        goto done;
    }
    size_t size_bytes = (size_t)st.st_size;
    data = malloc(size_bytes + 1);
    if (!data) {
        s = sheen_fail_memory(err, (double)size_bytes, path);
        goto done;
    }
    if (!read_all(fd, data, &size_bytes)) {
        s = fail_errno(err, "read", path);
        goto done;
    }
    data[size_bytes] = 0;
    *data_out = data;
    *size_bytes_out = size_bytes;
    data = NULL;

done:
    free(data);
    close(fd);
    return s;
}

static bool write_all(int fd, const void *data, size_t size_bytes)
{
    const char *p = data;
    while (size_bytes) {
        const ssize_t n = write(fd, p, size_bytes);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return false;
        p += n;
        size_bytes -= (size_t)n;
    }
    return true;
}

// Linux closes the file though the call was interrupted, and what it says of the disk then fsync has said before.
static bool close_written(int fd)
{
    return !close(fd) || errno == EINTR;
}

// Network file systems and those in user space may be interrupted here, too.
static bool sync_file(int fd)
{
    int code;
    do
        code = fsync(fd);
    while (code && errno == EINTR);
    return !code;
}

static bool rename_file(const char *from, const char *to)
{
    int code;
    do
        code = rename(from, to);
    while (code && errno == EINTR);
    return !code;
}

// So that a rename inside it survives a power cut. Not every file system can: no error of ours.
static void sync_dir_of(const char *path)
{
    char dir[SHEEN_PATH_MAX];
    const size_t n = (size_t)(sheen_path_base(path) - path);
    if (n >= sizeof dir)
        return;
    memcpy(dir, path, n);
    dir[n] = 0;
    const int fd = open(n ? dir : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        fsync(fd);
        close(fd);
    }
}

static const char temp_letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
enum { TEMP_LETTERS = 6, TEMP_TRIES = 100 };

// Opens ".<name>.XXXXXX" beside `path`, X any of temp_letters. The leading dot keeps what a power cut leaves behind out of
// every listing. Not mkstemp, which makes files private: ours are as open as the person's umask says.
static sheen_status open_temp(int *fd_out, char out[SHEEN_PATH_MAX], const char *path, sheen_err *err)
{
    const char *base = sheen_path_base(path);
    const int n = snprintf(out, SHEEN_PATH_MAX, "%.*s.%s.XXXXXX", (int)(base - path), path, base);
    if (n < 0 || n >= SHEEN_PATH_MAX)
        return sheen_fail(err, SHEEN_EARG, "path is too long: '%.80s...'", path);
    *fd_out = -1;
    for (int i = 0; i < TEMP_TRIES && *fd_out < 0; i++) {
        uint8_t bytes[TEMP_LETTERS];
        if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
            continue;
        for (int k = 0; k < TEMP_LETTERS; k++)
            out[n - TEMP_LETTERS + k] = temp_letters[bytes[k] % (sizeof temp_letters - 1)];
        *fd_out = open(out, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (*fd_out < 0 && errno != EEXIST && errno != EINTR)
            break;
    }
    return *fd_out < 0 ? fail_errno(err, "write", path) : SHEEN_OK;
}

sheen_status sheen_file_write(const char *path, const void *data, size_t size_bytes, sheen_err *err)
{
    char temp[SHEEN_PATH_MAX];
    int fd = -1;
    sheen_status s = open_temp(&fd, temp, path, err);
    if (s)
        return s;
    bool ok = write_all(fd, data, size_bytes) && sync_file(fd);
    if (!ok)
        s = fail_errno(err, "write", path);
    if (!close_written(fd) && ok) {
        ok = false;
        s = fail_errno(err, "write", path);
    }
    if (ok && !rename_file(temp, path)) {
        ok = false;
        s = fail_errno(err, "write", path);
    }
    if (!ok) {
        unlink(temp);
        return s;
    }
    sync_dir_of(path);
    return SHEEN_OK;
}

// ".<name>.XXXXXX", as open_temp makes them.
static bool is_temp_name(const char *name)
{
    const char *dot = strrchr(name, '.');
    return name[0] == '.' && dot > name + 1 && strlen(dot + 1) == TEMP_LETTERS &&
           strspn(dot + 1, temp_letters) == TEMP_LETTERS;
}

void sheen_dir_sweep(const char *path, int older_than_s)
{
    DIR *d = opendir(path);
    if (!d)
        return;
    const time_t now = time(NULL);
    for (const struct dirent *e; (e = readdir(d));) {
        struct stat st;
        if (is_temp_name(e->d_name) && !fstatat(dirfd(d), e->d_name, &st, AT_SYMLINK_NOFOLLOW) &&
            S_ISREG(st.st_mode) && now - st.st_mtime >= older_than_s)
            unlinkat(dirfd(d), e->d_name, 0);
    }
    closedir(d);
}

sheen_status sheen_file_copy(const char *to_path, const char *from_path, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_file_read(&data, &size_bytes, from_path, (size_t)4 << 30, err);
    if (s)
        return s;
    s = sheen_file_write(to_path, data, size_bytes, err);
    free(data);
    return s;
}

sheen_status sheen_file_remove(const char *path, sheen_err *err)
{
    if (unlink(path) && errno != ENOENT)
        return fail_errno(err, "remove", path);
    return SHEEN_OK;
}

sheen_status sheen_dir_make(const char *path, sheen_err *err)
{
    char part[SHEEN_PATH_MAX];
    const size_t n = strlen(path);
    if (!n || n >= sizeof part)
        return sheen_fail(err, SHEEN_EARG, "cannot make the folder '%.80s': bad length of name", path);
    for (size_t i = 1; i <= n; i++) {
        if (path[i] != '/' && path[i] != 0)
            continue;
        memcpy(part, path, i);
        part[i] = 0;
        if (mkdir(part, 0777) && errno != EEXIST)
            return fail_errno(err, "make the folder", part);
    }
    if (!sheen_dir_exists(path))
        return sheen_fail(err, SHEEN_EIO, "cannot make the folder '%s': a file of that name is there", path);
    return SHEEN_OK;
}

// Removes what is in an open folder; fd stays the caller's.
static bool empty_dir(int fd, int depth)
{
    const int again = openat(fd, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *d = again >= 0 ? fdopendir(again) : NULL;
    if (!d) {
        if (again >= 0)
            close(again);
        return false;
    }
    bool ok = true;
    for (struct dirent *e; ok && (e = readdir(d));) {
        if (!strcmp(e->d_name, ".") || !strcmp(e->d_name, ".."))
            continue;
        if (!unlinkat(fd, e->d_name, 0))
            continue;
        const int sub = openat(fd, e->d_name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
        ok = sub >= 0 && depth < 64 && empty_dir(sub, depth + 1) && !unlinkat(fd, e->d_name, AT_REMOVEDIR);
        if (sub >= 0)
            close(sub);
    }
    closedir(d);
    return ok;
}

sheen_status sheen_dir_remove(const char *path, sheen_err *err)
{
    const int fd = open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (fd < 0)
        return errno == ENOENT ? SHEEN_OK : fail_errno(err, "remove", path);
    const bool ok = empty_dir(fd, 0) && !rmdir(path);
    const sheen_status s = ok ? SHEEN_OK : fail_errno(err, "remove", path);
    close(fd);
    return s;
}

sheen_status sheen_dir_replace(const char *path, const char *finished_path, sheen_err *err)
{
    if (!rename(finished_path, path)) { // nothing there, or an empty folder
        sync_dir_of(path);
        return SHEEN_OK;
    }
    if (errno != ENOTEMPTY && errno != EEXIST)
        return fail_errno(err, "write", path);
    // The two change places in one step, so that there is a whole one under the name at every instant.
    if (renameat2(AT_FDCWD, finished_path, AT_FDCWD, path, RENAME_EXCHANGE))
        return fail_errno(err, "replace", path);
    sync_dir_of(path);
    return sheen_dir_remove(finished_path, err);
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static bool ends_with(const char *text, const char *suffix)
{
    const size_t n = strlen(text), k = strlen(suffix);
    return n >= k && !strcmp(text + n - k, suffix);
}

static bool append_name(sheen_names *out, size_t *capacity, const char *name)
{
    if (out->count == *capacity) {
        const size_t grown = *capacity ? 2 * *capacity : 64;
        char **names = realloc(out->names, grown * sizeof *names);
        if (!names)
            return false;
        out->names = names;
        *capacity = grown;
    }
    char *copy = strdup(name);
    if (!copy)
        return false;
    out->names[out->count++] = copy;
    return true;
}

sheen_status sheen_dir_list(sheen_names *out, const char *path, const char *suffix, sheen_err *err)
{
    *out = (sheen_names){0};
    DIR *d = opendir(path);
    if (!d)
        return fail_errno(err, "list", path);
    size_t capacity = 0;
    bool ok = true;
    for (struct dirent *e; ok && (e = readdir(d));)
        if (e->d_name[0] != '.' && (!suffix || ends_with(e->d_name, suffix)))
            ok = append_name(out, &capacity, e->d_name);
    closedir(d);
    if (!ok) {
        sheen_names_release(out);
        return sheen_fail(err, SHEEN_ENOMEM, "out of memory while listing '%s'", path);
    }
    if (out->count)
        qsort(out->names, out->count, sizeof *out->names, compare_names);
    return SHEEN_OK;
}

void sheen_names_release(sheen_names *n)
{
    for (size_t i = 0; i < n->count; i++)
        free(n->names[i]);
    free(n->names);
    *n = (sheen_names){0};
}

void sheen_digest(char hex[33], const void *data, size_t size_bytes)
{
    const XXH128_hash_t h = XXH3_128bits(data, size_bytes);
    snprintf(hex, 33, "%016llx%016llx", (unsigned long long)h.high64, (unsigned long long)h.low64);
}

sheen_status sheen_file_digest(char hex[33], const char *path, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    const sheen_status s = sheen_file_read(&data, &size_bytes, path, (size_t)4 << 30, err);
    if (s)
        return s;
    sheen_digest(hex, data, size_bytes);
    free(data);
    return SHEEN_OK;
}
