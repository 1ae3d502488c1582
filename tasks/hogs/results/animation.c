/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/results/animation.h"

#include "libtensor/geometry/rotation.h"
#include "libtensor/io/mesh/glb.h"
#include "tasks/hogs/results/shapes.h"

#include <string.h>

/* What moves through the frames */
struct hogs_actor {
    const char *name;
    lt_mesh mesh;
    lt_glb_key *key;
    int n_keys;
    size_t room;
};

static float seconds_of(int frame)
{
    return (float)frame / HOGS_ANIMATION_FPS;
}

/* One more node, whose surface is that of a part; *out NULL: it has none */
static lt_status add_actor(hogs_animation *a, const posed_frame *f, int part, const char *name, struct hogs_actor **out)
{
    struct hogs_actor *all = lt_arena_grow(a->arena, a->actor, (size_t)a->n, &a->room, sizeof(*all)), *actor;
    lt_status st;

    *out = NULL;
    if (!all || !name)
        return lt_error(LT_ENOMEM, "no memory for %d surfaces", a->n + 1);
    a->actor = all;
    actor = &all[a->n];
    *actor = (struct hogs_actor){ .name = name };
    st = posed_surface(f, part, a->rule, a->iso, a->arena, &actor->mesh);
    if (st || !actor->mesh.n_faces)
        return st;
    hogs_linear_colours(&actor->mesh);
    a->n++;
    *out = actor;
    return LT_OK;
}

static lt_status add_key(hogs_animation *a, struct hogs_actor *actor, lt_glb_key key)
{
    lt_glb_key *all = lt_arena_grow(a->arena, actor->key, (size_t)actor->n_keys, &actor->room, sizeof(*all));

    if (!all)
        return lt_error(LT_ENOMEM, "no memory for %d keys", actor->n_keys + 1);
    actor->key = all;
    all[actor->n_keys++] = key;
    return LT_OK;
}

/* Shown from this frame on, until there is another key; hidden before */
static lt_status enter(hogs_animation *a, struct hogs_actor *actor, lt_glb_key key)
{
    lt_glb_key before = key;
    lt_status st = LT_OK;

    before.seconds = 0;
    before.shown = false;
    if (!actor->n_keys && a->frames)
        st = add_key(a, actor, before);
    return st ? st : add_key(a, actor, key);
}

static lt_status add_hand(hogs_animation *a, const posed_frame *f)
{
    const lt_glb_key key = { .seconds = seconds_of(a->frames), .rotation = { 1 }, .shown = true };
    struct hogs_actor *actor;
    lt_status st = LT_OK;

    if (f->n[POSED_HAND])
        st = add_actor(a, f, POSED_HAND, lt_arena_printf(a->arena, "%s frame %lld", f->part[POSED_HAND],
                                                         (long long)f->number), &actor);
    return st || !f->n[POSED_HAND] || !actor ? st : enter(a, actor, key);
}

/* From the camera's frame to the object's own, x_object = R^T (x - t) */
static void take_out_of_pose(lt_mesh *m, const posed_frame *f)
{
    for (int i = 0; i < m->n_vertices; i++) {
        double x[3];

        for (int k = 0; k < 3; k++)
            x[k] = (double)m->vertex[i][k] - f->t[k];
        for (int k = 0; k < 3; k++)
            m->vertex[i][k] = (float)(f->R[k] * x[0] + f->R[3 + k] * x[1] + f->R[6 + k] * x[2]);
    }
}

static lt_status add_object(hogs_animation *a, const posed_frame *f)
{
    lt_glb_key key = { .seconds = seconds_of(a->frames), .shown = true };
    struct hogs_actor *actor = NULL;
    double q[4];
    lt_status st = LT_OK;

    lt_rot_to_quat(f->R, q);
    for (int k = 0; k < 4; k++)
        key.rotation[k] = (float)q[k];
    for (int k = 0; k < 3; k++)
        key.translation[k] = (float)f->t[k];
    for (int i = 0; i < a->n && !actor; i++)
        actor = strcmp(a->actor[i].name, f->part[POSED_OBJECT]) == 0 ? &a->actor[i] : NULL;
    if (!actor && f->n[POSED_OBJECT]) {
        st = add_actor(a, f, POSED_OBJECT, lt_arena_printf(a->arena, "%s", f->part[POSED_OBJECT]), &actor);
        if (!st && actor)
            take_out_of_pose(&actor->mesh, f);
    }
    return st || !actor ? st : enter(a, actor, key);
}

/* What has no key of this frame has left. */
static lt_status hide_absent(hogs_animation *a)
{
    const float now = seconds_of(a->frames);
    lt_status st = LT_OK;

    for (int i = 0; i < a->n && !st; i++) {
        const lt_glb_key last = a->actor[i].key[a->actor[i].n_keys - 1];
        lt_glb_key key = last;

        key.seconds = now;
        key.shown = false;
        if (last.shown && last.seconds < now)
            st = add_key(a, &a->actor[i], key);
    }
    return st;
}

lt_status hogs_animation_add(void *ctx, const posed_frame *f)
{
    hogs_animation *a = ctx;
    lt_status st = add_hand(a, f);

    if (!st)
        st = add_object(a, f);
    if (!st)
        st = hide_absent(a);
    a->frames++;
    return st;
}

lt_status hogs_animation_write(const hogs_animation *a, const char *path)
{
    lt_glb_part *part = lt_arena_array(a->arena, (size_t)a->n + 1, sizeof(*part));
    lt_status st = LT_OK;

    if (!part)
        return lt_error(LT_ENOMEM, "no memory for %d surfaces", a->n);
    if (!a->n)
        return lt_error(LT_EINVAL, "%s: none of %d frames has a surface at iso %g", path, a->frames, a->iso);
    for (int i = 0; i < a->n && !st; i++) {
        struct hogs_actor actor = a->actor[i];
        lt_glb_key end = actor.key[actor.n_keys - 1];

        end.seconds = seconds_of(a->frames);            /* the last frame lasts as long as the others */
        st = add_key((hogs_animation *)a, &actor, end);
        part[i] = (lt_glb_part){ .name = actor.name, .mesh = &a->actor[i].mesh, .color = { 1, 1, 1, 1 },
                                 .key = actor.key, .n_keys = actor.n_keys };
    }
    return st ? st : lt_glb_write(path, part, a->n);
}
