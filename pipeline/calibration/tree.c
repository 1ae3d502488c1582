/* SPDX-License-Identifier: Apache-2.0 */
/* The camera in a file of JSON or YAML, whoever wrote it: OpenCV, ROS, RealSense, Kalibr, BOP, DexYCB, Open3D. */
#include "pipeline/calibration/calibration.h"

#include "libtensor/io/text/yaml.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

enum { KEY = 32 };

/* Names without their "_", "-", "." and blanks, in small letters */
static const char *const matrix_names[] = {
    "k", "camk", "cameramatrix", "intrinsicmatrix", "intrinsics", "intrinsic", "cameraintrinsics", "mtx", "m",
};
static const char *const short_names[] = { "intrinsics", "intrinsic", "cameraintrinsics" };     /* of fx, fy, cx, cy */
static const char *const focal_names[][3] = { { "fx", "flx", "fu" }, { "fy", "fly", "fv" } };
static const char *const centre_names[][4] = { { "cx", "ppx", "px", "cu" }, { "cy", "ppy", "py", "cv" } };
static const char *const lens_names[] = {
    "distortioncoefficients", "distortioncoeffs", "distortion", "distcoeffs", "distcoefs", "dist", "coeffs", "d",
};
static const char *const coefficient_names[LT_LENS_COEFFICIENTS] = { "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6" };
static const char *const model_names[] = { "distortionmodel", "cameramodel", "model" };
static const char *const width_names[] = { "imagewidth", "width", "w", "imgwidth" };
static const char *const height_names[] = { "imageheight", "height", "h", "imgheight" };
static const char *const size_names[] = { "resolution", "imagesize", "imgsize", "size" };

/* Lenses with other formulas, whose coefficients mean something else */
static const char *const other_lenses[] = {
    "fisheye", "equidistant", "kannala", "inverse", "ftheta", "omni", "mei", "fov", "thinprism", "division",
    "modified",
};

static void plain_key(const char *key, char out[KEY])
{
    size_t n = 0;

    for (; *key && n + 1 < KEY; key++)
        if (isalnum((unsigned char)*key))
            out[n++] = (char)tolower((unsigned char)*key);
    out[n] = '\0';
}

static bool is_called(const lt_yaml *v, const char *const *names, size_t n)
{
    char key[KEY];

    plain_key(v->key, key);
    for (size_t i = 0; i < n; i++)
        if (names[i] && strcmp(key, names[i]) == 0)
            return true;
    return false;
}

/* The first of a map's values with one of the names; NULL: none */
static const lt_yaml *find(const lt_yaml *map, const char *const *names, size_t n)
{
    if (!map || map->kind != LT_YAML_MAP)
        return NULL;
    for (const lt_yaml *c = map->first; c; c = c->next)
        if (is_called(c, names, n))
            return c;
    return NULL;
}

#define FIND(map, names) find(map, names, LT_COUNT(names))

/* ---- numbers --------------------------------------------------------------------------------------------- */

/* All numbers of a list, of lists in it, or of OpenCV's and ROS's "data"; -1 where there is anything else, or no
 * room. */
static int numbers_of(const lt_yaml *v, double *out, int room)
{
    static const char *const data[] = { "data" };
    int n = 0;

    if (v && v->kind == LT_YAML_MAP)
        v = FIND(v, data);
    if (!v || v->kind != LT_YAML_LIST)
        return -1;
    for (const lt_yaml *row = v->first; row; row = row->next) {
        const int k = row->kind == LT_YAML_LIST ? row->n : 1;

        if (k > room - n || (k > 0 && lt_yaml_numbers(row, out + n, k)))
            return -1;
        n += k;
    }
    return n;
}

static bool number_of(const lt_yaml *v, double *out)
{
    return v && v->kind == LT_YAML_SCALAR && lt_yaml_numbers(v, out, 1) == LT_OK;
}

/* ---- one camera ------------------------------------------------------------------------------------------ */

/* fx, fy, cx, cy as values of their own */
static bool has_lengths(const lt_yaml *map, double x[4])
{
    return number_of(FIND(map, focal_names[0]), &x[0]) && number_of(FIND(map, focal_names[1]), &x[1]) &&
           number_of(FIND(map, centre_names[0]), &x[2]) && number_of(FIND(map, centre_names[1]), &x[3]);
}

/* A matrix or four numbers under one of their names; how many */
static int find_matrix(const lt_yaml *map, double m[9])
{
    if (map->kind != LT_YAML_MAP)
        return 0;
    for (const lt_yaml *c = map->first; c; c = c->next) {
        const int n = is_called(c, matrix_names, LT_COUNT(matrix_names)) ? numbers_of(c, m, 9) : 0;

        if (n == 9 || (n == 4 && is_called(c, short_names, LT_COUNT(short_names))))
            return n;
    }
    return 0;
}

static lt_status refuse_model(const lt_yaml *v)
{
    char model[KEY];

    plain_key(v->text, model);
    for (size_t i = 0; i < LT_COUNT(other_lenses); i++)
        if (strstr(model, other_lenses[i]))
            return lt_error(LT_EFORMAT, "%s:%d: a lens of the model %.40s, want OpenCV's plumb bob or rational one; "
                            "undistort the pictures first", v->path, v->line, v->text);
    return LT_OK;
}

static int lens_numbers(const lt_yaml *map, double *c, int room)
{
    const lt_yaml *list = FIND(map, lens_names);
    int n = numbers_of(list, c, room), named = 0;

    if (n > 0)
        return n;
    for (int i = 0; i < LT_LENS_COEFFICIENTS; i++) {
        const char *const name[] = { coefficient_names[i] };

        c[i] = 0;
        named += number_of(find(list && list->kind == LT_YAML_MAP ? list : map, name, 1), &c[i]);
    }
    return named ? LT_LENS_COEFFICIENTS : 0;
}

static lt_status read_lens(const lt_yaml *map, calibration *out)
{
    const lt_yaml *model = FIND(map, model_names);
    double c[14];
    const int n = lens_numbers(map, c, LT_COUNT(c));
    bool any = false;
    lt_status st;

    for (int i = 0; i < n; i++)
        any = any || c[i] != 0;
    if (!any)
        return LT_OK;
    st = model && model->kind == LT_YAML_SCALAR ? refuse_model(model) : LT_OK;
    if (!st && lt_lens_from_opencv(c, n, &out->lens))
        st = lt_error_prefix(LT_EFORMAT, "%s:%d", map->path, map->line);
    return st;
}

static void read_size(const lt_yaml *map, calibration *out)
{
    double size[2];
    const bool known = numbers_of(FIND(map, size_names), size, 2) == 2 ||
                       (number_of(FIND(map, width_names), &size[0]) && number_of(FIND(map, height_names), &size[1]));

    if (known && size[0] >= 1 && size[1] >= 1 && size[0] <= 1e6 && size[1] <= 1e6) {
        out->width = (int)size[0];
        out->height = (int)size[1];
    }
}

/* ---- all cameras of a file ------------------------------------------------------------------------------- */

typedef struct { const lt_yaml *map, *around; } place;

typedef struct {
    place first, other, colour;     /* other: of other numbers than the first; a file may have one for each picture */
    double x[9];                    /* of the first */
} cameras;

/* fx, fy, cx, cy or a matrix, whichever it is; how many, 0: none */
static int camera_of(const lt_yaml *map, double x[9])
{
    return has_lengths(map, x) ? 4 : find_matrix(map, x);
}

static void add_camera(cameras *all, const lt_yaml *map, const lt_yaml *around, const double *x, int n)
{
    static const char *const colour[] = { "color", "colour", "rgb" };
    const place p = { map, around };

    if (is_called(map, colour, LT_COUNT(colour)))
        all->colour = p;
    if (!all->first.map) {
        all->first = p;
        memcpy(all->x, x, (size_t)n * sizeof(*x));
    } else if (!all->other.map && memcmp(all->x, x, (size_t)n * sizeof(*x)) != 0) {
        all->other = p;
    }
}

static void find_cameras(const lt_yaml *v, const lt_yaml *around, cameras *all)
{
    double x[9];
    const int n = camera_of(v, x);

    if (n)
        add_camera(all, v, around, x, n);
    for (const lt_yaml *c = v->first; c && !n; c = c->next)
        if (c->kind != LT_YAML_SCALAR)
            find_cameras(c, v, all);
}

static lt_status read_camera(const place *p, calibration *out)
{
    double x[9];
    char where[256];
    lt_status st;

    snprintf(where, sizeof(where), "%s:%d", p->map->path, p->map->line);
    if (camera_of(p->map, x) == 9)
        st = calibration_set_matrix(where, x, out);
    else
        st = calibration_set_matrix(where, (const double[9]){ x[0], 0, x[2], 0, x[1], x[3], 0, 0, 1 }, out);
    st = st ? st : read_lens(p->map, out);
    if (st)
        return st;
    if (lt_lens_is_none(&out->lens) && p->around && p->around->kind == LT_YAML_MAP)
        st = read_lens(p->around, out);
    read_size(p->map, out);
    if (!out->width && p->around)
        read_size(p->around, out);
    return st;
}

/* Where a file has several, that of colour counts: RealSense's and DexYCB's have depth beside it. */
lt_status calibration_from_tree(const lt_yaml *root, calibration *out)
{
    cameras all = { .first = { NULL, NULL } };

    find_cameras(root, NULL, &all);
    if (all.colour.map)
        return read_camera(&all.colour, out);
    if (all.other.map)
        return lt_error(LT_EFORMAT, "%s:%d: several cameras, another in line %d; want a file of one", root->path,
                        all.first.map->line, all.other.map->line);
    if (all.first.map)
        return read_camera(&all.first, out);
    return lt_error(LT_EFORMAT, "%s: no camera; want fx, fy, cx and cy, or a matrix called K or camera_matrix",
                    root->path);
}
