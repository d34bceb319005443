// SPDX-License-Identifier: Apache-2.0
// cmd_board.c - sheen board: prints boards to calibrate from and to put the object on.
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "calib/board_sheet.h"
#include "cli/cli.h"
#include "cli/commands.h"

typedef struct board_args {
    const char *output, *paper;
    int squares[2], first_id, n_boards;
    double square_mm, tag_mm, blank_mm, measured_mm; // NaN: not given
} board_args;

static sheen_status parse(sheen_cli *cli, board_args *a, sheen_err *err)
{
    const double none = (double)NAN;
    *a = (board_args){.paper = "a3",
                      .squares = {12, 9},
                      .n_boards = 1,
                      .square_mm = none,
                      .tag_mm = none,
                      .blank_mm = 0,
                      .measured_mm = none};
    const sheen_option options[] = {
        {"output", 'o', SHEEN_OPTION_TEXT, &a->output, "FILE",
         "board.pdf or board.svg; board.json goes beside it", 0, 0},
        {"paper", 0, SHEEN_OPTION_TEXT, &a->paper, "NAME",
         "a4, a3 (default), a2, a1, a0, letter, tabloid, or\nWIDTHxHEIGHT in mm", 0, 0},
        {"squares", 0, SHEEN_OPTION_SIZE, a->squares, "COLSxROWS", "default: 12x9", 4, 100},
        {"square-mm", 0, SHEEN_OPTION_NUMBER, &a->square_mm, "MM",
         "side of a square (default: 25, or what the paper holds)", 1, 1000},
        {"tag-mm", 0, SHEEN_OPTION_NUMBER, &a->tag_mm, "MM",
         "side of a tag's black border (default: 0.72 of a\nsquare: 18 for 25)", 0.5, 900},
        {"first-id", 0, SHEEN_OPTION_INT, &a->first_id, "N", "id of the first tag (default: 0)", 0, 586},
        {"blank-mm", 0, SHEEN_OPTION_NUMBER, &a->blank_mm, "MM",
         "diameter of a white disc in the middle, for the object", 0, 10000},
        {"count", 0, SHEEN_OPTION_INT, &a->n_boards, "N",
         "boards with ids of their own: a ring of sheets about\nthe object, or the sides of a box", 1,
         SHEEN_BOARD_SET_MAX},
        {"measured-mm", 0, SHEEN_OPTION_NUMBER, &a->measured_mm, "MM",
         "prints nothing: what all squares across measure on\nthe print; board.json's lengths are set by it",
         1, 10000},
        {0},
    };
    sheen_status s = sheen_cli_parse(cli, options, 0, 0, err);
    if (s || cli->wants_help)
        return s;
    if (!a->output)
        return sheen_cli_usage(cli, err, "where to? Give -o board.pdf");
    const char *extension = sheen_path_extension(a->output);
    const bool json = !strcasecmp(extension, "json") && isfinite(a->measured_mm);
    if (!json && strcasecmp(extension, "pdf") != 0 && strcasecmp(extension, "svg") != 0)
        return sheen_cli_usage(cli, err, "'%s' is neither a .pdf nor a .svg", a->output);
    return SHEEN_OK;
}

// The output's name with another ending, and before it `part` ("" or "-sheet-1").
static sheen_status name_beside(char path[SHEEN_PATH_MAX], const board_args *a, const char *part,
                                const char *extension, sheen_err *err)
{
    const int stem = (int)(strlen(a->output) - strlen(sheen_path_extension(a->output)) - 1);
    const int n = snprintf(path, SHEEN_PATH_MAX, "%.*s%s.%s", stem, a->output, part, extension);
    return n < SHEEN_PATH_MAX ? SHEEN_OK : sheen_fail(err, SHEEN_EARG, "the path is too long");
}

static sheen_status rescale(sheen_cli *cli, const board_args *a, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_board_set set;
    sheen_status s = name_beside(path, a, "", "json", err);
    if (!s)
        s = sheen_board_set_load(&set, path, err);
    if (s)
        return s;
    const double before_mm = 1000 * set.boards[0].square_m * set.boards[0].n_cols;
    const double factor = a->measured_mm / before_mm;
    if (fabs(factor - 1) > 0.2)
        s = sheen_fail(
            err, SHEEN_EARG,
            "%g mm is far from the %g mm of the %d squares across: measure from the first square's "
            "left edge to the last one's right edge",
            a->measured_mm, before_mm, set.boards[0].n_cols);
    for (size_t i = 0; i < set.n_boards && !s; i++)
        sheen_board_scale(&set.boards[i], factor);
    if (!s)
        s = sheen_boards_save(set.boards, set.n_boards, path, err);
    if (!s) {
        sheen_cli_say(cli, "%s: %d squares across measure %g mm (before: %g mm), a square %.4g mm", path,
                      set.boards[0].n_cols, a->measured_mm, before_mm, 1000 * set.boards[0].square_m);
        sheen_json_put_string(&cli->out, "board", path);
        sheen_json_put_number(&cli->out, "factor", factor);
        sheen_json_put_number(&cli->out, "square_m", set.boards[0].square_m);
    }
    sheen_board_set_release(&set);
    return s;
}

static sheen_status plan(sheen_sheet *sheet, sheen_board_layout *layout, const board_args *a, sheen_err *err)
{
    *layout = (sheen_board_layout){.n_cols = a->squares[0],
                                   .n_rows = a->squares[1],
                                   .square_m = a->square_mm / 1000,
                                   .first_id = a->first_id,
                                   .blank_radius_m = a->blank_mm / 2000};
    sheen_status s = SHEEN_OK;
    if (!isfinite(a->square_mm)) {
        s = sheen_sheet_largest_square(&layout->square_m, a->paper, layout->n_cols, layout->n_rows, err);
        const bool usual = layout->square_m > 0.025 && a->squares[0] == 12 && a->squares[1] == 9;
        layout->square_m = usual ? 0.025 : layout->square_m;
    }
    layout->tag_side_m = isfinite(a->tag_mm) ? a->tag_mm / 1000 : 0.72 * layout->square_m;
    return s ? s : sheen_sheet_plan(sheet, a->paper, layout->n_cols, layout->n_rows, layout->square_m, err);
}

static sheen_status make_boards(sheen_board_set *set, sheen_board_layout layout, int n, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    for (int i = 0; i < n && !s; i++) {
        sheen_board *board = &set->boards[i];
        s = sheen_board_make(board, &layout, err);
        if (s)
            break;
        set->n_boards = (size_t)i + 1;
        if (n > 1)
            snprintf(board->name, sizeof board->name, "sheet-%d", i + 1);
        layout.first_id += (int)board->n_tags;
    }
    return s;
}

static sheen_status print(const sheen_board_set *set, const sheen_sheet *sheet, const board_args *a,
                          sheen_err *err)
{
    if (!strcasecmp(sheen_path_extension(a->output), "pdf"))
        return sheen_sheet_print(set->boards, set->n_boards, sheet, SHEEN_SHEET_PDF, a->output, err);
    sheen_status s = SHEEN_OK;
    for (size_t i = 0; i < set->n_boards && !s; i++) {
        char path[SHEEN_PATH_MAX], part[48] = "";
        if (set->n_boards > 1)
            snprintf(part, sizeof part, "-%.31s", set->boards[i].name);
        s = name_beside(path, a, part, "svg", err);
        if (!s)
            s = sheen_sheet_print(&set->boards[i], 1, sheet, SHEEN_SHEET_SVG, path, err);
    }
    return s;
}

static void say(sheen_cli *cli, const board_args *a, const sheen_board_layout *layout,
                const sheen_board_set *set, const sheen_sheet *sheet, const char *json_path)
{
    int last_id = a->first_id - 1;
    for (size_t i = 0; i < set->n_boards; i++)
        last_id += (int)set->boards[i].n_tags;
    sheen_cli_say(cli,
                  "%s: %zu page%s of %g x %g mm, each %d x %d squares of %g mm (%g x %g mm), tags %d to %d",
                  a->output, set->n_boards, sheen_cli_plural(set->n_boards), sheet->width_mm,
                  sheet->height_mm, layout->n_cols, layout->n_rows, 1000 * layout->square_m,
                  sheet->board_width_mm, sheet->board_height_mm, a->first_id, last_id);
    sheen_cli_say(cli,
                  "%s: their measures. Print at 100 %%, glue the print to something flat, measure the %d "
                  "squares across",
                  json_path, layout->n_cols);
    sheen_cli_say(cli, "with a good ruler, and where they are not %g mm: sheen board -o %s --measured-mm MM",
                  sheet->board_width_mm, a->output);
    sheen_json_put_string(&cli->out, "made", a->output);
    sheen_json_put_string(&cli->out, "board", json_path);
    sheen_json_put_int(&cli->out, "boards", (long long)set->n_boards);
    sheen_json_put_number(&cli->out, "square_m", layout->square_m);
    sheen_json_put_number(&cli->out, "tag_side_m", layout->tag_side_m);
    sheen_json_put_int(&cli->out, "first_id", a->first_id);
    sheen_json_put_int(&cli->out, "last_id", last_id);
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    board_args a;
    char json_path[SHEEN_PATH_MAX];
    sheen_sheet sheet;
    sheen_board_layout layout;
    sheen_board boards[SHEEN_BOARD_SET_MAX] = {0};
    sheen_board_set set = {.boards = boards};
    sheen_status s = parse(cli, &a, err);
    if (s || cli->wants_help)
        return s;
    if (isfinite(a.measured_mm))
        return rescale(cli, &a, err);
    s = plan(&sheet, &layout, &a, err);
    if (!s)
        s = make_boards(&set, layout, a.n_boards, err);
    if (!s)
        s = print(&set, &sheet, &a, err);
    if (!s)
        s = name_beside(json_path, &a, "", "json", err);
    if (!s)
        s = sheen_boards_save(set.boards, set.n_boards, json_path, err);
    if (!s)
        say(cli, &a, &layout, &set, &sheet, json_path);
    for (size_t i = 0; i < set.n_boards; i++)
        sheen_board_release(&set.boards[i]);
    return s == SHEEN_EARG ? sheen_cli_option_status(cli, s) : s; // sizes and ids that do not fit
}

const sheen_command sheen_cmd_board = {
    .name = "board",
    .synopsis = "-o FILE.pdf [options]",
    .summary = "prints a board to calibrate from and to put the object on",
    .about = "A chessboard with an AprilTag (tag36h11) in each white square, as vector PDF or SVG, with "
             "rulers to\n"
             "check the print by, and board.json beside it, which says where every tag and corner is.\n",
    .example = "  sheen board -o board.pdf --paper a4 --blank-mm 120\n"
               "  sheen board -o board.pdf --measured-mm 227.4\n",
    .run = run,
};
