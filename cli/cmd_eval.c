// SPDX-License-Identifier: Apache-2.0
// cmd_eval.c - sheen eval: how well the model predicts photographs that it has not seen.
#include <stdlib.h>

#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/stages.h"

typedef struct eval_args {
    const char *transfer, *method;
    sheen_evaluate_session_options o;
} eval_args;

static sheen_status parse(sheen_cli *cli, eval_args *a, sheen_err *err)
{
    const sheen_option options[] = {
        {"holdout", 0, SHEEN_OPTION_INT, &a->o.n_folds, "K",
         "fit K times, each time without every K-th input frame,\nand score on those", 2, 1000},
        {"method", 0, SHEEN_OPTION_TEXT, &a->method, "NAME",
         "of --holdout: refined (default) or paper, as in\n'sheen fit'", 0, 0},
        {"against", 0, SHEEN_OPTION_TEXT, &a->o.against_dir, "DIR",
         "score on the pictures <pose's name>.* in this folder", 0, 0},
        {"poses", 0, SHEEN_OPTION_TEXT, &a->o.poses_path, "FILE",
         "of --against: poses and cameras of those pictures", 0, 0},
        {"transfer", 0, SHEEN_OPTION_TEXT, &a->transfer, "CURVE",
         "of --against: how their numbers stand for light\n(default: srgb)", 0, 0},
        {"threads", 0, SHEEN_OPTION_INT, &a->o.fit.n_threads, "N", "default: one a processor", 1, 1024},
        {0},
    };
    sheen_status s = sheen_cli_parse(cli, options, 1, 1, err);
    if (s || cli->wants_help)
        return s;
    if (!a->o.against_dir != !a->o.poses_path)
        return sheen_cli_usage(cli, err, "'--against' and '--poses' go together");
    if (a->o.against_dir && a->o.n_folds)
        return sheen_cli_usage(cli, err, "'--holdout' and '--against' exclude each other");
    if (a->method && !a->o.n_folds)
        return sheen_cli_usage(cli, err,
                               "'--method' is of '--holdout': otherwise the model is scored as it is");
    if (a->method)
        s = sheen_fit_method_from_name(&a->o.method, a->method, err);
    if (!s && a->transfer)
        s = sheen_transfer_from_name(&a->o.transfer, a->transfer, err);
    return sheen_cli_option_status(cli, s);
}

sheen_status sheen_cli_say_evaluation(sheen_cli *cli, const sheen_evaluation *e, sheen_err *err)
{
    char *table = sheen_evaluation_table(e);
    if (!table)
        return sheen_fail(err, SHEEN_ENOMEM, "out of memory for the table");
    sheen_cli_say(cli, "%s", table);
    free(table);
    sheen_evaluation_write(e, &cli->out);
    return SHEEN_OK;
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    eval_args a = {0};
    sheen_session s;
    sheen_evaluation e = {0};
    sheen_status st = parse(cli, &a, err);
    if (st || cli->wants_help)
        return st;
    a.o.fit.progress = sheen_cli_progress(cli);
    st = sheen_session_open(&s, cli->args[0], err);
    if (st)
        return st;
    st = sheen_evaluate_session(&e, &s, &a.o, err);
    sheen_cli_clear_bar(cli);
    if (!st)
        st = sheen_cli_say_evaluation(cli, &e, err);
    sheen_evaluation_release(&e);
    sheen_session_release(&s);
    return st;
}

const sheen_command sheen_cmd_eval = {
    .name = "eval",
    .synopsis = "SESSION [--holdout K | --against DIR --poses FILE] [options]",
    .summary = "how well the model predicts photographs it has not seen",
    .about = "Scores the model, and simpler textures beside it, on the session's test frames: over the "
             "object and over\n"
             "its highlights. Writes evaluation/: the table, and each photograph beside its prediction.\n",
    .example = "  sheen import penguin.session checks/*.jpg --role test\n"
               "  sheen run penguin.session && sheen eval penguin.session\n",
    .run = run,
};
