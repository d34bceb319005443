// SPDX-License-Identifier: Apache-2.0
// fixtures.h - small input files of every kind that sheen reads, made on the spot.
//
// All belong together: a ball of 30 mm on the board, seen by a pinhole camera from a ring about it.
#ifndef SHEEN_TESTS_CAPTURE_FIXTURES_H
#define SHEEN_TESTS_CAPTURE_FIXTURES_H

// A picture by the ending of its name (.png, .jpg, .exr): a pattern that depends on `seed`; with flat = 1 one even grey.
void fixture_picture(const char *path, int width_px, int height_px, unsigned seed, int flat);
// White disc on black, PNG.
void fixture_mask(const char *path, int width_px, int height_px);
// 4 x 4 squares of 30 mm.
void fixture_board(const char *path);
// The ball, as OBJ; its centre is `offset_m` away from the board's axis along x.
void fixture_mesh(const char *path, double offset_m);
// A pinhole for pictures of this size.
void fixture_camera(const char *path, int width_px, int height_px);
// transforms.json with the camera and one pose for each name, on a ring at 0.5 m that looks at the ball.
void fixture_poses(const char *path, int width_px, int height_px, const char *const *names, int n_names);

// <dir>/<name>.png for each of those poses: the ball as it looks there, striped, matte and shiny, under three far lamps.
void fixture_shiny(const char *dir, int width_px, int height_px, const char *const *names, int n_names);

// A figure of four balls, which looks another from every side. As OBJ whose y is up, with `per_m` units in a metre.
void fixture_figure(const char *path, double per_m);
// <dir>/<name>.png for each of those poses: its mask, or its picture, shaded on a grey ground. Of its first n_balls balls:
// of 4, or of one, which is fixture_mesh's ball.
void fixture_figure_views(const char *dir, int width_px, int height_px, const char *const *names, int n_names,
                          int masks, int n_balls);
// Marks of six points of it in each of those pictures: lines "frame x y X Y Z" in the OBJ's frame and unit.
void fixture_figure_marks(const char *path, int width_px, int height_px, const char *const *names,
                          int n_names, double per_m);

#endif
