/* SPDX-License-Identifier: Apache-2.0 */
/* What an optimiser remembers, as a list; and its average, put in the place of the weights. */
#include "libtensor/base/parallel.h"
#include "libtensor/optim/internal.h"

static bool add(lt_optim *o, const char *what, const char *name, lt_real *const *data, const lt_param *of, bool a_row)
{
    const char *text = lt_arena_printf(o->arena, "optim.%s.%s", what, name);

    o->entry[o->n_entries++] = (optim_entry){ text, data, of, a_row };
    return text;
}

static bool add_slot(lt_optim *o, const optim_slot *s)
{
    const char *name = s->p->name;

    return add(o, "m", name, &s->m.data, s->p, false) && (!s->v.data || add(o, "v", name, &s->v.data, s->p, false))
        && (!s->ema.data || add(o, "ema", name, &s->ema.data, s->p, false))
        && (!s->clock.data || add(o, "t", name, &s->clock.data, s->p, true));
}

/* The clock of the one recipe is lt_optim_steps. */
static bool add_clocks(lt_optim *o)
{
    lt_real **clock = o->one_recipe ? NULL : lt_arena_array(o->arena, (size_t)o->n_groups, sizeof(*clock));

    for (int k = 0; clock && k < o->n_groups; k++) {
        clock[k] = &o->group[k].clock;
        if (!add(o, "steps", o->group[k].recipe.name, &clock[k], NULL, false))
            return false;
    }
    return clock || o->one_recipe;
}

bool optim_list(lt_optim *o)
{
    o->entry = lt_arena_array(o->arena, (size_t)(4 * o->n_slots + o->n_statistics + o->n_groups), sizeof(*o->entry));
    if (!o->entry)
        return false;
    for (int i = 0; i < o->n_slots; i++)
        if (!add_slot(o, &o->slot[i]))
            return false;
    for (int i = 0; i < o->n_statistics; i++)
        if (!add(o, "ema", o->statistic[i].p->name, &o->statistic[i].ema, o->statistic[i].p, false))
            return false;
    return add_clocks(o);
}

int lt_optim_state_count(const lt_optim *o)
{
    return o->n_entries;
}

lt_optim_state lt_optim_state_at(const lt_optim *o, int i)
{
    const optim_entry *e = &o->entry[i];
    const lt_shape number = LT_SHAPE(1);

    return (lt_optim_state){
        e->name, *e->data, !e->of ? number : e->a_row ? LT_SHAPE(e->of->shape.dim[0]) : e->of->shape,
    };
}

int64_t lt_optim_steps(const lt_optim *o)
{
    return o->steps;
}

void lt_optim_set_steps(lt_optim *o, int64_t steps)
{
    o->steps = steps;
    if (o->one_recipe)
        o->group[0].clock = (lt_real)steps;
}

static void swap(const lt_param *p, lt_real *ema)
{
    for (int64_t k = 0; ema && k < lt_param_numel(p); k++) {
        const lt_real w = p->data[k];

        p->data[k] = ema[k];
        ema[k] = w;
    }
}

static void swap_one(void *ctx, int64_t i)
{
    const lt_optim *o = ctx;

    if (i < o->n_slots)
        swap(o->slot[i].p, o->slot[i].ema.data);
    else
        swap(o->statistic[i - o->n_slots].p, o->statistic[i - o->n_slots].ema);
}

void lt_optim_swap_ema(lt_optim *o)
{
    lt_parallel_for(o->n_slots + o->n_statistics, swap_one, o);
    lt_params_changed(o->set);
}
