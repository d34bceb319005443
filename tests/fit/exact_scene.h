// SPDX-License-Identifier: Apache-2.0
// exact_scene.h - photographs whose every cause is known: lights near or far, points or discs, coloured, any gloss.
//
// The object is a bumpy figure or a sphere, painted in Voronoi cells with hard edges. Its diffuse part is albedo times
// irradiance with cast shadows; its specular part is eq. (7) of the paper, or the GGX microfacet model written out here (and
// nowhere else), each light falling off with the square of its distance and shadowed by the figure. A layout of lights
// follows from the seed. On a turntable the camera stands still, at one height or one after the other, and the
// object turns under the lights; views to score are from the first height. Photographs are then spoilt as asked: noise, 8 bits, clipping, exposure, wrong poses and normals.
#ifndef SHEEN_TESTS_FIT_EXACT_SCENE_H
#define SHEEN_TESTS_FIT_EXACT_SCENE_H

#include "base/mesh.h"
#include "fit/photos.h"

enum { EXACT_LIGHTS = 6, EXACT_CELLS = 160, EXACT_COLOURS = 9 };

typedef struct exact_options {
    const char *name;
    uint64_t seed;
    int sphere;            // else the figure
    int is_near;           // lights 0.55 to 1 m away instead of at infinity
    double disc_deg;       // radius of each light as seen from the object; 0: points
    int coloured, k_s_map; // k_s_map: 1, 0.5 or 0.2 by colour of paint
    int matte;             // k_S 0: lights brighten the paint, and nothing shines
    int metal;             // no diffuse part: all light is reflected at the surface
    double room;           // > 0: a smooth room this bright is mirrored (exact_room), and a metal has a tint
    double sigma_rad;      // of eq. (7)
    double ggx_alpha;      // > 0: GGX of this roughness with F0 = 0.04 instead of eq. (7)
    double brightness;     // times the lights' strength; 0: 1. 2.5 clips highlights
    double noise;          // standard deviation, linear
    int eight_bit;         // sRGB, which also clips at 1
    double pose_px;        // rms image error of the poses handed out
    double normals_deg;    // rms error of the mesh's normals handed out, varying smoothly
    double relief_deg;     // rms slope of a relief that is in the true normals and not in the mesh handed out
    double relief_m;       // its shortest waves; the longest are twice as long. 0: 3 mm
    double drift_ev;       // exposures differ by up to this, either way
    double white_balance;  // red and blue gains differ by up to this share, either way
    double size;           // of the pictures: 1 is 1280 x 960; 0: 1
    size_t n_inputs, n_tests; // 0: 8 and 4
    size_t n_heights;     // of a camera that stands still while the object turns; 0: the object stands still
    double elevation_deg; // of a turntable's first camera, the others 20 degrees higher each; 0: 35
} exact_options;

typedef struct exact_light {
    double v_world[3]; // unit, from the middle of the object
    double distance_m; // HUGE_VAL: far
    double radius_rad; // half of its apparent width
    double rgb[3];     // specular light at the peak of its highlight for k_S = 1, facing the camera
} exact_light;

typedef struct exact_scene {
    exact_options o;
    exact_light lights[EXACT_LIGHTS];
    float cell_obj[EXACT_CELLS][3];
    int cell_colour[EXACT_CELLS];
    double albedo[EXACT_COLOURS][3], k_s[EXACT_COLOURS];
    double tint[EXACT_COLOURS][3]; // of a metal in a room: its reflectance straight on; else 1
    double room_side_world[3], room_rgb[3];
    sheen_mesh mesh;            // as handed to the fit
    sheen_photos inputs, tests; // tests: clean, true poses, exposure 1
    double (*rt_cam_obj)[6];    // [inputs.count] true poses
    double (*gain)[3];          // [inputs.count] exposure and white balance, means 1 (geometric)
    sheen_image *diffuse;       // [tests.count] true layers
    sheen_image *specular;      // [tests.count]
    double clipped_share;       // of the object's pixels in the inputs
} exact_scene;

// The options of a named scene ("far", "near", ...), and their names, ended by NULL. False: no such name.
extern const char *const exact_scene_names[];
int exact_scene_options(exact_options *out, const char *name, uint64_t seed);

void exact_scene_make(exact_scene *out, const exact_options *o);
void exact_scene_release(exact_scene *s);

// Specular light of a surface point for k_S = 1, without shadows of other parts (hidden[i] = 1: light i is hidden).
void exact_specular(double rgb[3], const exact_scene *s, const double p[3], const double n[3],
                    const double v[3], const int hidden[EXACT_LIGHTS]);
// Radiance that the room sends from a unit direction: none from below the horizon, whence it rises to the zenith, one side
// twice as bright as the other. Neither spread by the lobe nor seen twice: another part of the object mirrors nothing.
void exact_room(double rgb[3], const exact_scene *s, const double v_world[3]);
// Which palette colour is painted at a point.
int exact_colour(const exact_scene *s, const float p_obj[3]);

// Root mean square distance, in pixels, between the images of the mesh's vertices under two poses.
double exact_pose_error_px(const exact_scene *s, const double rt_a[6], const double rt_b[6]);

#endif
