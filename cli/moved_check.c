// SPDX-License-Identifier: Apache-2.0
// moved_check.c - holds what a session says of what moved, camera or object, against its poses and its background.
#include "cli/stages.h"
#include "pose/moved.h"

enum { MOST_FRAMES = 12 };

static sheen_status find_moved(sheen_moved_verdict *v, const sheen_session *s, const sheen_poses *poses,
                               sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_camera camera;
    sheen_board board;
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_CAMERA, err);
    if (!st)
        st = sheen_camera_load(&camera, path, err);
    if (!st)
        st = sheen_session_path(path, s, SHEEN_SESSION_BOARD, err);
    if (!st)
        st = sheen_board_load(&board, path, err);
    if (st)
        return st;
    st = sheen_moved_in_session(v, s, &camera, &board, poses, MOST_FRAMES, err);
    sheen_board_release(&board);
    return st;
}

sheen_status sheen_cli_check_moved(sheen_cli *cli, const sheen_session *s, const sheen_poses *poses,
                                   bool *both, sheen_err *err)
{
    static const char *const names[] = {"unknown", "camera", "object", "both"};
    sheen_moved_verdict v;
    *both = false;
    const sheen_status st = find_moved(&v, s, poses, err);
    if (st)
        return st;
    sheen_json_put_string(&cli->out, "moved", names[v.moved]);
    if (v.moved == SHEEN_MOVED_BOTH) {
        sheen_cli_warn(cli, "camera and object both moved: %s; lights stand still in neither, take it again",
                       v.reason);
        *both = cli->limit_missed = true;
    } else if (v.moved != SHEEN_MOVED_UNKNOWN &&
               (v.moved == SHEEN_MOVED_OBJECT) != (s->moving == SHEEN_MOVING_OBJECT)) {
        sheen_cli_warn(
            cli,
            "the session says that the %s moved, but it was the %s: %s (sheen import SESSION --moving %s)",
            sheen_moving_name(s->moving), names[v.moved], v.reason, names[v.moved]);
        cli->limit_missed = true;
    }
    return SHEEN_OK;
}
