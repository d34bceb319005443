// SPDX-License-Identifier: Apache-2.0
// film.c - films through the program ffmpeg: raw frames go to its standard input, errors come back from its
// standard error.
//
// The pipe is a socket, because a write to a socket can be told (MSG_NOSIGNAL) not to raise SIGPIPE when
// ffmpeg has ended; nothing about this process's signals changes. ffmpeg gets a process group of its own, so
// that Ctrl-C at a terminal stops sheen and not the film in the middle of a frame. What it says goes into a
// file without a name, which cannot fill up and block as a pipe would.
#define _GNU_SOURCE // environ, memfd_create
#include "render/orbit.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"

enum { LEVELS = 4096, MAX_SIDE_PX = 8192, MAX_FRAMES_PER_S = 240 };

struct sheen_film {
    char path[SHEEN_PATH_MAX], part_path[SHEEN_PATH_MAX + 24];
    int width_px, height_px; // of the frames as given
    int even_width, even_height;
    pid_t pid; // 0: has been waited for
    int socket, messages;
    uint8_t *frame;
    uint8_t srgb[LEVELS + 1]; // code of light (i / LEVELS)^2: fine steps where the eye sees them
};

// How a file name's extension is encoded.
static const struct format {
    const char *extension;
    const char *arguments[12];
} formats[] = {
    {"mp4",
     {"-c:v", "libx264", "-preset", "medium", "-crf", "18", "-movflags", "+faststart", "-f", "mp4", NULL}},
    {"webm", {"-c:v", "libvpx-vp9", "-b:v", "0", "-crf", "24", "-row-mt", "1", "-f", "webm", NULL}},
};

static const struct format *format_of(const char *path)
{
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (strcasecmp(sheen_path_extension(path), formats[i].extension) == 0)
            return &formats[i];
    return NULL;
}

// The last line that ffmpeg wrote, which says why it ended.
static void last_message(const sheen_film *film, char *text, size_t size)
{
    char tail[1024];
    const off_t end = lseek(film->messages, 0, SEEK_END);
    const off_t from = end > (off_t)sizeof tail - 1 ? end - (off_t)(sizeof tail - 1) : 0;
    const ssize_t n = end > 0 ? pread(film->messages, tail, sizeof tail - 1, from) : 0;
    size_t length = n > 0 ? (size_t)n : 0;
    while (length && (tail[length - 1] == '\n' || tail[length - 1] == '\r' || tail[length - 1] == ' '))
        length--;
    tail[length] = 0;
    const char *line = strrchr(tail, '\n');
    snprintf(text, size, "%.*s", (int)size - 1, length ? (line ? line + 1 : tail) : "it gave no reason");
}

static int contains_message(const sheen_film *film, const char *part)
{
    char text[4096];
    const ssize_t n = pread(film->messages, text, sizeof text - 1, 0);
    text[n > 0 ? n : 0] = 0;
    return strstr(text, part) != NULL;
}

static sheen_status fail_ffmpeg(const sheen_film *film, sheen_err *err)
{
    char why[300];
    last_message(film, why, sizeof why);
    const int unknown = contains_message(film, "Unknown encoder");
    if (contains_message(film, "No space left on device"))
        return sheen_fail(err, SHEEN_EIO,
                          "cannot write the film '%.150s': the disk is full; free some space "
                          "and try again",
                          film->path);
    return sheen_fail(err, unknown ? SHEEN_EUNSUP : SHEEN_EIO, "ffmpeg could not write the film '%.150s': %s",
                      film->path, why);
}

// Waits for ffmpeg to end; true where it succeeded. Never leaves a zombie.
static int reap(sheen_film *film)
{
    int status = 0;
    if (!film->pid)
        return 0;
    pid_t got;
    do
        got = waitpid(film->pid, &status, 0);
    while (got < 0 && errno == EINTR);
    film->pid = 0;
    return got > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

static void free_film(sheen_film *film)
{
    if (film->socket >= 0)
        close(film->socket);
    if (film->pid) {
        kill(film->pid, SIGKILL);
        reap(film);
    }
    if (film->messages >= 0)
        close(film->messages);
    free(film->frame);
    free(film);
}

// Child: standard input from `from`, standard error to `to`, nothing else of ours; no signal blocked or
// ignored.
static int spawn(pid_t *pid, char *const *argv, int from, int to)
{
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t none, usual;
    sigemptyset(&none);
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    sigaddset(&usual, SIGINT);
    sigaddset(&usual, SIGTERM);
    if (posix_spawn_file_actions_init(&files))
        return ENOMEM;
    if (posix_spawnattr_init(&attributes)) {
        posix_spawn_file_actions_destroy(&files);
        return ENOMEM;
    }
    int code = posix_spawn_file_actions_adddup2(&files, from, STDIN_FILENO);
    if (!code)
        code = posix_spawn_file_actions_adddup2(&files, to, STDERR_FILENO);
    if (!code)
        code = posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    if (!code)
        code = posix_spawnattr_setpgroup(&attributes, 0);
    if (!code)
        code = posix_spawnattr_setsigmask(&attributes, &none);
    if (!code)
        code = posix_spawnattr_setsigdefault(&attributes, &usual);
    if (!code)
        code = posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK |
                                                         POSIX_SPAWN_SETSIGDEF);
    if (!code)
        code = posix_spawnp(pid, argv[0], &files, &attributes, argv, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return code;
}

// A command line, word by word.
typedef struct words {
    char text[SHEEN_PATH_MAX + 1024], *argv[64];
    size_t used, n;
} words;

static void add_word(words *w, const char *word)
{
    const size_t size = strlen(word) + 1;
    assert(w->used + size <= sizeof w->text && w->n + 1 < sizeof w->argv / sizeof *w->argv);
    memcpy(w->text + w->used, word, size);
    w->argv[w->n++] = w->text + w->used;
    w->used += size;
}

static void add_words(words *w, const char *const *list)
{
    for (; *list; list++)
        add_word(w, *list);
}

static void command_line(words *w, const sheen_film *film, const struct format *format, int frames_per_s)
{
    static const char *const input[] = {"ffmpeg",    "-hide_banner", "-nostdin", "-nostats",
                                        "-loglevel", "error",        "-y",       "-f",
                                        "rawvideo",  "-pix_fmt",     "rgb24",    NULL};
    // Players take BT.709 for granted at any size; without saying so ffmpeg would convert by BT.601.
    static const char *const colours[] = {"-i",
                                          "pipe:0",
                                          "-an",
                                          "-vf",
                                          "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p",
                                          "-colorspace",
                                          "bt709",
                                          "-color_primaries",
                                          "bt709",
                                          "-color_trc",
                                          "bt709",
                                          NULL};
    char size[32], rate[16], target[SHEEN_PATH_MAX + 32];
    snprintf(size, sizeof size, "%dx%d", film->even_width, film->even_height);
    snprintf(rate, sizeof rate, "%d", frames_per_s);
    snprintf(target, sizeof target, "file:%s", film->part_path); // never an option or another protocol
    add_words(w, input);
    add_word(w, "-s");
    add_word(w, size);
    add_word(w, "-r");
    add_word(w, rate);
    add_words(w, colours);
    add_words(w, format->arguments);
    add_word(w, target);
}

static sheen_status start(sheen_film *film, const struct format *format, int frames_per_s, sheen_err *err)
{
    words w = {.n = 0};
    command_line(&w, film, format, frames_per_s);
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends))
        return sheen_fail(err, SHEEN_EIO, "cannot make a pipe to ffmpeg: %s", strerror(errno));
    const int code = spawn(&film->pid, w.argv, ends[1], film->messages);
    close(ends[1]);
    film->socket = ends[0];
    if (!code)
        return SHEEN_OK;
    film->pid = 0;
    if (code == ENOENT || code == EACCES)
        return sheen_fail(err, SHEEN_EUNSUP, "cannot make a film: the program 'ffmpeg' is not installed");
    return sheen_fail(err, SHEEN_EIO, "cannot start ffmpeg: %s", strerror(code));
}

static void fill_table(uint8_t *srgb)
{
    for (int i = 0; i <= LEVELS; i++) {
        const float root = (float)i / LEVELS;
        srgb[i] = (uint8_t)(sheen_transfer_encode(SHEEN_TRANSFER_SRGB, root * root) * 255.0f + 0.5f);
    }
}

sheen_status sheen_film_open(sheen_film **out, const char *path, int width_px, int height_px,
                             int frames_per_s, sheen_err *err)
{
    *out = NULL;
    const struct format *format = format_of(path);
    if (!format)
        return sheen_fail(err, SHEEN_EUNSUP, "cannot make a film '%s': its name must end in .mp4 or .webm",
                          path);
    if (width_px < 2 || height_px < 2 || width_px > MAX_SIDE_PX || height_px > MAX_SIDE_PX ||
        frames_per_s < 1 || frames_per_s > MAX_FRAMES_PER_S || strlen(path) >= SHEEN_PATH_MAX)
        return sheen_fail(err, SHEEN_EARG, "a film of %d x %d px with %d frames a second is out of range",
                          width_px, height_px, frames_per_s);
    sheen_film *film = calloc(1, sizeof *film);
    if (!film)
        return sheen_fail_memory(err, (double)sizeof *film, "a film");
    film->socket = -1;
    film->width_px = width_px;
    film->height_px = height_px;
    film->even_width = width_px / 2 * 2;
    film->even_height = height_px / 2 * 2;
    memcpy(film->path, path, strlen(path) + 1);
    snprintf(film->part_path, sizeof film->part_path, "%s.%ld.part", path, (long)getpid());
    fill_table(film->srgb);
    film->messages = memfd_create("ffmpeg", MFD_CLOEXEC);
    film->frame = malloc((size_t)film->even_width * (size_t)film->even_height * 3);
    sheen_status s = SHEEN_OK;
    if (film->messages < 0)
        s = sheen_fail(err, SHEEN_EIO, "cannot listen to ffmpeg: %s", strerror(errno));
    else if (!film->frame)
        s = sheen_fail_memory(err, 3.0 * width_px * height_px, "a frame of a film");
    else
        s = start(film, format, frames_per_s, err);
    if (s)
        free_film(film);
    else
        *out = film;
    return s;
}

static void encode(sheen_film *film, const sheen_image *lin)
{
    uint8_t *to = film->frame;
    for (int y = 0; y < film->even_height; y++)
        for (int x = 0; x < film->even_width; x++) {
            const float *px = sheen_image_at(lin, x, y);
            for (int c = 0; c < 3; c++) {
                const float light = px[lin->n_channels == 3 ? c : 0];
                const float held = light > 0 ? (light < 1 ? light : 1) : 0; // NaN is black
                *to++ = film->srgb[(int)(sqrtf(held) * LEVELS + 0.5f)];
            }
        }
}

sheen_status sheen_film_add(sheen_film *film, const sheen_image *lin, sheen_err *err)
{
    if (lin->width_px != film->width_px || lin->height_px != film->height_px ||
        (lin->n_channels != 3 && lin->n_channels != 1))
        return sheen_fail(err, SHEEN_EARG, "a frame of %d x %d px does not fit a film of %d x %d px",
                          lin->width_px, lin->height_px, film->width_px, film->height_px);
    encode(film, lin);
    const size_t size_bytes = (size_t)film->even_width * (size_t)film->even_height * 3;
    for (size_t sent = 0; sent < size_bytes;) {
        const ssize_t n = send(film->socket, film->frame + sent, size_bytes - sent, MSG_NOSIGNAL);
        if (n > 0) {
            sent += (size_t)n;
        } else if (n == 0 || errno != EINTR) {
            reap(film); // it has ended, or is about to: its reader's end is closed
            return fail_ffmpeg(film, err);
        }
    }
    return SHEEN_OK;
}

// As every file of sheen's: complete and on the disk before it has its name.
static sheen_status publish(const sheen_film *film, sheen_err *err)
{
    const int fd = open(film->part_path, O_RDONLY | O_CLOEXEC);
    if (fd < 0 || fsync(fd)) {
        const int code = errno;
        if (fd >= 0)
            close(fd);
        return sheen_fail(err, SHEEN_EIO, "cannot write the film '%s': %s", film->path, strerror(code));
    }
    close(fd);
    if (rename(film->part_path, film->path))
        return sheen_fail(err, SHEEN_EIO, "cannot write the film '%s': %s", film->path, strerror(errno));
    return SHEEN_OK;
}

sheen_status sheen_film_close(sheen_film **film_in, int keep, sheen_err *err)
{
    sheen_film *film = *film_in;
    if (!film)
        return SHEEN_OK;
    *film_in = NULL;
    sheen_status s = SHEEN_OK;
    close(film->socket); // the end of its input: it completes the file
    film->socket = -1;
    if (keep) {
        s = reap(film) ? publish(film, err) : fail_ffmpeg(film, err);
    } else if (film->pid) {
        kill(film->pid, SIGKILL);
        reap(film);
    }
    if (!keep || s)
        unlink(film->part_path);
    free_film(film);
    return s;
}
