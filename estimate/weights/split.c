/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/weights/split.h"

#include <string.h>

/* What the name of one array ends with, and what those of its parts do; behind "q", "k", "v". */
typedef struct { const char *whole, *part; } ending;

static const ending endings[] = {
    { "in_proj_weight", "_proj.weight" }, { "in_proj_bias", "_proj.bias" },
    { "qkv.weight", "_proj.weight" }, { "qkv.bias", "_proj.bias" },
};

/* Characters of name before the end, or -1 */
static int stem(const char *name, const char *end)
{
    const size_t n = strlen(name), k = strlen(end);

    return n > k && name[n - k - 1] == '.' && strcmp(name + n - k, end) == 0 ? (int)(n - k) : -1;
}

static bool has_ending(const lt_params *set, const char *end)
{
    for (const lt_param *p = lt_params_first(set); p; p = p->next)
        if (stem(p->name, end) >= 0)
            return true;
    return false;
}

static const ending *ending_of(const lt_params *set, const lt_named_array *e)
{
    for (size_t i = 0; i < LT_COUNT(endings); i++)
        if (stem(e->name, endings[i].whole) >= 0)
            return e->array.rank > 0 && e->array.shape[0] % 3 == 0 && !has_ending(set, endings[i].whole) ? &endings[i]
                                                                                                      : NULL;
    return NULL;
}

/* Part 0, 1 or 2 of an array's rows */
static lt_array third(const lt_array *a, int part)
{
    lt_array t = *a;

    t.shape[0] /= 3;
    t.data = (char *)a->data + (size_t)part * lt_array_count(&t) * lt_elem_size(a->type);
    return t;
}

static bool add_thirds(lt_arena *arena, const lt_named_array *e, const ending *end, lt_named_array out[3])
{
    for (int part = 0; part < 3; part++) {
        out[part].name = lt_arena_printf(arena, "%.*s%c%s", stem(e->name, end->whole), e->name, "qkv"[part], end->part);
        out[part].array = third(&e->array, part);
        if (!out[part].name)
            return false;
    }
    return true;
}

lt_status weight_split_attention(lt_arena *arena, const lt_params *set, lt_weights_file *file)
{
    lt_named_array *entry = lt_arena_array(arena, 3 * file->n, sizeof(*entry));
    size_t *within = lt_arena_array(arena, 3 * file->n, sizeof(*within)), n = 0;

    if (!entry || !within)
        return lt_error(LT_ENOMEM, "%s: no memory", file->path);
    for (size_t i = 0; i < file->n; i++) {
        const ending *end = ending_of(set, &file->entry[i]);
        const int parts = end ? 3 : 1;

        for (int k = 0; k < parts; k++)
            within[n + (size_t)k] = file->within[i];
        entry[n] = file->entry[i];
        if (end && !add_thirds(arena, &file->entry[i], end, entry + n))
            return lt_error(LT_ENOMEM, "%s: no memory", file->path);
        n += (size_t)parts;
    }
    file->entry = entry;
    file->within = within;
    file->n = n;
    return LT_OK;
}
