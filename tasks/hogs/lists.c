/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/lists.h"

#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

enum { BITS = 16, WORDS = OCCUPANCY_CELLS / BITS };     /* cells that a number of a checkpoint holds */
enum { NEAR, VERTEX, SURFACE, INSIDE, ARRAYS };

static const char *const names[ARRAYS] = { "task.near", "task.vertex", "task.surface", "task.inside" };

/* ---- memory ---------------------------------------------------------------------------------------------- */

void hogs_lists_free(hogs_lists *l)
{
    lt_release(l->near);
    lt_release(l->vertex);
    lt_release(l->grid);
    lt_release(l->surface);
    for (int i = 0; i < ARRAYS; i++)
        lt_release(l->saved[i]);
    *l = (hogs_lists){ 0 };
}

static lt_status room_for(hogs_lists *l, const hogs *m)
{
    const int64_t rows = m->gaussians.centre->shape.dim[0];
    const size_t objects = (size_t)m->config.objects;

    if (l->rows == rows)
        return LT_OK;
    hogs_lists_free(l);
    *l = (hogs_lists){
        .rows = rows, .hands = m->config.hands, .objects = m->config.objects,
        .near = lt_alloc((size_t)rows * sizeof(*l->near)), .vertex = lt_alloc((size_t)rows * sizeof(*l->vertex)),
        .grid = lt_alloc(objects * sizeof(*l->grid)), .surface = lt_alloc(objects * sizeof(*l->surface)),
    };
    if (l->near && l->vertex && l->grid && l->surface)
        return LT_OK;
    hogs_lists_free(l);
    return lt_error(LT_ENOMEM, "no memory for the neighbours of %lld Gaussians", (long long)rows);
}

/* ---- one set --------------------------------------------------------------------------------------------- */

/* A set's Gaussians as they are stored, in double */
typedef struct {
    const hogs *m;
    hogs_lists *l;
    const hogs_rig *rig;
    int64_t first, n;
    double (*centre)[3];
    lt_kd_tree tree;
} set_job;

static void neighbours_of(void *ctx, int64_t i)
{
    const set_job *j = ctx;
    lt_kd_neighbour found[HOGS_NEIGHBOURS + 1];
    const int n = lt_kd_tree_nearest(&j->tree, j->centre[i], HOGS_NEIGHBOURS + 1, found);
    int32_t *near = j->l->near[j->first + i];
    int k = 0;

    for (int f = 0; f < n && k < HOGS_NEIGHBOURS; f++)
        if (found[f].index != i)
            near[k++] = found[f].index;
    if (!j->rig)
        return;
    lt_kd_tree_nearest(&j->rig->vertices, j->centre[i], 1, found);
    j->l->vertex[j->first + i] = found[0].index;
}

static lt_status make_neighbours(set_job *j)
{
    const int64_t capacity = gaussians_capacity(&j->m->gaussians);
    lt_status st;

    for (int64_t i = 0; i < capacity; i++) {
        for (int k = 0; k < HOGS_NEIGHBOURS; k++)
            j->l->near[j->first + i][k] = -1;
        j->l->vertex[j->first + i] = -1;
    }
    st = lt_kd_tree_new((int)j->n, &j->centre[0][0], &j->tree);
    if (!st)
        lt_parallel_for(j->n, neighbours_of, j);
    lt_kd_tree_free(&j->tree);
    return st;
}

/* ---- an object's inside ---------------------------------------------------------------------------------- */

static void axes_of(const gaussians *g, int64_t row, lt_real out[9])
{
    double q[4], R[9];

    for (int k = 0; k < 4; k++)
        q[k] = (double)g->quaternion->data[4 * row + k];
    lt_rot_from_quat(q, R);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            out[3 * i + k] = (lt_real)(R[3 * i + k] * exp((double)g->log_scale->data[3 * row + k]));
}

/* Gaussians that the surface's points are; of a set without any, all of it */
static void fill_surface(int32_t surface[HOGS_SURFACE_POINTS], const int32_t *index, int64_t n, int64_t all)
{
    for (int64_t i = 0; i < HOGS_SURFACE_POINTS; i++)
        if (n > HOGS_SURFACE_POINTS)
            surface[i] = index[i * n / HOGS_SURFACE_POINTS];
        else
            surface[i] = n ? index[i % n] : (int32_t)(i % all);
}

static void box_of(const hogs *m, int object, double lo[3], double hi[3])
{
    const lt_real *box = m->box[1]->data + 6 * object;

    for (int k = 0; k < 3; k++) {
        lo[k] = (double)box[k] - 1 / (double)box[3 + k];
        hi[k] = (double)box[k] + 1 / (double)box[3 + k];
    }
}

static lt_status make_inside(set_job *j, int object)
{
    const gaussians *g = &j->m->gaussians;
    lt_real (*axes)[9] = lt_alloc((size_t)j->n * sizeof(*axes)), *opacity = lt_alloc((size_t)j->n * sizeof(*opacity));
    int32_t *index = lt_alloc((size_t)j->n * sizeof(*index));
    const occupancy_gaussians all = {
        .n = j->n, .centre = (const lt_real (*)[3])(g->centre->data + 3 * j->first),
        .axes = (const lt_real (*)[9])axes, .opacity = opacity,
    };
    double lo[3], hi[3];
    lt_status st = axes && opacity && index ? LT_OK : lt_error(LT_ENOMEM, "no memory to see what is in an object");

    for (int64_t i = 0; i < j->n && !st; i++) {
        axes_of(g, j->first + i, axes[i]);
        opacity[i] = (lt_real)(1 / (1 + exp(-(double)g->opacity->data[j->first + i])));
    }
    box_of(j->m, object, lo, hi);
    if (!st)
        st = occupancy_build(&all, lo, hi, &j->l->grid[object]);
    if (!st)
        fill_surface(j->l->surface[object], index, occupancy_surface(&j->l->grid[object], &all, index), j->n);
    lt_release(axes);
    lt_release(opacity);
    lt_release(index);
    return st;
}

static lt_status make_set(hogs_lists *l, const hogs *m, const hogs_rig *rig, int set)
{
    const gaussians *g = &m->gaussians;
    const bool object = set >= m->config.hands;
    set_job j = { .m = m, .l = l, .rig = object ? NULL : &rig[set], .first = gaussians_first(g, set),
                  .n = gaussians_count(g, set) };
    lt_status st;

    if (j.n < 1)
        return lt_error(LT_EINVAL, "%s %d has no Gaussians left", object ? "object" : "hand",
                        (int)m->id[object]->data[object ? set - m->config.hands : set]);
    j.centre = lt_alloc((size_t)j.n * sizeof(*j.centre));
    if (!j.centre)
        return lt_error(LT_ENOMEM, "no memory for the neighbours of %lld Gaussians", (long long)j.n);
    for (int64_t i = 0; i < 3 * j.n; i++)
        j.centre[i / 3][i % 3] = (double)g->centre->data[3 * j.first + i];
    st = make_neighbours(&j);
    if (!st && object)
        st = make_inside(&j, set - m->config.hands);
    lt_release(j.centre);
    return st;
}

lt_status hogs_lists_make(hogs_lists *l, const hogs *m, const hogs_rig *rig)
{
    lt_status st = room_for(l, m);

    for (int i = 0; i < hogs_n_sets(m) && !st; i++)
        st = make_set(l, m, rig, i);
    return st;
}

/* ---- in a checkpoint ------------------------------------------------------------------------------------- */

static int64_t length_of(const hogs_lists *l, int array)
{
    const int64_t n[ARRAYS] = {
        [NEAR] = l->rows * HOGS_NEIGHBOURS, [VERTEX] = l->rows, [SURFACE] = l->objects * HOGS_SURFACE_POINTS,
        [INSIDE] = l->objects * (WORDS + 6),
    };

    return n[array];
}

static int32_t *integers_of(const hogs_lists *l, int array)
{
    return array == NEAR ? &l->near[0][0] : array == VERTEX ? l->vertex : &l->surface[0][0];
}

static void pack_grid(const occupancy *g, lt_real *out)
{
    memcpy(out, g->lo, sizeof(g->lo));
    memcpy(out + 3, g->per_metre, sizeof(g->per_metre));
    for (int w = 0; w < WORDS; w++) {
        uint32_t bits = 0;

        for (int b = 0; b < BITS; b++)
            bits |= (uint32_t)(g->inside[w * BITS + b] != 0) << b;
        out[6 + w] = (lt_real)bits;
    }
}

static void unpack_grid(const float *from, occupancy *g)
{
    for (int k = 0; k < 3; k++) {
        g->lo[k] = (lt_real)from[k];
        g->per_metre[k] = (lt_real)from[3 + k];
    }
    for (int c = 0; c < OCCUPANCY_CELLS; c++) {
        const float word = from[6 + c / BITS];

        g->inside[c] = word >= 0 && word < 65536 && ((uint32_t)word >> c % BITS & 1);
    }
}

int hogs_lists_save(hogs_lists *l, lt_named_array *out, int room)
{
    for (int a = 0; a < ARRAYS; a++) {
        const int64_t n = length_of(l, a);

        if (!l->saved[a])
            l->saved[a] = lt_alloc((size_t)n * sizeof(lt_real));
        if (!l->saved[a] || a == room)
            return 0;
        for (int64_t i = 0; i < n && a != INSIDE; i++)
            l->saved[a][i] = (lt_real)integers_of(l, a)[i];
        for (int o = 0; o < l->objects && a == INSIDE; o++)
            pack_grid(&l->grid[o], l->saved[a] + (int64_t)o * (WORDS + 6));
        out[a] = (lt_named_array){ names[a], lt_array_make(LT_ELEM_F4, 1, &n, l->saved[a]) };
    }
    return ARRAYS;
}

/* Numbers of Gaussians or vertices: whatever is none becomes -1. */
static void take_integers(const float *from, int64_t n, int64_t below, int32_t *out)
{
    for (int64_t i = 0; i < n; i++)
        out[i] = from[i] >= 0 && from[i] < (float)below ? (int32_t)from[i] : -1;
}

static const float *find(const char *path, const lt_named_array *entry, size_t n, const char *name, int64_t want,
                         lt_status *st)
{
    for (size_t i = 0; i < n && !*st; i++)
        if (strcmp(entry[i].name, name) == 0 && entry[i].array.type == LT_ELEM_F4
            && (int64_t)lt_array_count(&entry[i].array) == want)
            return entry[i].array.data;
    if (!*st)
        *st = lt_error(LT_EINVAL, "%s: has no \"%s\" of %lld numbers: no checkpoint that training can go on from", path,
                       name, (long long)want);
    return NULL;
}

lt_status hogs_lists_load(hogs_lists *l, const hogs *m, const char *path, const lt_named_array *entry, size_t n)
{
    const int64_t below[ARRAYS] = {
        [NEAR] = gaussians_capacity(&m->gaussians), [VERTEX] = LT_HAND_VERTICES,
        [SURFACE] = gaussians_capacity(&m->gaussians),
    };
    lt_status st = room_for(l, m);

    for (int a = 0; a < ARRAYS && !st; a++) {
        const float *from = find(path, entry, n, names[a], length_of(l, a), &st);

        if (from && a != INSIDE)
            take_integers(from, length_of(l, a), below[a], integers_of(l, a));
        for (int o = 0; from && a == INSIDE && o < l->objects; o++)
            unpack_grid(from + (int64_t)o * (WORDS + 6), &l->grid[o]);
    }
    return st;
}
