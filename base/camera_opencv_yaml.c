// SPDX-License-Identifier: Apache-2.0
// camera_opencv_yaml.c - calibrations as OpenCV's FileStorage and ROS's camera_info write them, through libyaml.
//
// OpenCV begins its files with "%YAML:1.0", which no YAML parser but its own takes: that line is left out. Both
// kinds put the top-left pixel's centre at (0, 0), as we do.
#include "base/pose_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <yaml.h>

#include "base/image.h"
#include "base/scan.h"

enum { MAX_TEXT_BYTES = 16 << 20, MAX_NUMBERS = 16 };

static sheen_word scalar_word(const yaml_node_t *node)
{
    return (sheen_word){(const char *)node->data.scalar.value, node->data.scalar.length};
}

// The value of a key, or NULL.
static yaml_node_t *find(yaml_document_t *doc, const yaml_node_t *map, const char *key)
{
    if (!map || map->type != YAML_MAPPING_NODE)
        return NULL;
    for (yaml_node_pair_t *p = map->data.mapping.pairs.start; p < map->data.mapping.pairs.top; p++) {
        const yaml_node_t *k = yaml_document_get_node(doc, p->key);
        if (!k || k->type != YAML_SCALAR_NODE)
            continue;
        const sheen_word word = scalar_word(k);
        if (sheen_word_is(&word, key))
            return yaml_document_get_node(doc, p->value);
    }
    return NULL;
}

static yaml_node_t *find_either(yaml_document_t *doc, const yaml_node_t *map, const char *const names[],
                                const char **name_found)
{
    for (int i = 0; names[i]; i++) {
        yaml_node_t *node = find(doc, map, names[i]);
        if (node) {
            *name_found = names[i];
            return node;
        }
    }
    *name_found = names[0];
    return NULL;
}

// The numbers of a sequence, or of the "data" of a matrix.
static sheen_status read_numbers(yaml_document_t *doc, const yaml_node_t *node, const char *name, double *out,
                                 int *n, sheen_err *err)
{
    if (node->type == YAML_MAPPING_NODE)
        node = find(doc, node, "data");
    if (!node || node->type != YAML_SEQUENCE_NODE)
        return sheen_fail(err, SHEEN_EFORMAT, "'%s' is not a list of numbers", name);
    *n = 0;
    for (yaml_node_item_t *i = node->data.sequence.items.start; i < node->data.sequence.items.top; i++) {
        const yaml_node_t *item = yaml_document_get_node(doc, *i);
        const sheen_word word = item && item->type == YAML_SCALAR_NODE ? scalar_word(item)
                                                                       : (sheen_word){"", 0};
        double x;
        if (*n == MAX_NUMBERS)
            return sheen_fail(err, SHEEN_EFORMAT, "'%s' has more than %d numbers", name, MAX_NUMBERS);
        if (!sheen_word_number(&word, &x))
            return sheen_fail(err, SHEEN_EFORMAT, "'%s' holds something else than finite numbers", name);
        out[(*n)++] = x;
    }
    return SHEEN_OK;
}

// fx fy cx cy of a 3x3 matrix.
static sheen_status read_matrix(yaml_document_t *doc, const yaml_node_t *root, double fxycxy[4],
                                sheen_err *err)
{
    static const char *const names[] = {"camera_matrix", "cameraMatrix", "Camera_Matrix", NULL};
    const char *name;
    double K[MAX_NUMBERS];
    int n = 0;
    const yaml_node_t *node = find_either(doc, root, names, &name);
    if (!node)
        return sheen_fail(err, SHEEN_EFORMAT, "it has no 'camera_matrix'");
    const sheen_status s = read_numbers(doc, node, name, K, &n, err);
    if (s)
        return s;
    if (n != 9 || K[3] != 0 || K[6] != 0 || K[7] != 0 || K[8] != 1)
        return sheen_fail(err, SHEEN_EFORMAT, "'%s' is not of the form fx 0 cx, 0 fy cy, 0 0 1", name);
    if (K[1] != 0)
        return sheen_fail(err, SHEEN_EUNSUP, "'%s' has a skew of %g, which no lens model here has", name,
                          K[1]);
    const double values[4] = {K[0], K[4], K[2], K[5]};
    memcpy(fxycxy, values, sizeof values);
    return SHEEN_OK;
}

static sheen_status read_distortion(yaml_document_t *doc, const yaml_node_t *root, double *out, int *n,
                                    sheen_err *err)
{
    static const char *const names[] = {"distortion_coefficients", "dist_coeffs", "distCoeffs",
                                        "Distortion_Coefficients", NULL};
    const char *name;
    const yaml_node_t *node = find_either(doc, root, names, &name);
    if (!node)
        return sheen_fail(err, SHEEN_EFORMAT, "it has no 'distortion_coefficients'");
    const sheen_status s = read_numbers(doc, node, name, out, n, err);
    if (s)
        return s;
    if (*n == 14)
        return sheen_fail(err, SHEEN_EUNSUP, "a tilted sensor (14 coefficients in '%s') is not supported",
                          name);
    if (*n != 0 && *n != 4 && *n != 5 && *n != 8 && *n != 12)
        return sheen_fail(err, SHEEN_EFORMAT, "'%s' has %d coefficients, not 0, 4, 5, 8 or 12", name, *n);
    return SHEEN_OK;
}

// ROS names the model; OpenCV's calibration sample marks fisheye lenses. Their coefficients look like any other.
static sheen_status check_model(yaml_document_t *doc, const yaml_node_t *root, sheen_err *err)
{
    static const char *const known[] = {"plumb_bob", "rational_polynomial", "none", ""};
    const yaml_node_t *node = find(doc, root, "distortion_model");
    if (node && node->type == YAML_SCALAR_NODE) {
        const sheen_word word = scalar_word(node);
        bool is_known = false;
        for (size_t i = 0; i < sizeof known / sizeof *known; i++)
            is_known |= sheen_word_is(&word, known[i]);
        if (!is_known)
            return sheen_fail(err, SHEEN_EUNSUP, "distortion model '%.*s' is not supported: use plumb_bob",
                              word.length < 40 ? (int)word.length : 40, word.text);
    }
    node = find(doc, root, "fisheye_model");
    if (node && node->type == YAML_SCALAR_NODE) {
        const sheen_word word = scalar_word(node);
        if (!sheen_word_is(&word, "0") && !sheen_word_is(&word, "false"))
            return sheen_fail(err, SHEEN_EUNSUP, "a fisheye calibration is not supported: calibrate anew");
    }
    return SHEEN_OK;
}

static bool read_side(yaml_document_t *doc, const yaml_node_t *root, const char *const names[], int *side_px)
{
    const char *name;
    long long x;
    const yaml_node_t *node = find_either(doc, root, names, &name);
    if (!node || node->type != YAML_SCALAR_NODE)
        return false;
    const sheen_word word = scalar_word(node);
    if (!sheen_word_integer(&word, 1, SHEEN_IMAGE_MAX_SIDE_PX, &x))
        return false;
    *side_px = (int)x;
    return true;
}

static sheen_status read_size(yaml_document_t *doc, const yaml_node_t *root, int size_px[2], sheen_err *err)
{
    static const char *const widths[] = {"image_width", "image_Width", NULL};
    static const char *const heights[] = {"image_height", "image_Height", NULL};
    static const char *const sizes[] = {"image_size", "imageSize", NULL};
    const char *name;
    double size[MAX_NUMBERS];
    int n = 0;
    if (read_side(doc, root, widths, &size_px[0]) && read_side(doc, root, heights, &size_px[1]))
        return SHEEN_OK;
    const yaml_node_t *node = find_either(doc, root, sizes, &name);
    if (node) {
        const sheen_status s = read_numbers(doc, node, name, size, &n, err);
        if (s)
            return s;
        for (int i = 0; i < 2; i++) {
            if (n != 2 || !(size[i] >= 1 && size[i] <= SHEEN_IMAGE_MAX_SIDE_PX) || size[i] != floor(size[i]))
                return sheen_fail(err, SHEEN_EFORMAT, "'%s' is not a width and a height in pixels", name);
            size_px[i] = (int)size[i];
        }
    }
    if (size_px[0] < 1 || size_px[1] < 1)
        return sheen_fail(err, SHEEN_EFORMAT,
                          "it states no image_width and image_height, and no image tells them");
    return SHEEN_OK;
}

static sheen_status read_camera(sheen_camera *cam, yaml_document_t *doc, int size_px[2], sheen_err *err)
{
    const yaml_node_t *root = yaml_document_get_root_node(doc);
    double fxycxy[4], distortion[MAX_NUMBERS];
    int n = 0;
    sheen_status s = read_matrix(doc, root, fxycxy, err);
    if (!s)
        s = check_model(doc, root, err);
    if (!s)
        s = read_distortion(doc, root, distortion, &n, err);
    if (!s)
        s = read_size(doc, root, size_px, err);
    if (!s)
        s = sheen_camera_opencv(cam, size_px[0], size_px[1], fxycxy, distortion, n, err);
    if (s != SHEEN_EARG)
        return s;
    if (err) // the file's fault, not the caller's
        err->code = SHEEN_EFORMAT;
    return SHEEN_EFORMAT;
}

sheen_status sheen_opencv_yaml_parse(sheen_camera *cam, const void *data, size_t size_bytes, int width_px,
                                     int height_px, sheen_err *err)
{
    *cam = (sheen_camera){0};
    if (!size_bytes || size_bytes > MAX_TEXT_BYTES)
        return sheen_fail(err, SHEEN_EFORMAT, "a camera's YAML of %zu bytes is empty or too large",
                          size_bytes);
    sheen_scan text = {data, (const char *)data + size_bytes, 0}, line;
    static const char opencv[] = "%YAML:";
    if (size_bytes >= sizeof opencv - 1 && !memcmp(data, opencv, sizeof opencv - 1))
        sheen_scan_line(&text, &line);

    yaml_parser_t parser;
    yaml_document_t doc;
    if (!yaml_parser_initialize(&parser))
        return sheen_fail(err, SHEEN_ENOMEM, "out of memory for libyaml");
    yaml_parser_set_input_string(&parser, (const unsigned char *)text.at, (size_t)(text.end - text.at));
    sheen_status s;
    if (yaml_parser_load(&parser, &doc)) {
        int size_px[2] = {width_px, height_px};
        s = read_camera(cam, &doc, size_px, err);
        yaml_document_delete(&doc);
    } else {
        s = sheen_fail(err, SHEEN_EFORMAT, "not valid YAML: %s (line %zu)",
                       parser.problem ? parser.problem : "unknown", parser.problem_mark.line + 1 + text.line);
    }
    yaml_parser_delete(&parser);
    return s;
}
