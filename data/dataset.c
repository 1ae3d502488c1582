/* SPDX-License-Identifier: Apache-2.0 */
/* What all datasets share: checked reading, the object table, projection. */
#include "data/dataset.h"

#include "assets/ycb/ycb.h"
#include "data/slip.h"
#include "libtensor/geometry/box21.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/io/file.h"
#include "libtensor/io/mesh/obj.h"
#include "vision/silhouette.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

lt_status dataset_read(const dataset *d, int64_t index, unsigned want, lt_arena *arena,
                       dataset_sample *out)
{
    if (index < 0 || index >= d->count)
        return lt_error(LT_EINVAL, "%s: no sample %lld, there are %lld", d->root, (long long)index,
                        (long long)d->count);
    return d->ops->read(d, index, want, arena, out);
}

lt_status dataset_annotation(const dataset *d, int64_t index, lt_arena *arena, dataset_sample *out)
{
    if (index < 0 || index >= d->count)
        return lt_error(LT_EINVAL, "%s: no sample %lld, there are %lld", d->root, (long long)index,
                        (long long)d->count);
    return d->ops->annotation(d, index, arena, out);
}

const char *dataset_name(const dataset *d, int64_t index)
{
    return d->ops->name(d, index);
}

void dataset_free(dataset *d)
{
    if (d)
        d->ops->free(d);
}

const char *dataset_plain_name(const char *name)
{
    return strncmp(name, "syn_", 4) ? name : name + 4;
}

int dataset_find_object(const dataset *d, const char *name)
{
    for (int i = 0; i < d->n_objects; i++)
        if (!strcmp(dataset_plain_name(d->objects[i].name), dataset_plain_name(name)))
            return i;
    return -1;
}

/* ---- projection ---- */

static const double FAR_OUTSIDE = 1e5;          /* pixels */

static lt_status project(const dataset_sample *s, const char *what, int i, const double p[3], float out[2])
{
    double uv[2];

    if (!lt_camera_project(&s->camera, p, uv))
        return lt_error(LT_EFORMAT, "%s: %s %d lies behind the camera, at z = %.4g m", s->name, what, i, p[2]);
    if (!(fabs(uv[0]) < FAR_OUTSIDE && fabs(uv[1]) < FAR_OUTSIDE))
        return lt_error(LT_EFORMAT, "%s: %s %d projects to (%.4g, %.4g), far outside the image", s->name,
                        what, i, uv[0], uv[1]);
    out[0] = (float)uv[0];
    out[1] = (float)uv[1];
    return LT_OK;
}

static lt_status project_joints(dataset_sample *s)
{
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const double p[3] = { s->joints[i][0], s->joints[i][1], s->joints[i][2] };
        const lt_status st = project(s, "hand joint", i, p, s->joints2d[i]);
        if (st)
            return st;
    }
    return LT_OK;
}

void dataset_model_to_camera(const dataset_sample *s, float A[9])
{
    for (int i = 0; i < 9; i++)
        A[i] = i % 3 == 0 && (s->flags & SAMPLE_MIRRORED) ? -s->R[i] : s->R[i];
}

object_shape dataset_shape(const dataset_object *o, unsigned flags)
{
    return flags & SAMPLE_MIRRORED ? (object_shape){ o->mirrored, o->mirrored_surface }
                                   : (object_shape){ o->control, o->surface };
}

static lt_status project_object(const dataset_object *o, dataset_sample *s)
{
    float A[9];

    dataset_model_to_camera(s, A);
    for (int i = 0; i < LT_BOX_POINTS; i++) {
        double p[3];
        lt_status st;
        for (int k = 0; k < 3; k++)
            p[k] = (double)A[3 * k] * o->control[i][0] + (double)A[3 * k + 1] * o->control[i][1] +
                   (double)A[3 * k + 2] * o->control[i][2] + s->t[k];
        st = project(s, "object control point", i, p, s->control2d[i]);
        if (st)
            return st;
    }
    return LT_OK;
}

lt_status dataset_project(const dataset *d, dataset_sample *s)
{
    lt_status st = LT_OK;

    if (s->flags & SAMPLE_JOINTS)
        st = project_joints(s);
    if (!st && (s->flags & SAMPLE_OBJECT))
        st = project_object(&d->objects[s->object], s);
    return st;
}

lt_status dataset_draw_silhouette(const dataset *d, lt_arena *arena, dataset_sample *s)
{
    uint8_t *mask;
    float A[9];
    lt_status st = lt_arena_try(arena, (size_t)s->width * (size_t)s->height, (void **)&mask);

    dataset_model_to_camera(s, A);
    if (!st)
        st = silhouette_draw(&d->objects[s->object].mesh, A, s->t, &s->camera, mask, s->width,
                             s->height, arena);
    if (!st)
        s->silhouette = mask;
    return st;
}

/* ---- objects ---- */

typedef struct { double r; const float *p; } spoke;

static int longer_first(const void *a, const void *b)
{
    const double ra = ((const spoke *)a)->r, rb = ((const spoke *)b)->r;

    return ra > rb ? -1 : ra < rb;
}

static double distance(const float *a, const float *b)
{
    return sqrt(pow((double)a[0] - b[0], 2) + pow((double)a[1] - b[1], 2) + pow((double)a[2] - b[2], 2));
}

/* The largest distance between two of n points: two points can only beat the best so far when their
 * distances from a common centre add up to more. */
static double diameter_of(const float (*point)[3], int n, const float *centre, spoke *by_length)
{
    double best = 0;

    for (int i = 0; i < n; i++)
        by_length[i] = (spoke){ distance(point[i], centre), point[i] };
    qsort(by_length, (size_t)n, sizeof(*by_length), longer_first);
    for (int i = 0; i < n && 2 * by_length[i].r > best; i++)
        for (int j = i + 1; j < n && by_length[i].r + by_length[j].r > best; j++)
            best = fmax(best, distance(by_length[i].p, by_length[j].p));
    return best;
}

/* What a hand may hold, metres; a coin and a guitar are within it. */
static const double LEAST_SIZE = 0.002, MOST_SIZE = 5, SMALL = 0.02, LARGE = 1.5;

/* A model in another unit fits no label, and poses estimated with it are somewhere else. */
static lt_status check_size(const dataset_object *o, const char *obj, const char *xyz)
{
    const double size = (double)o->diameter, points = (double)o->diagonal;
    const int power = slip_unit(size, SMALL, LARGE);
    char unit[SLIP_UNIT];

    if (size < LEAST_SIZE || size > MOST_SIZE)
        return lt_error(LT_EFORMAT, "%s: %.3g m across, expected a thing that a hand can hold, in metres%s%s", obj,
                        size, power ? "; it looks as if the model is " : "",
                        power ? slip_unit_words(power, false, unit) : "");
    if (points > 10 * size || points < size / 10)
        return lt_error(LT_EFORMAT, "%s: %.3g m across, and %s %.3g m: one of them is in another unit than metres", xyz,
                        points, strrchr(obj, '/') + 1, size);
    return LT_OK;
}

lt_status dataset_measure_object(lt_arena *arena, dataset_object *o, const char *obj, const char *path)
{
    double control[LT_BOX_POINTS][3];
    spoke *by_length;
    lt_box box;
    lt_status st = lt_box_from_points(o->n_points, &o->point[0][0], &box);

    if (st)
        return lt_error(LT_EFORMAT, "%s: has no points", path);
    lt_box21(&box, control);
    for (int i = 0; i < LT_BOX_POINTS; i++)
        for (int k = 0; k < 3; k++)
            o->control[i][k] = o->mirrored[i][k] = (float)control[i][k];
    for (int i = 0; i < LT_BOX_POINTS; i++)
        o->mirrored[i][0] = -o->mirrored[i][0];
    o->diagonal = (float)lt_box_diagonal(&box);
    by_length = malloc((size_t)o->mesh.n_vertices * sizeof(*by_length));
    if (!by_length)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    o->diameter = (float)diameter_of((const float (*)[3])o->mesh.vertex, o->mesh.n_vertices, o->control[20],
                                     by_length);
    free(by_length);
    st = check_size(o, obj, path);
    return st ? st : lt_surface_of(arena, &o->mesh, &o->surface, &o->mirrored_surface);
}

static lt_status load_object(lt_arena *arena, const char *folder, dataset_object *o)
{
    const char *obj = lt_arena_printf(arena, "%s/textured_simple.obj", folder);
    const char *xyz = lt_arena_printf(arena, "%s/points.xyz", folder);
    const ycb_object *ycb = ycb_find_name(dataset_plain_name(o->name));
    size_t n = 0;
    lt_status st;

    if (!obj || !xyz)
        return lt_error(LT_ENOMEM, "%s: no memory", folder);
    o->ycb_id = ycb ? ycb->id : 0;
    st = lt_obj_read(arena, obj, &o->mesh, NULL);
    if (!st && !o->mesh.n_faces)            /* any text is an OBJ: of lines that mean nothing */
        st = lt_error(LT_EFORMAT, "%s: %d vertices and 0 triangles, expected a mesh; is it a git-lfs pointer or a "
                      "failed download?", obj, o->mesh.n_vertices);
    if (!st)
        st = lt_xyz_read(arena, xyz, &o->point, &n);
    if (!st && n > 10000000)
        st = lt_error(LT_EFORMAT, "%s: %zu points, expected at most 10 million", xyz, n);
    o->n_points = (int)n;
    return st ? st : dataset_measure_object(arena, o, obj, xyz);
}

/* The folder of a model under either of its names into *folder, or NULL where there is none. */
static lt_status find_model(lt_arena *arena, const char *dir, const char *name, const char **folder,
                            const char **found_as)
{
    const char *names[2] = { lt_arena_strdup(arena, name), lt_arena_printf(arena, "syn_%s", name) };

    *folder = NULL;
    for (int i = 0; i < 2; i++) {
        const char *path = names[i] ? lt_arena_printf(arena, "%s/%s", dir, names[i]) : NULL;
        if (!path)
            return lt_error(LT_ENOMEM, "%s: no memory", dir);
        if (!lt_is_folder(path))
            continue;
        *folder = path;
        *found_as = names[i];
        return LT_OK;
    }
    return LT_OK;
}

lt_status dataset_load_objects(lt_arena *arena, const char *dir, const char *const *names, int n,
                               const dataset_object **out, int *n_out)
{
    dataset_object *objects = lt_arena_array(arena, (size_t)n, sizeof(*objects));
    int found = 0;

    if (!objects)
        return lt_error(LT_ENOMEM, "%s: no memory", dir);
    for (int i = 0; i < n; i++) {
        const char *folder;
        lt_status st = find_model(arena, dir, names[i], &folder, &objects[found].name);
        if (!st && folder)
            st = load_object(arena, folder, &objects[found++]);
        if (st)
            return st;
    }
    if (!found)
        return lt_error(LT_EIO, "%s: has none of the object models (such as %s); they are the YCB models "
                        "of PoseCNN, to be had from the DexYCB and HO3D pages", dir, names[0]);
    *out = objects;
    *n_out = found;
    return LT_OK;
}

const char *dataset_crc32(lt_arena *scratch, const char *root, char hash[16])
{
    static const char *const names[] = { "manifest.json", "train.txt" };
    uint8_t *bytes;
    size_t n;

    *hash = '\0';
    for (size_t i = 0; i < LT_COUNT(names); i++) {
        const char *path = lt_path_join(scratch, root, names[i]);

        if (!path || access(path, R_OK) != 0 || lt_read_file(scratch, path, LT_FILE_MAX, &bytes, &n))
            continue;
        snprintf(hash, 16, "%08lx", (unsigned long)crc32_z(0, bytes, n));
        return names[i];
    }
    return NULL;
}
