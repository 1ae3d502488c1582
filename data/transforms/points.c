/* SPDX-License-Identifier: Apache-2.0 */
/* Points, and whether they lie in the cameras' world or in the one before applied_transform. */
#include "data/transforms/internal.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/io/file.h"
#include "libtensor/io/mesh/ply.h"

#include <math.h>
#include <string.h>

enum { CAMERAS = 8 };

/* applied_transform and applied_scale: x' = scale (A x + t); false: the file has none */
static bool applied(const cJSON *file, double A[9], double t[3], double *scale)
{
    const cJSON *rows = cJSON_GetObjectItemCaseSensitive(file, "applied_transform");
    const cJSON *s = cJSON_GetObjectItemCaseSensitive(file, "applied_scale");

    *scale = cJSON_IsNumber(s) ? s->valuedouble : 1;
    if (cJSON_GetArraySize(rows) < 3)
        return false;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 4; k++) {
            const cJSON *x = cJSON_GetArrayItem(cJSON_GetArrayItem(rows, i), k);

            if (!cJSON_IsNumber(x) || !isfinite(x->valuedouble))
                return false;
            if (k < 3)
                A[3 * i + k] = x->valuedouble;
            else
                t[i] = x->valuedouble;
        }
    return true;
}

static void move(const double A[9], const double t[3], double scale, const float x[3], float out[3])
{
    const double from[3] = { (double)x[0], (double)x[1], (double)x[2] };
    double to[3];

    lt_mat3_mulvec(A, from, to);
    for (int k = 0; k < 3; k++)
        out[k] = (float)(scale * (to[k] + t[k]));
}

/* Whether a point is in the field of view, of which the file may only tell the angle */
static bool sees(const transforms_view *v, const float x[3])
{
    const transforms_lens *l = &v->lens;
    const double world[3] = { (double)x[0], (double)x[1], (double)x[2] };
    const double wide = l->fl_x > 0 && l->w > 0 ? 0.5 * l->w / l->fl_x : l->angle_x > 0 ? tan(0.5 * l->angle_x) : 1;
    double c[3];

    lt_mat3_mulvec(v->R_cam_world, world, c);
    for (int k = 0; k < 3; k++)
        c[k] += v->t_cam_world[k];
    return c[2] > 0 && fabs(c[0]) < wide * c[2] && fabs(c[1]) < wide * c[2];
}

static int64_t seen(const transforms_set *s, const float (*x)[3])
{
    const int cameras = s->n < CAMERAS ? s->n : CAMERAS;
    int64_t sum = 0;

    for (int c = 0; c < cameras; c++)
        for (int i = 0; i < s->n_points; i++)
            sum += sees(&s->view[(int64_t)c * s->n / cameras], x[i]);
    return sum;
}

/* Older files hold points as they were before: of both forms, the one of which cameras see more. */
static lt_status settle(lt_arena *arena, const cJSON *file, transforms_set *s)
{
    double A[9], t[3], scale;
    float (*moved)[3];

    if (!applied(file, A, t, &scale))
        return LT_OK;
    moved = lt_arena_array(arena, (size_t)s->n_points, sizeof(*moved));
    if (!moved)
        return lt_error(LT_ENOMEM, "%s: no memory for %d points", s->path, s->n_points);
    for (int i = 0; i < s->n_points; i++)
        move(A, t, scale, s->point[i], moved[i]);
    if (seen(s, (const float (*)[3])moved) > seen(s, (const float (*)[3])s->point))
        s->point = moved;
    return LT_OK;
}

lt_status transforms_points(lt_arena *arena, const char *folder, const cJSON *file, transforms_set *s)
{
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(file, "ply_file_path");
    const char *path;
    lt_mesh mesh;
    lt_ply ply;
    lt_status st;

    if (!name)
        return LT_OK;
    if (!cJSON_IsString(name) || !lt_path_is_inside(name->valuestring))
        return lt_error(LT_EFORMAT, "%s: ply_file_path: no file inside the folder", s->path);
    path = lt_path_join(arena, folder, name->valuestring);
    st = path ? lt_ply_read(arena, path, &ply) : lt_error(LT_ENOMEM, "%s: no memory", s->path);
    if (!st)
        st = lt_ply_mesh(arena, &ply, &mesh);
    if (st)
        return st;
    s->n_points = mesh.n_vertices;
    s->point = mesh.vertex;
    s->colour = mesh.color;
    return settle(arena, file, s);
}
