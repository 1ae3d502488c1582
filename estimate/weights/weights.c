/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/weights/weights.h"

#include "estimate/checkpoint/checkpoint.h"
#include "estimate/checkpoint/folder.h"
#include "estimate/param_arrays.h"
#include "estimate/weights/split.h"
#include "libtensor/io/file.h"
#include "libtensor/io/torch/weights_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SHOWN = 8 };

/* Each array of the file beside the parameter that it is for, if any. */
typedef struct {
    lt_arena *arena;
    const model *m;
    lt_weights_file file;
    weight_place place;
    lt_param **param, **twin;       /* file.n of them; twin: what takes the same weight besides */
    const lt_array **average;       /* of the weight, which a run of ours may have kept and is taken instead; or NULL */
    weights_report report;
} match;

/* What its own dict calls the array. */
static const char *own_name(const match *a, size_t i)
{
    return a->file.entry[i].name + a->file.within[i];
}

static lt_status check_array(const match *a, const lt_array *array, const char *name, const lt_param *p)
{
    const lt_status st = array_check(a->file.path, name, array, p->name, &p->shape);

    for (size_t i = 0; !st && i < lt_array_count(array); i++)
        if (!isfinite(lt_array_get(array, i)))
            return lt_error(LT_EFORMAT, "%s: \"%s\" is not finite at %zu", a->file.path, name, i);
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
static lt_status match_twin(match *a, size_t i)
{
    const char *const *twins = a->m->cls->twins, *block = a->place.block, *name = a->param[i]->name;
    const lt_array *array = &a->file.entry[i].array;
    const size_t n = twins ? strlen(twins[0]) : 0;
    lt_param *p;

    if (!twins || !block || strcmp(block, twins[0]) != 0 || strncmp(name, block, n) != 0 || name[n] != '.')
        return LT_OK;
    p = weight_param_in(a->m, twins[1], name + n + 1);
    if (!p)
        return LT_OK;
    a->twin[i] = p;
    a->report.n_loaded++;
    return is_summed(array, p) ? LT_OK : check_array(a, array, own_name(a, i), p);
}

static lt_status find_average(match *a, size_t i)
{
    const lt_named_array *average = checkpoint_average(a->file.entry, a->file.n, a->file.entry[i].name);

    if (!average)
        return LT_OK;
    a->average[i] = &average->array;
    return check_array(a, &average->array, average->name, a->param[i]);
}

/* Whether an array lies in the dict that the weights are taken from. */
static bool in_same_dict(const match *a, size_t i, size_t taken)
{
    const size_t n = a->file.within[taken];

    return a->file.within[i] >= n && strncmp(a->file.entry[i].name, a->file.entry[taken].name, n) == 0;
}

/* Whether p has another shape because the file is of a network that looks for something else */
static bool begins_fresh(const match *a, const lt_named_array *e, const lt_param *p)
{
    for (const char *const *fresh = a->m->cls->fresh; fresh && *fresh; fresh++)
        if (strncmp(p->name, *fresh, strlen(*fresh)) == 0)
            return !array_fits(&e->array, &p->shape);
    return false;
}

static lt_status match_one(match *a, size_t i)
{
    const lt_named_array *e = &a->file.entry[i];
    lt_param *p = weight_passed_over(e->name) ? NULL : weight_param(&a->place, a->m, e->name);
    lt_status st;

    if (!p || begins_fresh(a, e, p))
        return LT_OK;
    if (is_taken(a, p, i))
        return lt_error(LT_EFORMAT, "%s: \"%s\" is the second array for \"%s\"", a->file.path, own_name(a, i), p->name);
    a->param[i] = p;
    a->report.n_loaded++;
    st = check_array(a, &e->array, own_name(a, i), p);
    st = st ? st : match_twin(a, i);
    return st ? st : find_average(a, i);
}

/* What a parameter wants and the file has, but in elements that are not read. */
static lt_status check_refused(const match *a)
{
    for (size_t i = 0; i < a->file.n_refused; i++) {
        const lt_refused_array *r = &a->file.refused[i];
        const lt_param *p = weight_param(&a->place, a->m, r->name);

        if (p)
            return lt_error(LT_EFORMAT, "%s: \"%s\", which \"%s\" wants: %s", a->file.path, r->name, p->name,
                            r->reason);
    }
    return LT_OK;
}

static void list_left_over(match *a)
{
    size_t taken = 0;

    while (taken < a->file.n && !a->param[taken])
        taken++;
    for (size_t i = 0; taken < a->file.n && i < a->file.n; i++)
        if (!a->param[i] && !weight_passed_over(own_name(a, i)) && in_same_dict(a, i, taken))
            a->report.left_over[a->report.n_left_over++] = a->file.entry[i].name + a->file.within[taken];
}

/* Some of the names that there are, and of those that are wanted. */
static lt_status none_fits(const match *a)
{
    const char *name[SHOWN], *wanted[SHOWN];
    size_t n = 0, n_wanted = 0;

    if (!a->file.n && a->file.n_refused)
        return lt_error(LT_EINVAL, "%s: \"%s\": %s", a->file.path, a->file.refused[0].name, a->file.refused[0].reason);
    if (!a->file.n)
        return lt_error(LT_EINVAL, "%s: holds no arrays (%s)", a->file.path, a->file.format);
    for (; n < a->file.n && n < SHOWN; n++)
        name[n] = a->file.entry[n].name;
    for (const lt_param *p = lt_params_first(a->m->params); p && n_wanted < 3; p = p->next)
        wanted[n_wanted++] = p->name;
    return lt_error(LT_EINVAL, "%s: none of its %zu arrays has the name of a parameter of %s; it has %s%s, and wanted "
                    "are %s ...", a->file.path, a->file.n, a->m->cls->name, weights_list(a->arena, name, (int)n),
                    n < a->file.n ? " ..." : "", weights_list(a->arena, wanted, (int)n_wanted));
}

/* Nothing fits, and that is not because the model is of another size: then at least half of the names would be its own,
 * and not in words that are translated. */
static bool is_foreign(const match *a)
{
    size_t counted = 0;

    for (size_t i = 0; i < a->file.n; i++)
        counted += !weight_passed_over(a->file.entry[i].name);
    return !a->place.fit && (!a->place.named || a->place.family != weight_families ||
                             2 * (size_t)a->place.named < counted);
}

static lt_status match_all(match *a)
{
    lt_status st = weight_place_find(a->arena, &a->file, a->m, &a->place);

    if (st)
        return st;
    a->report.format = a->file.format;
    a->report.family = a->place.family->name;
    a->report.note = a->place.family->note;
    a->report.taken = a->place.prefix;
    memcpy(a->report.also, a->place.also, sizeof(a->place.also));
    a->report.n_also = a->place.n_also;
    a->param = lt_arena_array(a->arena, a->file.n, sizeof(*a->param));
    a->twin = lt_arena_array(a->arena, a->file.n, sizeof(*a->twin));
    a->average = lt_arena_array(a->arena, a->file.n, sizeof(lt_array *));
    a->report.left_over = lt_arena_array(a->arena, a->file.n, sizeof(char *));
    if (!a->param || !a->twin || !a->average || !a->report.left_over)
        return lt_error(LT_ENOMEM, "%s: no memory", a->file.path);
    if (is_foreign(a))
        return none_fits(a);
    for (size_t i = 0; !st && i < a->file.n; i++)
        st = match_one(a, i);
    if (!st)
        st = check_refused(a);
    if (!st)
        list_left_over(a);
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

/* A graph that TensorFlow froze begins with a node, which begins with its name. */
static lt_status refuse_graph(const char *path)
{
    char head[3] = "";
    FILE *f = lt_ends_with(path, ".pb") ? fopen(path, "rb") : NULL;
    const bool graph = f && fread(head, 1, sizeof(head), f) == sizeof(head) && head[0] == 0x0a && head[2] == 0x0a;

    if (f)
        fclose(f);
    if (!graph)
        return LT_OK;
    return lt_error(LT_EFORMAT, "%s: a frozen graph of TensorFlow, which is not read; give its arrays as .npz under "
                    "the model's names, or train your own, as `palmar train --config reid` does", path);
}

lt_status weights_init(lt_arena *arena, const char *path, const model *m, weights_report *out)
{
    match a = { .arena = arena, .m = m };
    const char *file = checkpoint_last(arena, path);
    lt_status st = file ? refuse_graph(file) : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (!st)
        st = lt_weights_read(arena, file, &a.file);

    if (!st)
        st = weight_split_attention(arena, m->params, &a.file);
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
