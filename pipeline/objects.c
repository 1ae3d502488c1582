/* SPDX-License-Identifier: Apache-2.0 */
/* The models of objects that were named: scanned ones from a folder, or the embedded stand-ins. */
#include "pipeline/internal.h"

#include "assets/ycb/objects.h"
#include "data/dataset.h"
#include "libtensor/geometry/box21.h"
#include "libtensor/geometry/rotation.h"

#include <string.h>

static lt_status stand_in(lt_arena *arena, const ycb_object *ycb, predict_object *out)
{
    float (*point)[3];
    double control[LT_BOX_POINTS][3];
    lt_box box;
    lt_status st = synth_object_new(arena, ycb->id, &out->mesh);

    st = st ? st : synth_object_points(arena, &out->mesh, &point);
    st = st ? st : lt_box_from_points(SYNTH_POINTS, point[0], &box);
    if (st)
        return st;
    lt_box21(&box, control);
    for (int i = 0; i < LT_BOX_POINTS; i++)
        for (int d = 0; d < 3; d++)
            out->control[i][d] = (float)control[i][d];
    out->name = ycb->name;
    out->origin = "embedded stand-in, not the scanned model";
    return LT_OK;
}

static lt_status from_folder(lt_arena *arena, const char *folder, const char *name, predict_object *out)
{
    const dataset_object *object;
    int n;
    const lt_status st = dataset_load_objects(arena, folder, &name, 1, &object, &n);

    if (st)
        return st;
    out->mesh = object->mesh;
    memcpy(out->control, object->control, sizeof(out->control));
    out->name = object->name;
    out->origin = folder;
    return LT_OK;
}

static void find_symmetries(const ycb_object *ycb, predict_object *out)
{
    lt_pose turn[YCB_TURNS];

    out->n_symmetries = ycb_symmetries(ycb, turn);
    for (int i = 0; i < out->n_symmetries; i++)
        lt_rot_to_quat(turn[i].R, out->symmetry[i]);
}

static lt_status load_object(lt_arena *arena, const predict_options *o, const char *name, predict_object *out)
{
    const ycb_object *ycb;
    lt_status st = predict_find_object(name, &ycb);

    if (st)
        return st;
    find_symmetries(ycb, out);
    st = o->models ? from_folder(arena, o->models, ycb->name, out) : stand_in(arena, ycb, out);
    for (int i = 0; i < LT_BOX_POINTS && !st; i++)
        for (int d = 0; d < 3; d++)
            out->mirrored[i][d] = d ? out->control[i][d] : -out->control[i][d];
    return st;
}

/* Those loaded so far, by the names that were asked for */
typedef struct {
    struct { const char *asked; const predict_object *object; } *entry;
    size_t n, room;
} shelf;

static lt_status take(lt_arena *arena, const predict_options *o, const char *asked, shelf *all,
                      const predict_object **out)
{
    predict_object *object;
    lt_status st;

    for (size_t i = 0; i < all->n; i++)
        if (strcmp(all->entry[i].asked, asked) == 0) {
            *out = all->entry[i].object;
            return LT_OK;
        }
    all->entry = lt_arena_grow(arena, all->entry, all->n, &all->room, sizeof(*all->entry));
    object = all->entry ? lt_arena_alloc(arena, sizeof(*object)) : NULL;
    if (!object)
        return lt_error(LT_ENOMEM, "%s: no memory", asked);
    st = load_object(arena, o, asked, object);
    if (st)
        return st;
    all->entry[all->n].asked = asked;
    all->entry[all->n++].object = *out = object;
    return LT_OK;
}

lt_status predict_load_objects(lt_arena *arena, const predict_options *o, predict_boxes *b,
                               const predict_object **given)
{
    shelf all = { .n = 0 };
    lt_status st = LT_OK;

    *given = NULL;
    if (o->object)
        st = take(arena, o, o->object, &all, given);
    if (st)
        return st;
    for (size_t i = 0; i < b->n; i++) {
        st = *b->row[i].object_name ? take(arena, o, b->row[i].object_name, &all, &b->row[i].model) : LT_OK;
        if (st)
            return lt_error_prefix(st, "%s:%lld", b->path, (long long)b->row[i].line);
    }
    return LT_OK;
}
