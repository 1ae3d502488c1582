/* SPDX-License-Identifier: Apache-2.0 */
/* Triangle setup, tiles, and spans. */
#include "synth/render/raster.h"
#include "synth/render/small.h"

#include <string.h>

static const double NEAR = 0.01;                /* metres */
static const double SLACK = 1e-5;               /* barycentric: neighbours overlap rather than gape */

/* block is the address of a pointer of any type: copied as bytes, so that no alias rule is bent. */
bool raster_grow(void *block, size_t *capacity, size_t n, size_t size)
{
    size_t bytes;
    void *fresh, *old;

    if (n <= *capacity)
        return true;
    n += n / 2;
    if (!lt_size_mul(n, size, &bytes) || !(fresh = lt_alloc(bytes)))
        return false;
    memcpy(&old, block, sizeof(old));
    lt_release(old);
    memcpy(block, &fresh, sizeof(fresh));
    *capacity = n;
    return true;
}

void raster_list_fini(raster_list *l)
{
    lt_release(l->triangle);
    lt_release(l->tile_start);
    lt_release(l->tile_item);
    lt_release(l->corner);
}

/* Homogeneous sample coordinates (X, Y, z): the sample is (X / z, Y / z). */
static void project(const synth_instance *in, const raster_view *view, double (*out)[3])
{
    double M[9], m[3];

    for (int i = 0; i < 3; i++) {
        m[i] = view->t[i];
        for (int j = 0; j < 3; j++) {
            m[i] += view->R[3 * i + j] * in->t_world_obj[j];
            M[3 * i + j] = 0;
            for (int k = 0; k < 3; k++)
                M[3 * i + j] += view->R[3 * i + k] * in->R_world_obj[3 * k + j];
        }
    }
    for (int v = 0; v < in->mesh->n_vertices; v++) {
        const float *p = in->mesh->vertex[v];
        double x[3];

        for (int i = 0; i < 3; i++)
            x[i] = M[3 * i] * p[0] + M[3 * i + 1] * p[1] + M[3 * i + 2] * p[2] + m[i];
        out[v][0] = view->fx * x[0] + view->cx * x[2];
        out[v][1] = view->fy * x[1] + view->cy * x[2];
        out[v][2] = x[2];
    }
}

static void widen(double box[4], double x, double y)
{
    box[0] = fmin(box[0], x);
    box[1] = fmin(box[1], y);
    box[2] = fmax(box[2], x);
    box[3] = fmax(box[3], y);
}

/* The box of what lies in front of the near plane; false when that is nothing or not finite. */
static bool find_box(const double *const p[3], double box[4])
{
    box[0] = box[1] = INFINITY;
    box[2] = box[3] = -INFINITY;
    for (int i = 0; i < 3; i++) {
        const double *a = p[i], *b = p[(i + 1) % 3];

        if (!isfinite(a[0] + a[1] + a[2]))
            return false;
        if (a[2] >= NEAR)
            widen(box, a[0] / a[2], a[1] / a[2]);
        if ((a[2] >= NEAR) != (b[2] >= NEAR)) {
            const double s = (NEAR - a[2]) / (b[2] - a[2]);

            widen(box, (a[0] + s * (b[0] - a[0])) / NEAR, (a[1] + s * (b[1] - a[1])) / NEAR);
        }
    }
    return box[0] <= box[2];
}

/* Cuts the box to the grid; false when no sample is left. Clamped before the cast, so it never
 * overflows. */
static bool cut_box(raster_triangle *t, const double box[4], const raster_view *view)
{
    if (box[2] < 0 || box[3] < 0 || box[0] > view->width - 1 || box[1] > view->height - 1)
        return false;
    t->x0 = (int32_t)ceil(fmax(box[0] - SLACK, 0));
    t->y0 = (int32_t)ceil(fmax(box[1] - SLACK, 0));
    t->x1 = (int32_t)floor(fmin(box[2] + SLACK, view->width - 1));
    t->y1 = (int32_t)floor(fmin(box[3] + SLACK, view->height - 1));
    return t->x0 <= t->x1 && t->y0 <= t->y1;
}

/* The rows of the inverse of the matrix whose columns are the corners. The box's first sample becomes
 * the origin, so that single precision suffices later. False for a triangle without area. */
static bool find_edges(raster_triangle *t, const double *const p[3])
{
    double q[3][3], c[3][3], det, scale = 0;

    for (int i = 0; i < 3; i++) {
        q[i][0] = p[i][0] - t->x0 * p[i][2];
        q[i][1] = p[i][1] - t->y0 * p[i][2];
        q[i][2] = p[i][2];
    }
    for (int i = 0; i < 3; i++) {
        const double *a = q[(i + 1) % 3], *b = q[(i + 2) % 3];

        c[i][0] = a[1] * b[2] - a[2] * b[1];
        c[i][1] = a[2] * b[0] - a[0] * b[2];
        c[i][2] = a[0] * b[1] - a[1] * b[0];
        scale = fmax(scale, fabs(q[i][0] * c[i][0]) + fabs(q[i][1] * c[i][1]) +
                                fabs(q[i][2] * c[i][2]));
    }
    det = q[0][0] * c[0][0] + q[0][1] * c[0][1] + q[0][2] * c[0][2];
    if (!(fabs(det) > 1e-12 * scale))
        return false;
    t->back = det > 0;
    t->e[0] = t->e[1] = t->e[2] = v4_all(0);
    scale = 0;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            t->e[k][i] = (float)(c[i][k] / det);
            scale += fabs(c[i][k] / det);
        }
    return scale < 1e30;
}

static void add_instance(raster_list *l, const synth_scene *scene, int index,
                         const raster_view *view)
{
    const synth_instance *in = &scene->instance[index];

    project(in, view, l->corner);
    for (int f = 0; f < in->mesh->n_faces; f++) {
        const int32_t *v = in->mesh->face[f];
        const double *const p[3] = { l->corner[v[0]], l->corner[v[1]], l->corner[v[2]] };
        raster_triangle *t = &l->triangle[l->n];
        double box[4];

        t->instance = index;
        t->face = f;
        if (find_box(p, box) && cut_box(t, box, view) && find_edges(t, p))
            l->n++;
    }
}

/* Walks the tiles of every triangle: counts them first, then writes them down. */
static void walk_tiles(raster_list *l, uint32_t *counter, uint32_t *item)
{
    for (size_t i = 0; i < l->n; i++) {
        const raster_triangle *t = &l->triangle[i];

        for (int y = t->y0 / TILE; y <= t->y1 / TILE; y++)
            for (int x = t->x0 / TILE; x <= t->x1 / TILE; x++) {
                const uint32_t k = counter[y * l->tiles_x + x]++;

                if (item)
                    item[k] = (uint32_t)i;
            }
    }
}

static bool sort_into_tiles(raster_list *l, const raster_view *view)
{
    size_t tiles;
    uint32_t sum = 0;

    l->tiles_x = (int)lt_ceil_div(view->width, TILE);
    l->tiles_y = (int)lt_ceil_div(view->height, TILE);
    tiles = (size_t)l->tiles_x * (size_t)l->tiles_y;
    if (!raster_grow(&l->tile_start, &l->tiles_capacity, tiles + 1, sizeof(*l->tile_start)))
        return false;
    memset(l->tile_start, 0, (tiles + 1) * sizeof(*l->tile_start));
    walk_tiles(l, l->tile_start + 1, NULL);
    for (size_t i = 1; i <= tiles; i++) {       /* entry i + 1 counts on from where tile i starts */
        const uint32_t count = l->tile_start[i];

        l->tile_start[i] = sum;
        sum += count;
    }
    if (!raster_grow(&l->tile_item, &l->items_capacity, sum, sizeof(*l->tile_item)))
        return false;
    walk_tiles(l, l->tile_start + 1, l->tile_item);
    return true;
}

lt_status raster_collect(raster_list *l, const synth_scene *scene, const raster_view *view,
                         bool casters)
{
    size_t faces = 0, corners = 0;

    for (int i = 0; i < scene->n_instances; i++) {
        const lt_mesh *m = scene->instance[i].mesh;

        faces += (size_t)m->n_faces;
        corners = (size_t)lt_max_i64((int64_t)corners, m->n_vertices);
    }
    if (!raster_grow(&l->triangle, &l->capacity, faces + 1, sizeof(*l->triangle)) ||
        !raster_grow(&l->corner, &l->corners_capacity, corners, sizeof(*l->corner)))
        return lt_error(LT_ENOMEM, "render: no memory for %zu triangles", faces);
    l->n = 0;
    for (int i = 0; i < scene->n_instances; i++)
        if (!casters || !scene->instance[i].no_shadow)
            add_instance(l, scene, i, view);
    if (!sort_into_tiles(l, view))
        return lt_error(LT_ENOMEM, "render: no memory to sort %zu triangles", l->n);
    return LT_OK;
}

/* Narrows [*lo, *hi] to where c + a x is not below zero; per_a is 1 / a. */
static void narrow(float a, float per_a, float c, float *lo, float *hi)
{
    if (a > 0)
        *lo = most(*lo, -c * per_a);
    else if (a < 0)
        *hi = least(*hi, -c * per_a);
    else if (c < 0)
        *hi = -1;
}

static void fill(float *inv_z, uint32_t *id, int n, float w, float dw, uint32_t name)
{
    const float limit = (float)(1 / NEAR);

    for (int x = 0; x < n; x++) {
        const float v = w + dw * (float)x;

        if (v > inv_z[x] && v <= limit) {
            inv_z[x] = v;
            if (id)
                id[x] = name;
        }
    }
}

void raster_draw(const raster_triangle *t, int tx, int ty, uint32_t name, float *inv_z, uint32_t *id)
{
    const int left = tx * TILE, top = ty * TILE;
    const int right = left + TILE - 1, below = top + TILE - 1;
    const int x0 = t->x0 > left ? t->x0 : left, x1 = t->x1 < right ? t->x1 : right;
    const int y0 = t->y0 > top ? t->y0 : top, y1 = t->y1 < below ? t->y1 : below;
    const float dw = v4_sum3(t->e[0]), slack = (float)SLACK;
    const v4 per = v4_all(1) / t->e[0];

    for (int y = y0; y <= y1; y++) {
        const float dy = (float)(y - t->y0);
        float lo = (float)(x0 - t->x0), hi = (float)(x1 - t->x0);
        const v4 c = t->e[1] * v4_all(dy) + t->e[2];
        const float w = v4_sum3(c), more = slack * fabsf(w);

        for (int i = 0; i < 3; i++)
            narrow(t->e[0][i], per[i], c[i] + more, &lo, &hi);
        if (!(lo <= hi))
            continue;
        const int first = (int)ceilf(lo), last = (int)floorf(hi);
        const int at = (y - top) * TILE + t->x0 + first - left;

        if (first <= last)
            fill(inv_z + at, id ? id + at : NULL, last - first + 1, w + dw * (float)first, dw,
                 name);
    }
}
