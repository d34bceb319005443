// SPDX-License-Identifier: Apache-2.0
// camera_memory.c - reads, writes and applies the table of cameras that claim wrong colours.
#include "cli/camera_memory.h"

#include <stdio.h>
#include <string.h>

#include "base/json.h"
#include "base/json_write.h"
#include "capture/devices.h"
#include "capture/v4l2_quirks.h"
#include "cli/config_path.h"

static const char *const claims[] = {
    "colorspace=", "transfer=", "matrix=", "range=", "exposure_most_ms=", "exposures_ms=", NULL};

static bool is_claim(const char *option, size_t n)
{
    for (int i = 0; claims[i]; i++)
        if (n > strlen(claims[i]) && !strncmp(option, claims[i], strlen(claims[i])))
            return true;
    return false;
}

void sheen_cli_camera_claims(char options[SHEEN_CLI_OPTIONS_MAX], const char *uri)
{
    const char *at = strchr(uri, '?');
    size_t length = 0;
    options[0] = 0;
    while (at && at[1]) {
        const char *option = at + 1;
        const size_t n = strcspn(option, "&");
        if (is_claim(option, n) && length + n + 2 < SHEEN_CLI_OPTIONS_MAX)
            length += (size_t)snprintf(options + length, SHEEN_CLI_OPTIONS_MAX - length, "%s%.*s",
                                       length ? "&" : "", (int)n, option);
        at = option[n] ? option + n : NULL;
    }
}

static bool is_camera(const char *entry, const char *identity, const char *name)
{
    if (!entry[0])
        return false;
    const size_t n = strcspn(identity, " "); // vendor and product
    return !strcmp(entry, identity) || !strcmp(entry, name) ||
           (strlen(entry) == n && !strncmp(entry, identity, n));
}

static sheen_status load(sheen_json **root, const char *file, sheen_err *err)
{
    *root = NULL;
    if (!sheen_file_exists(file))
        return SHEEN_OK;
    sheen_status s = sheen_json_load(root, file, err);
    if (!s)
        s = sheen_json_schema(*root, "sheen-cameras", 1, NULL, err);
    if (s)
        sheen_json_free(root);
    return s ? sheen_wrap(err, s, "cannot read '%.200s'", file) : SHEEN_OK;
}

static const char *text_of(const sheen_json *entry, const char *key)
{
    return sheen_json_value_string(sheen_json_get(entry, key), "");
}

sheen_status sheen_cli_camera_recall(char options[SHEEN_CLI_OPTIONS_MAX], const char *file,
                                     const char *identity, const char *name, sheen_err *err)
{
    sheen_json *root;
    options[0] = 0;
    const sheen_status s = load(&root, file, err);
    const sheen_json *list = sheen_json_get(root, "cameras");
    bool found = false;
    for (size_t i = 0; !s && !found && i < sheen_json_count(list); i++) {
        const sheen_json *entry = sheen_json_at(list, i);
        char query[SHEEN_CLI_OPTIONS_MAX + 1];
        if (!is_camera(text_of(entry, "camera"), identity, name))
            continue;
        snprintf(query, sizeof query, "?%s", text_of(entry, "options"));
        sheen_cli_camera_claims(options, query); // and nothing else
        found = true;
    }
    const char *known = s || found ? NULL : sheen_v4l2_quirk(identity, name);
    if (known)
        snprintf(options, SHEEN_CLI_OPTIONS_MAX, "%s", known);
    sheen_json_free(&root);
    return s;
}

sheen_status sheen_cli_camera_remember(const char *file, const char *camera, const char *options,
                                       sheen_err *err)
{
    sheen_json *root;
    sheen_json_writer w = {0};
    const sheen_status s = load(&root, file, err);
    if (s)
        return s;
    const sheen_json *list = sheen_json_get(root, "cameras");
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-cameras/1");
    sheen_json_open(&w, "cameras", '[');
    for (size_t i = 0; i <= sheen_json_count(list); i++) {
        const bool is_new = i == sheen_json_count(list);
        const sheen_json *entry = is_new ? NULL : sheen_json_at(list, i);
        const char *name = is_new ? camera : text_of(entry, "camera");
        if (is_new ? !options[0] : !strcmp(name, camera))
            continue;
        sheen_json_open(&w, NULL, '{');
        sheen_json_put_string(&w, "camera", name);
        sheen_json_put_string(&w, "options", is_new ? options : text_of(entry, "options"));
        sheen_json_close(&w);
    }
    sheen_json_close(&w);
    sheen_json_close(&w);
    const sheen_status saved = sheen_json_save(&w, file, err);
    sheen_json_free(&root);
    return saved;
}

static sheen_status remember(const char *file, const char *given, const char *identity, const char *name,
                             sheen_err *err)
{
    char options[SHEEN_CLI_OPTIONS_MAX], camera[160];
    sheen_cli_camera_claims(options, given);
    snprintf(camera, sizeof camera, "%.*s", (int)(identity[0] ? strcspn(identity, " ") : strlen(name)),
             identity[0] ? identity : name);
    if (!camera[0])
        return sheen_fail(err, SHEEN_EUNSUP, "'%.100s' is no camera that could be known again", given);
    return sheen_cli_camera_remember(file, camera, options, err);
}

sheen_status sheen_cli_camera_uri(char uri[SHEEN_PATH_MAX], char noted[240], const char *given, bool keep,
                                  sheen_err *err)
{
    static const char scheme[] = "v4l2:";
    char file[SHEEN_PATH_MAX], node[SHEEN_PATH_MAX], identity[80], name[128];
    char options[SHEEN_CLI_OPTIONS_MAX] = "";
    noted[0] = 0;
    if (strlen(given) >= SHEEN_PATH_MAX - SHEEN_CLI_OPTIONS_MAX)
        return sheen_fail(err, SHEEN_EARG, "the URI '%.60s...' is too long", given);
    snprintf(uri, SHEEN_PATH_MAX, "%s", given);
    if (strncmp(given, scheme, sizeof scheme - 1) != 0)
        return keep ? sheen_fail(err, SHEEN_EUNSUP, "only cameras of v4l2: are remembered") : SHEEN_OK;
    const size_t n = strcspn(given, "?");
    snprintf(node, sizeof node, "%.*s", (int)(n - (sizeof scheme - 1)), given + sizeof scheme - 1);
    sheen_device_identity(identity, sizeof identity, node);
    sheen_device_name(name, sizeof name, node);
    sheen_status s = sheen_cli_config_path(file, "cameras.json", err);
    if (!s && keep)
        s = remember(file, given, identity, name, err);
    if (!s)
        s = sheen_cli_camera_recall(options, file, identity, name, err);
    if (s || !options[0])
        return s;
    snprintf(uri, SHEEN_PATH_MAX, "%.*s?%s%s%s", (int)n, given, options, given[n] ? "&" : "",
             given[n] ? given + n + 1 : "");
    snprintf(noted, 240, "of this camera is known: %s", options);
    return SHEEN_OK;
}
