// SPDX-License-Identifier: Apache-2.0
// measure.c - measures the camera of a session and says what came of it.
#include "cli/measure.h"

#include <math.h>

enum { N_FRAMES = 32 };
static const double residual_most = 0.03; // beyond it a curve is not one that the exposures agree on

sheen_status sheen_cli_follow(sheen_cli *cli, const sheen_session *s, sheen_source *src, bool covered,
                              bool *followed, sheen_err *err)
{
    *followed = false;
    for (size_t i = s->n_frames; i-- > 0;) {
        const sheen_status st = sheen_source_follow(src, &s->frames[i], covered, followed, err);
        if (!st && !*followed)
            continue;
        if (!st)
            sheen_cli_say(cli, "the camera is set as it was for frame '%s'", s->frames[i].name);
        return st;
    }
    return SHEEN_OK;
}

static void report_dark(sheen_cli *cli, const sheen_measure_report *r)
{
    sheen_cli_say(cli, "dark: %d frames, %.2f %% of full scale, %zu hot pixels", r->n_frames, 100 * r->level,
                  r->n_hot);
    sheen_json_put_int(&cli->out, "frames", r->n_frames);
    sheen_json_put_number(&cli->out, "level", r->level);
    sheen_json_put_int(&cli->out, "hot_pixels", (long long)r->n_hot);
}

static void report_flat(sheen_cli *cli, const sheen_measure_report *r)
{
    sheen_cli_say(
        cli,
        "flat field: %d frames, mean code %.0f %% of full scale, at its darkest %.0f %% of the brightest",
        r->n_frames, 100 * r->level, 100 * r->darkest);
    sheen_json_put_int(&cli->out, "frames", r->n_frames);
    sheen_json_put_number(&cli->out, "level", r->level);
    sheen_json_put_number(&cli->out, "darkest", r->darkest);
}

static void report_response(sheen_cli *cli, const sheen_measure_report *r)
{
    sheen_cli_say(
        cli,
        "response: from %d exposures of %.2f to %.2f ms, which agree to %.1f %% under it (under the "
        "curve that the camera claims: %.1f %%)",
        r->n_exposures, 1000 * r->exposure_s[0], 1000 * r->exposure_s[r->n_exposures - 1], 100 * r->residual,
        100 * r->residual_claimed);
    sheen_json_put_int(&cli->out, "exposures", r->n_exposures);
    sheen_json_put_number(&cli->out, "residual", r->residual);
    sheen_json_put_number(&cli->out, "residual_claimed", r->residual_claimed);
    cli->limit_missed = !(r->residual <= residual_most);
    if (cli->limit_missed)
        sheen_cli_warn(cli,
                       "the exposures disagree by %.1f %%, more than %.0f %%: something moved, the light "
                       "changed, or the camera's curve changes with the picture; measure it again, or remove "
                       "the files response* in its session's '%s'",
                       100 * r->residual, 100 * residual_most, SHEEN_SESSION_RADIOMETRY);
}

sheen_status sheen_cli_measure_camera(sheen_cli *cli, const sheen_cli_measure *what, const sheen_session *s,
                                      sheen_source *src, const sheen_record_options *o, sheen_err *err)
{
    sheen_measure_report r = {0};
    bool followed;
    if (!sheen_source_is_live(src))
        return sheen_fail(err, SHEEN_EUNSUP, "a recording cannot be measured: name a camera");
    sheen_status st = sheen_cli_follow(cli, s, src, what->dark, &followed, err);
    if (!st && what->dark && !followed)
        st = sheen_fail(
            err, SHEEN_EARG,
            "a dark frame is taken under the settings of the frames that it is for, and '%s' has none "
            "of this camera: record a frame first",
            s->path);
    if (!st && what->dark)
        st = what->bracket ? sheen_measure_bracket_dark(&r, s, src, what->bracket, N_FRAMES, o, err)
                           : sheen_measure_field(&r, s, src, SHEEN_MEASURE_DARK, N_FRAMES, o, err);
    else if (!st && what->flat)
        st = sheen_measure_field(&r, s, src, SHEEN_MEASURE_FLAT, N_FRAMES, o, err);
    else if (!st)
        st = sheen_measure_response(&r, s, src, o, err);
    sheen_cli_clear_bar(cli);
    if (st)
        return st;
    sheen_json_put_string(&cli->out, "session", s->path);
    if (what->dark)
        report_dark(cli, &r);
    else if (what->flat)
        report_flat(cli, &r);
    else
        report_response(cli, &r);
    return SHEEN_OK;
}
