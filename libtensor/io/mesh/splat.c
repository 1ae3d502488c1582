/* SPDX-License-Identifier: Apache-2.0 */
/* Gaussians as .splat and as binary glTF. */
#include "libtensor/io/mesh/splat.h"

#include "libtensor/geometry/harmonics.h"
#include "libtensor/io/mesh/glb_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static lt_status check_splats(const char *path, const lt_splat *splat, size_t n)
{
    if (n < 1)
        return lt_error(LT_EINVAL, "%s: no Gaussians to write", path);
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < sizeof(*splat) / sizeof(float); k++)
            if (!isfinite(((const float *)&splat[i])[k]))
                return lt_error(LT_EINVAL, "%s: Gaussian %zu is not finite", path, i);
    return LT_OK;
}

/* ---- one Gaussian's numbers ----------------------------------------------------------------------------------- */

static double opacity_of(const lt_splat *s)
{
    return 1 / (1 + exp(-(double)s->opacity));
}

void lt_splat_rgb(const lt_splat *s, double rgb[3])
{
    for (int k = 0; k < 3; k++)
        rgb[k] = 0.5 + LT_SH_C0 * (double)s->dc[k];
}

void lt_splat_paint(lt_splat *s, const double rgb[3])
{
    for (int k = 0; k < 3; k++)
        s->dc[k] = (float)((rgb[k] - 0.5) / LT_SH_C0);
}

/* As a display shows it, 0 to 1 */
static void shown_colour(const lt_splat *s, double rgb[3])
{
    lt_splat_rgb(s, rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] = fmin(1, fmax(0, rgb[k]));
}

static double linear(double x)
{
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

/* w x y z of length 1; a rotation that is none turns nothing */
static void unit_rotation(const lt_splat *s, double q[4])
{
    double square = 0;

    for (int k = 0; k < 4; k++)
        square += (double)s->rotation[k] * (double)s->rotation[k];
    for (int k = 0; k < 4; k++)
        q[k] = square > 0 ? (double)s->rotation[k] / sqrt(square) : k == 0;
}

/* ---- .splat --------------------------------------------------------------------------------------------------- */

typedef struct { double weight; size_t index; } ranked;

static int by_weight(const void *a, const void *b)
{
    const ranked *x = a, *y = b;

    if (x->weight != y->weight)
        return x->weight > y->weight ? -1 : 1;
    return x->index < y->index ? -1 : x->index > y->index;
}

static void put_byte(FILE *f, double x)
{
    fputc((int)fmin(255, fmax(0, rint(x))), f);
}

static void put_splat(FILE *f, const lt_splat *s)
{
    double q[4], rgb[3];

    for (int k = 0; k < 3; k++)
        glb_put_float(f, s->x[k]);
    for (int k = 0; k < 3; k++)
        glb_put_float(f, (float)exp((double)s->scale[k]));
    shown_colour(s, rgb);
    for (int k = 0; k < 3; k++)
        put_byte(f, 255 * rgb[k]);
    put_byte(f, 255 * opacity_of(s));
    unit_rotation(s, q);
    for (int k = 0; k < 4; k++)
        put_byte(f, 128 * q[k] + 128);
}

lt_status lt_splat_write(const char *path, const lt_splat *splat, size_t n)
{
    lt_status st = check_splats(path, splat, n);
    ranked *order = st ? NULL : lt_alloc(n * sizeof(*order));
    lt_atomic_file f;

    if (st)
        return st;
    st = order ? lt_atomic_open(&f, path) : lt_error(LT_ENOMEM, "%s: no memory for %zu Gaussians", path, n);
    if (!st) {
        for (size_t i = 0; i < n; i++) {
            const float *s = splat[i].scale;

            order[i] = (ranked){ exp((double)s[0] + (double)s[1] + (double)s[2]) * opacity_of(&splat[i]), i };
        }
        qsort(order, n, sizeof(*order), by_weight);
        for (size_t i = 0; i < n; i++)
            put_splat(f.stream, &splat[order[i].index]);
        st = lt_atomic_commit(&f);
    }
    lt_release(order);
    return st;
}

/* ---- glTF ----------------------------------------------------------------------------------------------------- */

#define EXTENSION "KHR_gaussian_splatting"

static const float ours_to_gltf[3] = { 1, -1, -1 };

/* A harmonic of degree d, number k in it, and its sign where y and z have turned around */
static bool turns(int degree, int k)
{
    static const uint32_t turned = 1 << 1 | 1 << 2 | 1 << 4 | 1 << 7 | 1 << 9 | 1 << 11 | 1 << 12 | 1 << 14;

    return turned >> (degree * degree + k) & 1;
}

static void add_bounds(const glb_builder *b, int accessor, const lt_splat *splat, size_t n)
{
    cJSON *a = cJSON_GetArrayItem(b->accessors, accessor), *min = cJSON_AddArrayToObject(a, "min");
    cJSON *max = cJSON_AddArrayToObject(a, "max");

    for (int k = 0; k < 3; k++) {
        float lo = INFINITY, hi = -INFINITY;

        for (size_t i = 0; i < n; i++) {
            lo = fminf(lo, ours_to_gltf[k] * splat[i].x[k]);
            hi = fmaxf(hi, ours_to_gltf[k] * splat[i].x[k]);
        }
        cJSON_AddItemToArray(min, cJSON_CreateNumber((double)lo));
        cJSON_AddItemToArray(max, cJSON_CreateNumber((double)hi));
    }
}

static void add_attribute(glb_builder *b, cJSON *attributes, const char *name, size_t n, int components)
{
    cJSON_AddNumberToObject(attributes, name, glb_add_array(b, n, components, GLB_FLOAT, GLB_VERTICES));
}

static void add_extension(glb_builder *b, cJSON *primitive)
{
    cJSON *e = cJSON_AddObjectToObject(cJSON_AddObjectToObject(primitive, "extensions"), EXTENSION);

    cJSON_AddStringToObject(e, "kernel", "ellipse");
    cJSON_AddStringToObject(e, "colorSpace", "srgb_rec709_display");
    cJSON_AddStringToObject(e, "projection", "perspective");
    cJSON_AddStringToObject(e, "sortingMethod", "cameraDistance");
    cJSON_AddItemToArray(cJSON_AddArrayToObject(b->root, "extensionsUsed"), cJSON_CreateString(EXTENSION));
}

/* Arrays in the order in which put_arrays puts them */
static char *describe(glb_builder *b, const char *name, const lt_splat *splat, size_t n, int degree)
{
    cJSON *node = glb_add_object(cJSON_GetObjectItem(b->root, "nodes"));
    cJSON *mesh = glb_add_object(cJSON_GetObjectItem(b->root, "meshes"));
    cJSON *primitive = glb_add_object(cJSON_AddArrayToObject(mesh, "primitives"));
    cJSON *attributes = cJSON_AddObjectToObject(primitive, "attributes");

    cJSON_DeleteItemFromObject(b->root, "materials");
    cJSON_AddItemToArray(b->nodes, cJSON_CreateNumber(0));
    cJSON_AddStringToObject(node, "name", name);
    cJSON_AddNumberToObject(node, "mesh", 0);
    cJSON_AddStringToObject(mesh, "name", name);
    cJSON_AddNumberToObject(primitive, "mode", 0);                      /* points */
    add_attribute(b, attributes, "POSITION", n, 3);
    add_bounds(b, 0, splat, n);
    add_attribute(b, attributes, "COLOR_0", n, 4);
    add_attribute(b, attributes, EXTENSION ":ROTATION", n, 4);
    add_attribute(b, attributes, EXTENSION ":SCALE", n, 3);
    add_attribute(b, attributes, EXTENSION ":OPACITY", n, 1);
    for (int d = 0; d <= degree; d++)
        for (int k = 0; k < 2 * d + 1; k++) {
            char key[64];

            snprintf(key, sizeof(key), EXTENSION ":SH_DEGREE_%d_COEF_%d", d, k);
            add_attribute(b, attributes, key, n, 3);
        }
    add_extension(b, primitive);
    return glb_text(b);
}

static void put_colour(FILE *f, const lt_splat *s)
{
    double rgb[3];

    shown_colour(s, rgb);
    for (int k = 0; k < 3; k++)
        glb_put_float(f, (float)linear(rgb[k]));
    glb_put_float(f, (float)opacity_of(s));
}

/* x y z w of the rotation after half a turn around x */
static void put_rotation(FILE *f, const lt_splat *s)
{
    double q[4];

    unit_rotation(s, q);
    glb_put_float(f, (float)q[0]);
    glb_put_float(f, (float)-q[3]);
    glb_put_float(f, (float)q[2]);
    glb_put_float(f, (float)-q[1]);
}

static void put_arrays(FILE *f, const lt_splat *splat, size_t n, int degree)
{
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            glb_put_float(f, ours_to_gltf[k] * splat[i].x[k]);
    for (size_t i = 0; i < n; i++)
        put_colour(f, &splat[i]);
    for (size_t i = 0; i < n; i++)
        put_rotation(f, &splat[i]);
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            glb_put_float(f, expf(splat[i].scale[k]));
    for (size_t i = 0; i < n; i++)
        glb_put_float(f, (float)opacity_of(&splat[i]));
    for (int d = 0; d <= degree; d++)
        for (int k = 0; k < 2 * d + 1; k++)
            for (size_t i = 0; i < n; i++)
                for (int c = 0; c < 3; c++) {
                    const float x = d ? splat[i].rest[c][d * d + k - 1] : splat[i].dc[c];

                    glb_put_float(f, turns(d, k) ? -x : x);
                }
}

lt_status lt_glb_write_splats(const char *path, const char *name, const lt_splat *splat, size_t n, int degree)
{
    glb_builder b;
    lt_atomic_file f;
    lt_status st = check_splats(path, splat, n);
    char *text;

    if (st)
        return st;
    text = glb_begin(&b) ? NULL : describe(&b, name, splat, n, degree);
    st = text ? glb_open(path, text, b.bytes, &f) : lt_error(LT_ENOMEM, "%s: no memory", path);
    if (!st) {
        put_arrays(f.stream, splat, n, degree);
        st = lt_atomic_commit(&f);
    }
    cJSON_free(text);
    cJSON_Delete(b.root);
    return st;
}
