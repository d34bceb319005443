// SPDX-License-Identifier: Apache-2.0
// table_arg.c - opens a turntable for a command.
#include "cli/table_arg.h"

#include <stdio.h>

#include "cli/config_path.h"
#include "cli/keys.h"

sheen_status sheen_cli_table_path(char path[SHEEN_PATH_MAX], const char *given, sheen_err *err)
{
    if (given)
        return snprintf(path, SHEEN_PATH_MAX, "%s", given) < SHEEN_PATH_MAX
                   ? SHEEN_OK
                   : sheen_fail(err, SHEEN_EARG, "the path '%.60s...' is too long", given);
    return sheen_cli_config_path(path, "turntable.json", err);
}

static bool go_on(void *self)
{
    (void)self;
    return !sheen_cli_keys_stopped();
}

static sheen_status turn_by_hand(void *self, double delta_deg, double *position_deg, sheen_err *err)
{
    char prompt[120], line[16];
    snprintf(prompt, sizeof prompt,
             "turn the table by %.1f degrees (counter-clockwise seen from above), then press Enter",
             delta_deg);
    const sheen_status s = sheen_cli_ask(line, sizeof line, self, prompt, err);
    if (!s)
        *position_deg += delta_deg; // the camera sees what it became
    return s;
}

static sheen_status load(sheen_table_config *config, const char *file, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_table_config_init(config);
    const sheen_status s = sheen_cli_table_path(path, file, err);
    return !s && (file || sheen_file_exists(path)) ? sheen_table_config_load(config, path, err) : s;
}

static sheen_status open_with(sheen_table **table, const sheen_table_config *config, sheen_cli *cli,
                              const char *device, sheen_err *err)
{
    const sheen_table_options o = {
        .config = *config, .go_on = go_on, .turn_by_hand = turn_by_hand, .self = cli};
    return sheen_table_open(table, device, &o, err);
}

sheen_status sheen_cli_table_open(sheen_table **table, sheen_table_config *config, sheen_cli *cli,
                                  const char *device, const char *file, sheen_err *err)
{
    const sheen_status s = load(config, file, err);
    return s ? s : open_with(table, config, cli, device, err);
}

sheen_status sheen_cli_table_open_plain(sheen_table **table, sheen_table_config *config, sheen_cli *cli,
                                        const char *device, const char *file, sheen_err *err)
{
    const sheen_status s = load(config, file, err);
    config->direction = 1;
    config->backlash_deg = 0;
    return s ? s : open_with(table, config, cli, device, err);
}
