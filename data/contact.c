/* SPDX-License-Identifier: Apache-2.0 */
#include "data/contact.h"

#include "data/hand_pose.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mesh/surface.h"

#include <math.h>

typedef struct {
    const dataset *d;
    const lt_hand_model *hand;
    int64_t first;
    double metres;
    lt_mesh_index **mesh;           /* of each object */
    bool *close;                    /* of each sample */
    lt_status *status;
} contact_job;

/* x_model = A^T (x_cam - t): A is orthogonal, a mirror or not. */
static void to_model(const float A[9], const float t[3], const double p[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = A[i] * (p[0] - t[0]) + A[3 + i] * (p[1] - t[1]) + A[6 + i] * (p[2] - t[2]);
}

static bool touches(const contact_job *j, const dataset_sample *s)
{
    const unsigned want = SAMPLE_HAND_POSE | SAMPLE_ROOT | SAMPLE_OBJECT;
    double vertices[LT_HAND_VERTICES][3], p[3];
    float A[9];

    if ((s->flags & want) != want || s->object < 0)
        return false;
    hand_pose_at(j->hand, s->rotation[0], s->beta, s->root, vertices);
    dataset_model_to_camera(s, A);
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        to_model(A, s->t, vertices[v], p);
        if (lt_mesh_closest(j->mesh[s->object], p).distance <= j->metres)
            return true;
    }
    return false;
}

static void look(void *ctx, int64_t i)
{
    const contact_job *j = ctx;
    lt_arena *arena = lt_arena_new();
    dataset_sample s;

    j->status[i] = arena ? dataset_annotation(j->d, j->first + i, arena, &s) : LT_ENOMEM;
    if (j->status[i] == LT_OK)
        j->close[i] = touches(j, &s);
    lt_arena_free(arena);
}

static lt_status index_objects(contact_job *j, lt_arena *arena)
{
    lt_status st = LT_OK;

    for (int i = 0; i < j->d->n_objects && st == LT_OK; i++)
        st = lt_mesh_index_new(arena, &j->d->objects[i].mesh, &j->mesh[i]);
    return st;
}

/* An error again, on this thread, whose line is ours. */
static lt_status first_error(const contact_job *j, int64_t n, lt_arena *arena)
{
    dataset_sample s;

    for (int64_t i = 0; i < n; i++)
        if (j->status[i])
            return dataset_annotation(j->d, j->first + i, arena, &s) ? j->status[i] : lt_error(LT_ENOMEM, "no memory");
    return LT_OK;
}

lt_status contact_select(const dataset *d, const lt_hand_model *hand, int64_t first, int64_t n, double metres,
                         lt_arena *arena, const int64_t **index, int64_t *n_out)
{
    const size_t samples = (size_t)n;
    contact_job j = { d, hand, first, metres, lt_arena_array(arena, (size_t)d->n_objects, sizeof(*j.mesh)),
                      lt_arena_array(arena, samples, sizeof(*j.close)),
                      lt_arena_array(arena, samples, sizeof(*j.status)) };
    int64_t *kept = lt_arena_array(arena, samples, sizeof(*kept)), count = 0;
    lt_status st;

    if (!j.mesh || !j.close || !j.status || !kept)
        return lt_error(LT_ENOMEM, "no memory to look for contact in %lld samples", (long long)n);
    st = index_objects(&j, arena);
    if (st)
        return st;
    lt_parallel_for(n, look, &j);
    st = first_error(&j, n, arena);
    for (int64_t i = 0; i < n && st == LT_OK; i++)
        if (j.close[i])
            kept[count++] = first + i;
    *index = kept;
    *n_out = count;
    return st;
}
