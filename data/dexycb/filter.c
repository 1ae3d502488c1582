/* SPDX-License-Identifier: Apache-2.0 */
/* Which samples of a split are used: the rules of the papers, from the labels alone. */
#include "data/dexycb/internal.h"

#include "data/hand_pose.h"
#include "libtensor/base/parallel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double CONTACT = 0.005;            /* metres between two vertices */
enum { EVERY = 5 };                             /* frames: from 30 a second to 6 */

const char *const dexycb_filters[] = { "valid", "every", "hfl-net", "hoisdf", NULL };

lt_status dexycb_parse_filter(const char *name, dexycb_filter *out)
{
    for (int i = 0; dexycb_filters[i]; i++)
        if (!strcmp(name, dexycb_filters[i])) {
            *out = (dexycb_filter)i;
            return LT_OK;
        }
    return lt_error(LT_EINVAL, "no filter \"%s\": valid, every, hfl-net or hoisdf", name);
}

bool dexycb_box_is_empty(const dexycb_label *l)
{
    static const double size[2] = { DEXYCB_WIDTH, DEXYCB_HEIGHT };

    for (int k = 0; k < 2; k++) {
        double lo = INFINITY, hi = -INFINITY, middle, half;
        for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
            lo = fmin(lo, l->joints2d[i][k]);
            hi = fmax(hi, l->joints2d[i][k]);
        }
        middle = (lo + hi) / 2;
        half = 1.5 * (hi - lo) / 2;
        if (!(fmin(size[k], middle + half) > fmax(0, middle - half)))
            return true;
    }
    return false;
}

/* ---- contact ---- */

static bool near_any(const float p[3], const double (*v)[3], int n)
{
    for (int i = 0; i < n; i++) {
        const double x = p[0] - v[i][0], y = p[1] - v[i][1], z = p[2] - v[i][2];
        if (x * x + y * y + z * z <= CONTACT * CONTACT)
            return true;
    }
    return false;
}

static void extent(const double (*v)[3], int n, double lo[3], double hi[3])
{
    for (int k = 0; k < 3; k++) {
        lo[k] = INFINITY;
        hi[k] = -INFINITY;
        for (int i = 0; i < n; i++) {
            lo[k] = fmin(lo[k], v[i][k] - CONTACT);
            hi[k] = fmax(hi[k], v[i][k] + CONTACT);
        }
    }
}

/* Whether a vertex of the hand is within 5 mm of one of the object's. */
static bool touches(const dexycb *d, const lt_hand_model *hand, dexycb_spot spot, const dexycb_label *l)
{
    const dataset_object *o = NULL;
    const float *R = l->object.R;
    dataset_sample s = { 0 };
    double v[LT_HAND_VERTICES][3], lo[3], hi[3];

    for (int i = 0; i < d->base.n_objects; i++)
        if (d->base.objects[i].ycb_id == spot.sequence->object[spot.sequence->grasped])
            o = &d->base.objects[i];
    if (!o || !l->object.known)
        return false;
    dexycb_fill_hand(d, spot, l, &s);
    hand_pose_at(hand, s.rotation[0], s.beta, s.root, v);
    extent((const double (*)[3])v, LT_HAND_VERTICES, lo, hi);
    for (int i = 0; i < o->mesh.n_vertices; i++) {
        const float *x = o->mesh.vertex[i];
        bool inside = true;
        float p[3];
        for (int k = 0; k < 3; k++) {
            p[k] = R[3 * k] * x[0] + R[3 * k + 1] * x[1] + R[3 * k + 2] * x[2] + l->object.t[k];
            inside = inside && p[k] >= lo[k] && p[k] <= hi[k];
        }
        if (inside && near_any(p, (const double (*)[3])v, LT_HAND_VERTICES))
            return true;
    }
    return false;
}

/* ---- the list ---- */

typedef struct {
    const dexycb *d;
    const lt_hand_model *hand;
    uint8_t *keep;                  /* of each sample of the whole list */
} job;

static bool wanted(const job *j, dexycb_spot spot, const dexycb_label *l)
{
    if (!l->hand)
        return false;
    switch (j->d->filter) {
    case DEXYCB_HFL: return j->d->split.part != DEXYCB_TRAIN || !dexycb_box_is_empty(l);
    case DEXYCB_HOISDF: return touches(j->d, j->hand, spot, l);
    default: return true;
    }
}

/* Not worth reading the label for. */
static bool ruled_out(const job *j, dexycb_spot spot)
{
    return j->d->filter == DEXYCB_HOISDF && (spot.sequence->left || spot.frame % EVERY);
}

/* All samples of a sequence. What cannot be read is kept: reading the sample will say why. */
static void filter_sequence(void *ctx, int64_t i)
{
    const job *j = ctx;
    const dexycb_sequence *q = &j->d->sequence[i];
    const int64_t n = (int64_t)q->frames * j->d->n_cameras;

    for (int64_t k = 0; k < n; k++) {
        const dexycb_spot spot = dexycb_find(j->d, q->first + k);
        dexycb_label label;
        if (!ruled_out(j, spot))
            j->keep[q->first + k] = dexycb_read_label(j->d, spot, &label) || wanted(j, spot, &label);
    }
}

lt_status dexycb_apply_filter(dexycb *d, const lt_hand_model *hand)
{
    job j = { d, hand, NULL };

    d->base.count = d->total;
    if (d->filter == DEXYCB_EVERY)
        return LT_OK;
    j.keep = calloc((size_t)d->total, 1);
    d->kept = lt_arena_array(d->arena, (size_t)d->total, sizeof(*d->kept));
    if (!j.keep || !d->kept) {
        free(j.keep);
        return lt_error(LT_ENOMEM, "%s: no memory for %lld samples", d->base.root, (long long)d->total);
    }
    lt_parallel_for(d->n_sequences, filter_sequence, &j);
    d->base.count = 0;
    for (int64_t i = 0; i < d->total; i++)
        if (j.keep[i])
            d->kept[d->base.count++] = (uint32_t)i;
    free(j.keep);
    return d->base.count ? LT_OK : lt_error(LT_EINVAL, "%s: none of the %lld samples of split %s of s%d passes the "
                                            "filter", d->base.root, (long long)d->total, dexycb_split_name(d->split),
                                            d->split.setup);
}
