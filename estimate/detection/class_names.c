/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/detection/class_names.h"

#include "assets/ycb/ycb.h"

#include <string.h>

enum { OURS = 2 + YCB_COUNT, COCO = 80, MOST = 1000 };

/* In the order of their ids, from which numbers without a class are left out [Lin et al. 2014] */
static const char coco[] =
    "person,bicycle,car,motorcycle,airplane,bus,train,truck,boat,traffic light,fire hydrant,stop sign,parking meter,"
    "bench,bird,cat,dog,horse,sheep,cow,elephant,bear,zebra,giraffe,backpack,umbrella,handbag,tie,suitcase,frisbee,"
    "skis,snowboard,sports ball,kite,baseball bat,baseball glove,skateboard,surfboard,tennis racket,bottle,wine glass,"
    "cup,fork,knife,spoon,bowl,banana,apple,sandwich,orange,broccoli,carrot,hot dog,pizza,donut,cake,chair,couch,"
    "potted plant,bed,dining table,toilet,tv,laptop,mouse,remote,keyboard,cell phone,microwave,oven,toaster,sink,"
    "refrigerator,book,clock,vase,scissors,teddy bear,hair drier,toothbrush";

static int count_listed(const char *listed)
{
    int n = listed && *listed;

    for (const char *c = listed; n && *c; c++)
        n += *c == ',';
    return n;
}

static const char *name_ours(lt_arena *arena, int cls)
{
    return lt_arena_strdup(arena, cls == 0 ? "person" : cls == 1 ? "hand" : ycb_find(cls - 1)->name);
}

const char **class_names_of(lt_arena *arena, const char *listed, int n)
{
    const char **name = lt_arena_array(arena, (size_t)n, sizeof(*name));
    const char *from = count_listed(listed) == n ? listed : n == COCO ? coco : NULL;
    char *rest = from ? lt_arena_strdup(arena, from) : NULL;
    bool ok = name && (rest || !from);

    for (int c = 0; c < n && ok; c++) {
        name[c] = from ? strsep(&rest, ",") : n == OURS ? name_ours(arena, c) : lt_arena_printf(arena, "class %d", c);
        ok = name[c];
    }
    return ok ? name : NULL;
}

const char *class_names_join(lt_arena *arena, const char *const *name, int n)
{
    size_t bytes = 1;
    char *all, *end;

    for (int c = 0; c < n; c++)
        bytes += (name[c] ? strlen(name[c]) : 0) + 1;
    all = end = lt_arena_alloc(arena, bytes);
    for (int c = 0; c < n && all; c++) {
        if (c)
            *end++ = ',';
        for (const char *from = name[c] ? name[c] : ""; *from; from++)
            *end++ = *from == ',' ? ';' : *from;
    }
    return all;
}

/* ---- in a checkpoint ------------------------------------------------------------------------------------- */

/* Of a dict, or of what a module keeps */
static const lt_pvalue *member(const lt_pvalue *v, const char *key)
{
    return lt_pdict_get(v && v->kind == LT_POBJECT ? v->u.object.state : v, key);
}

/* The text that a dict has for a number, or that stands in that place of a list */
static const char *name_at(const lt_pvalue *names, int64_t c)
{
    if (names->kind == LT_PLIST || names->kind == LT_PTUPLE)
        return lt_pstr(names->u.item[c]);
    for (size_t i = 0; i < names->n; i++) {
        int64_t key;

        if (lt_pint(names->u.item[2 * i], &key) && key == c)
            return lt_pstr(names->u.item[2 * i + 1]);
    }
    return NULL;
}

static bool holds_names(const lt_pvalue *v)
{
    return v && (v->kind == LT_PDICT || v->kind == LT_PLIST || v->kind == LT_PTUPLE) && v->n >= 1 && v->n <= MOST;
}

lt_status class_names_in(lt_arena *arena, const lt_torch_file *file, const char **out)
{
    const lt_pvalue *names = member(member(file->value, "model"), "names");
    const char *name[MOST];

    *out = NULL;
    if (!holds_names(names))
        names = member(member(file->value, "ema"), "names");
    if (!holds_names(names))
        return LT_OK;
    for (size_t c = 0; c < names->n; c++) {
        name[c] = name_at(names, (int64_t)c);
        if (!name[c])
            return LT_OK;
    }
    *out = class_names_join(arena, name, (int)names->n);
    return *out ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", file->path);
}

lt_status class_names_saved(lt_arena *arena, const char *path, const char **out)
{
    lt_torch_file file;
    const lt_status st = lt_torch_read(arena, path, &file);

    return st ? st : class_names_in(arena, &file, out);
}
