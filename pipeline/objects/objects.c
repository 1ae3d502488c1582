/* SPDX-License-Identifier: Apache-2.0 */
#include "pipeline/objects/objects.h"

#include "assets/ycb/objects.h"
#include "data/dataset.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/nearest.h"
#include "pipeline/objects/mesh.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- a folder of models ---------------------------------------------------------------------------------- */

/* folder is set, the rest zeroed at first */
typedef struct {
    const char *folder;
    const char **name;              /* of the folders in it, n of them */
    size_t n;
} model_folder;

static int is_visible(const struct dirent *e)
{
    return e->d_name[0] != '.';
}

static lt_status list_models(lt_arena *arena, model_folder *out)
{
    const char *folder = out->folder;
    struct dirent **entry;
    const int n = scandir(folder, &entry, is_visible, alphasort);
    lt_status st = LT_OK;

    if (n < 0)
        return lt_error(errno == ENOMEM ? LT_ENOMEM : LT_EIO, "%s: %s", folder, strerror(errno));
    out->name = lt_arena_array(arena, (size_t)n, sizeof(*out->name));
    for (int i = 0; i < n; i++) {
        const char *name = lt_arena_strdup(arena, entry[i]->d_name);
        const char *path = name ? lt_path_join(arena, folder, name) : NULL;

        if (!path || !out->name)
            st = lt_error(LT_ENOMEM, "%s: no memory", folder);
        else if (lt_is_folder(path))
            out->name[out->n++] = name;
        free(entry[i]);
    }
    free(entry);
    if (!st && !out->n)
        return lt_error(LT_EFORMAT, "%s: no folders of models in it; want a folder with a mesh for each object",
                        folder);
    return st;
}

/* "mug" of "025_mug": YCB's names have numbers, which nobody types. */
static const char *without_number(const char *name)
{
    const bool has = strspn(name, "0123456789") == 3 && name[3] == '_' && name[4];

    return has ? name + 4 : name;
}

static bool same_without_number(const char *name, const char *asked)
{
    const char *plain = without_number(name);

    return strcmp(plain, asked) == 0 || (plain == name && strcmp(name, without_number(asked)) == 0);
}

/* The folder that is called so, else the only one that is but for a number; NULL: none, or one too many in *other. */
static const char *find_model(const model_folder *m, const char *asked, const char **other)
{
    const char *found = NULL;

    *other = NULL;
    for (size_t i = 0; i < m->n; i++)
        if (strcmp(m->name[i], asked) == 0 || strcmp(dataset_plain_name(m->name[i]), dataset_plain_name(asked)) == 0)
            return m->name[i];
    for (size_t i = 0; i < m->n; i++)
        if (same_without_number(dataset_plain_name(m->name[i]), dataset_plain_name(asked))) {
            *other = found;
            found = m->name[i];
        }
    return *other ? NULL : found;
}

static lt_status unknown_model(lt_arena *arena, const model_folder *m, const char *asked)
{
    const char **plain = lt_arena_array(arena, m->n, sizeof(*plain));
    char all[512] = "there are:";

    if (!plain)
        return lt_error(LT_ENOMEM, "%s: no memory", m->folder);
    for (size_t i = 0; i < m->n; i++) {
        const size_t n = strlen(all);

        plain[i] = without_number(dataset_plain_name(m->name[i]));
        snprintf(all + n, sizeof(all) - n, "%s%s", i ? ", " : " ", m->name[i]);
    }
    lt_unknown_name(asked, lt_nearest_name(asked, m->name, m->n) ? m->name : plain, m->n, all, "no such object in %s",
                    m->folder);
    return LT_EUSAGE;                           /* what was wrong is how the command was called */
}

/* ---- units and axes -------------------------------------------------------------------------------------- */

static void measure(const lt_mesh *mesh, double size[3], double centre[3], double *longest)
{
    lt_box b;

    *longest = 0;
    if (lt_box_from_points(mesh->n_vertices, mesh->vertex[0], &b))
        b = (lt_box){ { 0 }, { 0 } };
    for (int d = 0; d < 3; d++) {
        size[d] = b.hi[d] - b.lo[d];
        centre[d] = (b.lo[d] + b.hi[d]) / 2;
        *longest = fmax(*longest, size[d]);
    }
}

static lt_status fit_unit(lt_arena *arena, const ycb_object *ycb, predict_object *o, lt_box *points)
{
    double size[3], centre[3], longest, in_points = 0;
    object_unit unit;

    measure(&o->mesh, size, centre, &longest);
    unit = object_unit_of(longest, ycb ? fmax(fmax(ycb->size[0], ycb->size[1]), ycb->size[2]) : 0);
    if (unit.scale <= 0)
        return lt_error(LT_EFORMAT, "%s: the model spans %.3g m, want metres: what a hand holds spans 5 mm to 2 m%s%s",
                        o->origin, longest, ycb ? ", and this one as much as YCB's " : "", ycb ? ycb->name : "");
    for (int d = 0; d < 3; d++)
        in_points = fmax(in_points, points->hi[d] - points->lo[d]);
    if (fabs(in_points - longest) > 0.2 * longest)
        return lt_error(LT_EFORMAT, "%s: the mesh spans %.3g, points.xyz %.3g; want both in metres, or no points.xyz",
                        o->origin, longest, in_points);
    if (unit.scale == 1)
        return LT_OK;
    for (int i = 0; i < o->mesh.n_vertices; i++)
        for (int d = 0; d < 3; d++)
            o->mesh.vertex[i][d] = (float)(o->mesh.vertex[i][d] * unit.scale);
    for (int d = 0; d < 3; d++)
        points->lo[d] *= unit.scale, points->hi[d] *= unit.scale;
    o->unit_note = lt_arena_printf(arena, "the model of %s spans %.3g m: taken for %s, it spans %.3g m", o->name,
                                   longest, unit.unit, longest * unit.scale);
    return o->unit_note ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", o->origin);
}

/* "x, z and -y" of { 1, 3, -2 } */
static const char *axes_text(const int turn[3], char out[16])
{
    static const char *const name[] = { "-z", "-y", "-x", "", "x", "y", "z" };

    snprintf(out, 16, "%s, %s and %s", name[turn[0] + 3], name[turn[1] + 3], name[turn[2] + 3]);
    return out;
}

/* A model with other axes than those that networks are trained with has poses that are turned. */
static lt_status check_axes(lt_arena *arena, const ycb_object *ycb, predict_object *o)
{
    double size[3], centre[3], longest;
    char axes[16];
    int turn[3];

    if (!ycb)
        return LT_OK;
    measure(&o->mesh, size, centre, &longest);
    if (!object_turn_of(size, centre, ycb->size, ycb->centre, turn))
        o->axes_note = lt_arena_printf(arena, "the model of %s is %.3g x %.3g x %.3g m, YCB's %.3g x %.3g x %.3g: "
                                       "another object?", o->name, size[0], size[1], size[2], ycb->size[0],
                                       ycb->size[1], ycb->size[2]);
    else if (turn[0] != 1 || turn[1] != 2 || turn[2] != 3)
        o->axes_note = lt_arena_printf(arena, "the model of %s has YCB's axes %s as its x, y and z: turn it, or poses "
                                       "are of another frame than the network's", o->name, axes_text(turn, axes));
    else
        return LT_OK;
    return o->axes_note ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", o->origin);
}

static void set_control(const lt_box *box, predict_object *out)
{
    double control[LT_BOX_POINTS][3];

    lt_box21(box, control);
    for (int i = 0; i < LT_BOX_POINTS; i++)
        for (int d = 0; d < 3; d++) {
            out->control[i][d] = (float)control[i][d];
            out->mirrored[i][d] = d ? out->control[i][d] : -out->control[i][d];
        }
}

static lt_status from_folder(lt_arena *arena, const predict_options *o, const char *asked, const ycb_object **ycb,
                             predict_object *out)
{
    const char *name, *other;
    model_folder models = { .folder = o->models };
    lt_box points;
    lt_status st = list_models(arena, &models);

    if (st)
        return st;
    name = find_model(&models, asked, &other);
    if (!name && other)
        return lt_error(LT_EUSAGE, "several objects in %s are called so, as %s; give the whole name", o->models, other);
    if (!name)
        return unknown_model(arena, &models, asked);
    *ycb = ycb_find_name(dataset_plain_name(name));
    out->name = name;
    out->origin = lt_path_join(arena, o->models, name);
    st = out->origin ? object_mesh_read(arena, out->origin, &out->mesh, &points)
                     : lt_error(LT_ENOMEM, "%s: no memory", asked);
    st = st ? st : fit_unit(arena, *ycb, out, &points);
    st = st ? st : check_axes(arena, *ycb, out);
    if (!st)
        set_control(&points, out);
    return st;
}

/* ---- the one or the other -------------------------------------------------------------------------------- */

static lt_status stand_in(lt_arena *arena, const char *asked, const ycb_object **ycb, predict_object *out)
{
    float (*point)[3];
    lt_box box;
    lt_status st = predict_find_object(asked, ycb);

    st = st ? st : synth_object_new(arena, (*ycb)->id, &out->mesh);
    st = st ? st : synth_object_points(arena, &out->mesh, &point);
    st = st ? st : lt_box_from_points(SYNTH_POINTS, point[0], &box);
    if (st)
        return st;
    set_control(&box, out);
    out->name = (*ycb)->name;
    out->origin = "embedded stand-in, not the scanned model";
    return LT_OK;
}

static void find_symmetries(const ycb_object *ycb, predict_object *out)
{
    lt_pose turn[YCB_TURNS];

    out->n_symmetries = ycb_symmetries(ycb, turn);
    for (int i = 0; i < out->n_symmetries; i++)
        lt_rot_to_quat(turn[i].R, out->symmetry[i]);
}

lt_status predict_load_object(lt_arena *arena, const predict_options *o, const char *asked, predict_object *out)
{
    const ycb_object *ycb = NULL;
    const lt_status st = o->models ? from_folder(arena, o, asked, &ycb, out) : stand_in(arena, asked, &ycb, out);

    if (!st && ycb)
        find_symmetries(ycb, out);
    return st ? st : lt_surface_of(arena, &out->mesh, &out->surface, &out->mirrored_surface);
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
    st = predict_load_object(arena, o, asked, object);
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
        return lt_error_prefix(st, "--object %s", o->object);
    for (size_t i = 0; i < b->n; i++) {
        st = *b->row[i].object_name ? take(arena, o, b->row[i].object_name, &all, &b->row[i].model) : LT_OK;
        if (st)
            return lt_error_prefix(st, "%s:%lld: object_name %s", b->path, (long long)b->row[i].line,
                                   b->row[i].object_name);
    }
    return LT_OK;
}
