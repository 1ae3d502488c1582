/* SPDX-License-Identifier: Apache-2.0 */
/* The stages put together. */
#include "synth/grasp/internal.h"

#include "assets/ycb/objects.h"

#include <math.h>

enum { TRIES = 64 };

static void measure_object(synth_grasp_ctx *c, const lt_mesh *m)
{
    const ycb_object *o = synth_object_find(c->object_id);

    c->lowest = INFINITY;
    for (int i = 0; i < m->n_vertices; i++)
        c->lowest = fmin(c->lowest, m->vertex[i][2]);
    for (int k = 0; k < 3; k++)
        c->centre[k] = o->centre[k];
    c->radius = o->diameter / 2;
}

lt_status synth_grasp_ctx_new(lt_arena *arena, int id, const lt_mesh *object, const synth_sdf *sdf,
                              const lt_hand_model *hand, const double *beta, synth_grasp_ctx **out)
{
    synth_grasp_ctx *c = lt_arena_alloc(arena, sizeof(*c));
    lt_arena *scratch = lt_arena_new();
    lt_status st;

    if (!c || !scratch) {
        st = lt_error(LT_ENOMEM, "no memory for grasping");
        goto done;
    }
    if (hand->left) {
        st = lt_error(LT_EINVAL, "grasping wants a right hand; mirror the scene for a left one");
        goto done;
    }
    c->object_id = id;
    st = grasp_grips(scratch, id, c->grips, &c->n_grips);
    if (!st && sdf)
        c->sdf = *sdf;
    else if (!st)
        st = synth_sdf_new(arena, object, &c->sdf);
    if (st)
        goto done;
    measure_object(c, object);
    grasp_hand_init(&c->hand, hand, beta);
    *out = c;
done:
    lt_arena_free(scratch);
    return st;
}

void synth_grasp_ctx_mirror(synth_grasp_ctx *ctx)
{
    ctx->centre[0] = -ctx->centre[0];
    for (int i = 0; i < ctx->n_grips; i++) {
        grip *g = &ctx->grips[i];
        g->centre[0] = -g->centre[0];
        g->pivot[0] = -g->pivot[0];
        for (int k = 0; k < 3; k++)
            g->axis[k][0] = -g->axis[k][0];
    }
}

static void count(synth_grasp_stats *s, grasp_verdict v)
{
    s->tried++;
    s->accepted += v == HOLDS;
    s->no_contact += v == NO_CONTACT;
    s->too_deep += v == TOO_DEEP;
    s->no_balance += v == NO_BALANCE;
    s->crossed += v == CROSSED;
}

static void add_stats(synth_grasp_stats *to, const synth_grasp_stats *s)
{
    to->tried += s->tried;
    to->accepted += s->accepted;
    to->no_contact += s->no_contact;
    to->too_deep += s->too_deep;
    to->no_balance += s->no_balance;
    to->crossed += s->crossed;
}

static lt_status none_holds(const synth_grasp_ctx *c, const synth_grasp_stats *s)
{
    return lt_error(LT_ENUMERIC, "grasp of %s: none of %d candidates holds (%d do not touch, %d too deep, "
                    "%d do not balance, %d have crossed fingers)", synth_object_find(c->object_id)->name, (int)s->tried,
                    (int)s->no_contact, (int)s->too_deep, (int)s->no_balance, (int)s->crossed);
}

lt_status synth_grasp_sample(const synth_grasp_ctx *ctx, uint64_t seed, synth_grasp_stats *stats,
                             synth_grasp *out)
{
    synth_grasp_stats s = { 0 };
    synth_grasp g;
    const char *kind;

    for (uint64_t i = 0; i < TRIES && !s.accepted; i++) {
        lt_rng rng = lt_rng_make(seed, lt_rng_mix((uint64_t)ctx->object_id, i));
        hand_state state;
        grasp_wish wish;
        if (!grasp_place(ctx, &rng, &state, &wish, &kind)) {
            count(&s, NO_CONTACT);
            continue;
        }
        grasp_refine(ctx, &wish, &state);
        count(&s, grasp_judge(ctx, &state, &g));
    }
    if (stats)
        add_stats(stats, &s);
    if (!s.accepted)
        return none_holds(ctx, &s);
    g.kind = kind;
    *out = g;
    return LT_OK;
}
