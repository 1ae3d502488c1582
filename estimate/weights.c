/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/weights.h"

#include "estimate/checkpoint.h"
#include "estimate/checkpoint_folder.h"
#include "estimate/param_arrays.h"
#include "estimate/weight_names.h"
#include "libtensor/io/file.h"
#include "libtensor/io/torch/weights_file.h"

#include <math.h>
#include <string.h>

enum { SHOWN = 8 };

/* Each array of the file beside the parameter that it is for, if any. */
typedef struct {
    lt_arena *arena;
    const model *m;
    lt_weights_file file;
    lt_param **param, **twin;       /* file.n of them; twin: what takes the same weight besides */
    const lt_array **average;       /* of the weight, which a run of ours may have kept and is taken instead; or NULL */
    const char *block;              /* of the model, whose parameters the file's names are; or NULL */
    weights_report report;
} match;

static lt_param *param_in(const match *a, const char *block, const char *name)
{
    const char *full = lt_arena_printf(a->arena, "%s.%s", block, name);

    return full ? lt_params_find(a->m->params, full) : NULL;
}

static lt_param *param_named(const match *a, const char *name)
{
    lt_param *p = lt_params_find(a->m->params, name);

    return p || !a->block ? p : param_in(a, a->block, name);
}

/* What every file of its kind has besides, and no network needs. */
static bool passed_over(const char *name)
{
    return lt_ends_with(name, ".num_batches_tracked") || strncmp(name, "optim.", 6) == 0;
}

static lt_status check_array(const match *a, const lt_named_array *e, const lt_param *p)
{
    const lt_status st = array_check(a->file.path, e->name, &e->array, p->name, &p->shape);

    for (size_t i = 0; !st && i < lt_array_count(&e->array); i++)
        if (!isfinite(lt_array_get(&e->array, i)))
            return lt_error(LT_EFORMAT, "%s: \"%s\" is not finite at %zu", a->file.path, e->name, i);
    return st;
}

static bool is_taken(const match *a, const lt_param *p, size_t before)
{
    for (size_t i = 0; i < before; i++)
        if (a->param[i] == p || a->twin[i] == p)
            return true;
    return false;
}

/* Whether p is the first layer's of a network that looks at one channel, the array one's that looks at several. */
static bool is_summed(const lt_array *from, const lt_param *p)
{
    const int64_t *d = p->shape.dim, whole[4] = { d[0], from->rank == 4 ? from->shape[1] : 0, d[2], d[3] };

    return p->shape.rank == 4 && d[1] == 1 && whole[1] > 1 && lt_array_has_shape(from, 4, whole);
}

/* Published weights are for one network, of which the model may have two. */
static lt_status match_twin(match *a, const lt_named_array *e, const char *name, size_t i)
{
    const char *const *twins = a->m->cls->twins;
    lt_param *p;

    if (!twins || !a->block || strcmp(a->block, twins[0]) != 0 || a->param[i] != param_in(a, twins[0], name))
        return LT_OK;
    p = param_in(a, twins[1], name);
    if (!p)
        return LT_OK;
    a->twin[i] = p;
    a->report.n_loaded++;
    return is_summed(&e->array, p) ? LT_OK : check_array(a, e, p);
}

/* The block that most of the names are of: a file is of one network, and two of ours may share a name. */
static void choose_block(match *a, const weight_family *f)
{
    int most = 0;

    for (int b = 0; a->m->cls->blocks[b]; b++) {
        char name[WEIGHT_NAME];
        int n = 0;

        for (size_t i = 0; i < a->file.n; i++)
            n += !passed_over(a->file.entry[i].name) && weight_name(f, a->file.entry[i].name, name) &&
                 param_in(a, a->m->cls->blocks[b], name);
        if (n > most) {
            most = n;
            a->block = a->m->cls->blocks[b];
        }
    }
}

static lt_status find_average(match *a, const lt_named_array *e, const lt_param *p, size_t i)
{
    const lt_named_array *average = checkpoint_average(a->file.entry, a->file.n, e->name);

    if (!average)
        return LT_OK;
    a->average[i] = &average->array;
    return check_array(a, average, p);
}

static lt_status match_one(match *a, const weight_family *f, size_t i)
{
    const lt_named_array *e = &a->file.entry[i];
    char name[WEIGHT_NAME];
    lt_param *p;
    lt_status st;

    if (passed_over(e->name))
        return LT_OK;
    p = weight_name(f, e->name, name) ? param_named(a, name) : NULL;
    if (!p) {
        a->report.left_over[a->report.n_left_over++] = e->name;
        return LT_OK;
    }
    if (is_taken(a, p, i))
        return lt_error(LT_EFORMAT, "%s: \"%s\" is the second array for \"%s\"", a->file.path, e->name, p->name);
    a->param[i] = p;
    a->report.n_loaded++;
    st = check_array(a, e, p);
    st = st ? st : match_twin(a, e, name, i);
    return st ? st : find_average(a, e, p, i);
}

static lt_status match_all(match *a)
{
    const weight_family *f = weight_family_of(a->file.entry, a->file.n);
    lt_status st = LT_OK;

    a->report.format = a->file.format;
    a->report.family = f->name;
    a->report.note = f->note;
    a->param = lt_arena_array(a->arena, a->file.n, sizeof(*a->param));
    a->twin = lt_arena_array(a->arena, a->file.n, sizeof(*a->twin));
    a->average = lt_arena_array(a->arena, a->file.n, sizeof(lt_array *));
    a->report.left_over = lt_arena_array(a->arena, a->file.n, sizeof(char *));
    if (!a->param || !a->twin || !a->average || !a->report.left_over)
        return lt_error(LT_ENOMEM, "%s: no memory", a->file.path);
    choose_block(a, f);
    for (size_t i = 0; !st && i < a->file.n; i++)
        st = match_one(a, f, i);
    if (!st && !a->report.n_loaded)
        st = lt_error(LT_EINVAL, "%s: none of its %zu arrays has the name of a parameter of %s", a->file.path,
                      a->file.n, a->m->cls->name);
    return st;
}

static lt_status list_missing(match *a)
{
    int n = 0;

    for (const lt_param *p = lt_params_first(a->m->params); p; p = p->next)
        n++;
    a->report.missing = lt_arena_array(a->arena, (size_t)n, sizeof(char *));
    if (!a->report.missing)
        return lt_error(LT_ENOMEM, "%s: no memory", a->file.path);
    for (const lt_param *p = lt_params_first(a->m->params); p; p = p->next)
        if (!is_taken(a, p, a->file.n))
            a->report.missing[a->report.n_missing++] = p->name;
    return LT_OK;
}

/* The weights of all channels that were, summed for the one that is */
static void load_summed(lt_param *p, const lt_array *from)
{
    const int64_t window = p->shape.dim[2] * p->shape.dim[3], channels = from->shape[1];

    for (int64_t k = 0; k < lt_param_numel(p); k++) {
        double sum = 0;

        for (int64_t c = 0; c < channels; c++)
            sum += lt_array_get(from, (size_t)((k / window * channels + c) * window + k % window));
        p->data[k] = (lt_real)sum;
    }
}

static void load_one(const match *a, size_t i)
{
    const lt_array *from = a->average[i] ? a->average[i] : &a->file.entry[i].array;

    array_load(from, a->param[i]->data);
    if (a->twin[i] && is_summed(from, a->twin[i]))
        load_summed(a->twin[i], from);
    else if (a->twin[i])
        array_load(from, a->twin[i]->data);
}

lt_status weights_init(lt_arena *arena, const char *path, const model *m, weights_report *out)
{
    match a = { .arena = arena, .m = m };
    const char *file = checkpoint_last(arena, path);
    lt_status st = file ? lt_weights_read(arena, file, &a.file) : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (!st)
        st = match_all(&a);
    if (!st)
        st = list_missing(&a);
    if (st)
        return st;
    for (size_t i = 0; i < a.file.n; i++)
        if (a.param[i])
            load_one(&a, i);
    lt_params_changed(m->params);
    *out = a.report;
    return LT_OK;
}

const char *weights_list(lt_arena *arena, const char *const *name, int n)
{
    const char *line = n ? name[0] : "none";

    for (int i = 1; line && i < n && i < SHOWN; i++)
        line = lt_arena_printf(arena, "%s, %s", line, name[i]);
    if (line && n > SHOWN)
        line = lt_arena_printf(arena, "%s and %d more", line, n - SHOWN);
    return line ? line : "";
}
