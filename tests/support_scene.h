// SPDX-License-Identifier: Apache-2.0
// support_scene.h - meshes, cameras and a plain ray tracer for the tests of render and fit.
#ifndef SHEEN_TESTS_SUPPORT_SCENE_H
#define SHEEN_TESTS_SUPPORT_SCENE_H

#include "base/camera.h"
#include "base/mesh.h"
#include "render/scene.h"

// A sphere about centre_obj: the icosahedron with every side cut in `frequency` pieces, 20 frequency^2
// triangles; normals are the sphere's own. Release with sheen_mesh_release.
void test_sphere(sheen_mesh *mesh, int frequency, const float centre_obj[3], float radius_m);
// A figure with bumps that hide one another: the sphere of radius_m about the origin, displaced along its
// normals by up to bump_m; normals from the triangles.
void test_figure(sheen_mesh *mesh, int frequency, float radius_m, float bump_m);
// One triangle, or several: 9 numbers each, in metres; normals from the triangles.
void test_triangles(sheen_mesh *mesh, const float *corners_obj, size_t n_triangles);

// width x height, f px, principal point a little off the middle. Distorted: LENSMODEL_OPENCV5.
void test_camera(sheen_camera *cam, int width_px, int height_px, double f_px, int distorted);
// Pose that looks from a point of frame obj at its origin, z up in the picture.
void test_look(double rt_cam_obj[6], double x_m, double y_m, double z_m);

// First hit of a ray with the mesh, every triangle tried in turn (Moeller and Trumbore), in double precision.
sheen_hit test_first_hit(const sheen_mesh *mesh, const double origin_obj[3], const double v_obj[3]);

// A random unit vector.
void test_direction(float v[3], uint64_t *seed);

#endif
