/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/backbone.h"

#include "estimate/checkpoint/folder.h"
#include "estimate/param_arrays.h"
#include "libtensor/io/torch/weights_file.h"

#include <string.h>

static const char LEVEL[] = "gpm.sa1.", INPUT[] = "gpm.sa1.input.";

static bool ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text), m = strlen(end);

    return n >= m && strcmp(text + n - m, end) == 0 && (n == m || text[n - m - 1] == '.');
}

/* "sa1.mlp_convs.1.weight", with whatever stands before it, but for what an optimiser remembers */
static const lt_named_array *find(const lt_weights_file *f, const char *name)
{
    for (size_t i = 0; i < f->n; i++)
        if (strncmp(f->entry[i].name, "optim.", 6) != 0 && ends_with(f->entry[i].name, name))
            return &f->entry[i];
    return NULL;
}

lt_status hogs_load_backbone(lt_params *set, const char *path)
{
    lt_arena *arena = lt_arena_new();
    const char *file = arena ? checkpoint_last(arena, path) : NULL;
    lt_weights_file f;
    lt_status st = file ? lt_weights_read(arena, file, &f) : lt_error(LT_ENOMEM, "%s: no memory", path);

    for (lt_param *p = lt_params_first(set); p && !st; p = p->next) {
        const char *name = p->name + strlen("gpm.");
        const lt_named_array *a;

        if (strncmp(p->name, LEVEL, strlen(LEVEL)) != 0 || strncmp(p->name, INPUT, strlen(INPUT)) == 0)
            continue;
        a = find(&f, name);
        if (!a)
            st = lt_error(LT_EINVAL, "%s: model.point_backbone: has no \"%s\": no PointNet++ of ULIP's names", path,
                          name);
        else if (!array_fits(&a->array, &p->shape))
            st = array_check(path, a->name, &a->array, p->name, &p->shape);
        else
            array_load(&a->array, p->data);
    }
    lt_params_changed(set);
    lt_arena_free(arena);
    return st;
}
