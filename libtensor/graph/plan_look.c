/* SPDX-License-Identifier: Apache-2.0 */
/* What a plan holds, and what its steps are and take. Where the batch has parts, all of them count. */
#include "libtensor/graph/plan_internal.h"

lt_plan *lt_plan_part(const lt_plan *p, int i)
{
    return p->part[i];
}

/* NULL for one of another graph, or recorded later */
static const lt_tensor *ours_of(const lt_plan *p, const lt_tensor *t)
{
    return t->graph == p->recorded && t->id >= 0 && t->id < p->n_of ? p->of[t->id] : NULL;
}

void *lt_plan_data(const lt_plan *p, const lt_tensor *t)
{
    const lt_tensor *ours = ours_of(p, t);

    if (!ours)
        return NULL;
    if (ours->kind == LT_RESULT && !ours->is_output && !(ours->node && p->node[ours->node->id].constant))
        return NULL;
    return ours->data;
}

lt_real *lt_plan_grad(const lt_plan *p, const lt_tensor *t)
{
    const lt_tensor *ours = ours_of(p, t);

    return ours && ours->wants_grad && p->tensor[ours->id].grad >= 0 ? plan_grad(p, ours) : NULL;
}

void lt_plan_set_step(lt_plan *p, uint64_t seed, uint64_t step)
{
    for (int k = 0; k < p->n_parts; k++) {
        lt_plan *part = p->part[k];

        part->seed = seed;
        part->run = step * (uint64_t)p->n_parts + (uint64_t)k;
    }
}

void lt_plan_set_loss_weight(lt_plan *p, double weight)
{
    p->loss_weight = weight;
}

size_t lt_plan_bytes(const lt_plan *p)
{
    size_t bytes = 0;

    for (int k = 0; k < p->n_parts; k++)
        bytes += p->part[k]->memory_bytes + p->part[k]->fixed_bytes;
    return bytes;
}

static int64_t forward_macs(const plan_step *s)
{
    return s->node && s->node->op->macs ? s->node->op->macs(&s->call) : 0;
}

int64_t lt_plan_macs(const lt_plan *p)
{
    int64_t macs = 0;

    for (int i = 0; i < p->n_forward; i++)
        macs += forward_macs(&p->step[i]);
    return macs * p->n_parts;
}

void lt_plan_profile(lt_plan *p, bool on)
{
    for (int k = 0; k < p->n_parts; k++) {
        lt_plan *part = p->part[k];

        part->profile = on;
        for (int i = 0; i < part->n_steps; i++)
            part->step[i].seconds = 0;
    }
}

int lt_plan_steps(const lt_plan *p)
{
    return p->n_steps;
}

/* A product has two gradients to make, each as long as the product; one when only one is wanted. */
static int64_t step_macs(const plan_step *s)
{
    int wanted = 0;

    if (s->kind != STEP_BACKWARD)
        return forward_macs(s);
    for (int i = 0; i < s->call.n_in && i < 2; i++)
        wanted += s->call.din[i] != NULL;
    return wanted * forward_macs(s);
}

lt_step_info lt_plan_step(const lt_plan *p, int i)
{
    static const char *const phase[] = { "forward", "recompute", "zero", "backward" };
    const plan_step *s = &p->step[i];
    lt_step_info info = { .op = "zero", .layer = "", .algorithm = "", .phase = phase[s->kind] };

    for (int k = 0; k < p->n_parts; k++)
        info.seconds += p->part[k]->step[i].seconds;
    if (p->n_parts > 1 && plan_parts_abreast(p))
        info.seconds /= p->n_parts;

    if (s->node) {
        info.op = s->node->op->name;
        info.layer = s->node->name;
        info.shape = s->node->outs[0]->shape;
        info.macs = p->n_parts * step_macs(s);
        if (s->kind == STEP_FORWARD && s->node->op->algorithm)
            info.algorithm = s->node->op->algorithm(&s->call);
    }
    return info;
}
