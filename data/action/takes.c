/* SPDX-License-Identifier: Apache-2.0 */
#include "data/action/takes.h"

#include "data/contact.h"
#include "data/dexycb/dexycb.h"
#include "data/kind.h"
#include "libtensor/geometry/box21.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { REACHING = 2, PLACING = 7, HANDING_OVER, PICKING_UP };       /* of action_classes */
enum { TOUCHES = 3, HALF_SECOND = 15, SECOND = 30 };                /* frames */
enum { CORNERS = 8, CENTRE = LT_BOX_POINTS - 1 };                   /* of control points */

static const double CONTACT = 0.005, LEFT = 0.02;                   /* metres */

/* ---- where a take is cut ---- */

static int between(int x, int lo, int hi)
{
    return x < lo ? lo : x > hi ? hi : x;
}

int action_cut_take(const action_take *t, action_cut out[ACTION_CUTS])
{
    const int end = t->frames - 1;
    const int from = between(t->touched - HALF_SECOND, 0, end), to = between(t->left + SECOND, from, end);

    if (t->touched < 0 || t->left < 0)
        return 0;
    out[0] = (action_cut){ REACHING, 0, t->touched, false };
    out[1] = (action_cut){ PICKING_UP, from, to, false };
    out[2] = (action_cut){ HANDING_OVER, between(t->left + HALF_SECOND, 0, end), end, false };
    out[3] = (action_cut){ PLACING, from, to, true };
    return ACTION_CUTS;
}

/* ---- takes ---- */

/* Frames of one camera, by their numbers */
typedef struct {
    const char *name;               /* "SUBJECT/TAKE" */
    int subject, frames;            /* frames: 1 + the last one's number */
    float (*points)[ACTION_HAND_OBJECT][3];     /* (frames) */
    bool *valid, *touches;
} take;

typedef struct {
    take *take;
    size_t n, room;
    bool synthetic;
} takes;

static lt_status no_memory(const char *root)
{
    return lt_error(LT_ENOMEM, "%s: no memory for clips", root);
}

/* Of "SUBJECT/TAKE/CAMERA/FRAME": how many characters go before the camera, and before the frame */
static bool parts_of(const char *name, size_t *before_camera, size_t *before_frame)
{
    const char *frame = strrchr(name, '/'), *camera = frame;

    while (camera && camera > name && camera[-1] != '/')
        camera--;
    *before_frame = frame ? (size_t)(frame - name) : 0;
    *before_camera = camera > name ? (size_t)(camera - name) - 1 : 0;
    return *before_camera > 0;
}

/* The samples of a take's first camera, from sample `first` on: *n of them, and *next, where the next take begins */
static void first_camera(const dataset *d, int64_t first, int64_t *n, int64_t *next)
{
    const char *name = dataset_name(d, first);
    size_t before_camera = 0, before_frame = 0;
    int64_t i = first;

    parts_of(name, &before_camera, &before_frame);
    while (i < d->count && strncmp(dataset_name(d, i), name, before_frame + 1) == 0)
        i++;
    *n = i - first;
    while (i < d->count && strncmp(dataset_name(d, i), name, before_camera + 1) == 0)
        i++;
    *next = i;
}

static void copy_points(const dataset *d, const dataset_sample *s, float out[ACTION_HAND_OBJECT][3])
{
    const float (*control)[3] = dataset_shape(&d->objects[s->object], s->flags).control;

    memcpy(out, s->joints, sizeof(s->joints));
    for (int k = 0; k <= CORNERS; k++)
        for (int i = 0; i < 3; i++) {
            const float *p = control[k < CORNERS ? k : CENTRE];

            out[LT_HAND_KEYPOINTS + k][i]
                = s->R[3 * i] * p[0] + s->R[3 * i + 1] * p[1] + s->R[3 * i + 2] * p[2] + s->t[i];
        }
}

static int frame_of(const char *name)
{
    return atoi(strrchr(name, '/') + 1);
}

static lt_status new_take(lt_arena *arena, const dataset *d, int64_t first, int64_t n, take *out)
{
    const char *name = dataset_name(d, first);
    size_t before_camera = 0, before_frame = 0;

    parts_of(name, &before_camera, &before_frame);
    *out = (take){ .name = lt_arena_printf(arena, "%.*s", (int)before_camera, name), .subject = d->kind->subject(name),
                   .frames = 1 + frame_of(dataset_name(d, first + n - 1)) };
    if (out->frames < 1 || out->frames > ACTION_MOST_FRAMES || out->subject < 0)
        return lt_error(LT_EFORMAT, "%s/%s: no take of 1 to %d frames of a subject", d->root, name, ACTION_MOST_FRAMES);
    out->points = lt_arena_array(arena, (size_t)out->frames, sizeof(*out->points));
    out->valid = lt_arena_array(arena, (size_t)out->frames, sizeof(*out->valid));
    out->touches = lt_arena_array(arena, (size_t)out->frames, sizeof(*out->touches));
    return out->name && out->points && out->valid && out->touches ? LT_OK : no_memory(d->root);
}

static lt_status read_take(lt_arena *arena, const dataset *d, const lt_hand_model *hand, int64_t first, int64_t n,
                           take *out)
{
    lt_arena *scratch = lt_arena_new();
    const unsigned want = SAMPLE_JOINTS | SAMPLE_OBJECT;
    const int64_t *close;
    int64_t n_close = 0;
    lt_status st = scratch ? new_take(arena, d, first, n, out) : no_memory(d->root);

    for (int64_t i = first; i < first + n && !st; i++) {
        const int k = frame_of(dataset_name(d, i));
        dataset_sample s;

        st = dataset_annotation(d, i, scratch, &s);
        if (st || k < 0 || k >= out->frames || (s.flags & want) != want || s.object < 0)
            continue;
        out->valid[k] = true;
        copy_points(d, &s, out->points[k]);
    }
    st = st ? st : contact_select(d, hand, first, n, CONTACT, scratch, &close, &n_close);
    for (int64_t i = 0; i < n_close && !st; i++)
        out->touches[frame_of(dataset_name(d, close[i]))] = true;
    lt_arena_free(scratch);
    return st;
}

/* The first of three frames in a row in which the hand touches the object */
static int touched_at(const take *t)
{
    for (int k = 0, run = 0; k < t->frames; k++) {
        run = t->touches[k] ? run + 1 : 0;
        if (run == TOUCHES)
            return k - TOUCHES + 1;
    }
    return -1;
}

/* The first frame in which the object's middle is away from where it was first seen */
static int left_at(const take *t)
{
    const float *place = NULL;

    for (int k = 0; k < t->frames; k++) {
        const float *p = t->points[k][ACTION_HAND_OBJECT - 1];

        if (!t->valid[k])
            continue;
        place = place ? place : p;
        if (sqrt(pow((double)(p[0] - place[0]), 2) + pow((double)(p[1] - place[1]), 2) +
                 pow((double)(p[2] - place[2]), 2)) > LEFT)
            return k;
    }
    return -1;
}

static lt_status gather(lt_arena *arena, const char *root, const char *split, const lt_hand_model *hand, takes *out)
{
    dataset *d;
    lt_status st = dataset_open(&(dataset_options){ .root = root, .split = split, .hand = hand }, &d);
    int64_t n, next;

    if (st)
        return st;
    out->synthetic = d->synthetic;
    for (int64_t i = 0; i < d->count && !st; i = next) {
        first_camera(d, i, &n, &next);
        out->take = lt_arena_grow(arena, out->take, out->n, &out->room, sizeof(*out->take));
        st = out->take ? read_take(arena, d, hand, i, n, &out->take[out->n++]) : no_memory(root);
    }
    dataset_free(d);
    return st;
}

/* ---- clips ---- */

static void fill_clip(const action_set *s, int64_t i, const take *t, const action_cut *c)
{
    float *to = (float *)s->hand_object + i * 3 * s->length * ACTION_HAND_OBJECT;
    uint8_t *valid = (uint8_t *)s->valid + i * s->length;

    for (int k = 0; k <= c->last - c->first; k++) {
        const int from = c->backwards ? c->last - k : c->first + k;

        valid[k] = t->valid[from];
        for (int d = 0; d < 3; d++)
            for (int v = 0; v < ACTION_HAND_OBJECT; v++)
                to[((int64_t)d * s->length + k) * ACTION_HAND_OBJECT + v] = t->points[from][v][d];
    }
}

static int cut(const take *t, action_cut out[ACTION_CUTS])
{
    return action_cut_take(&(action_take){ touched_at(t), left_at(t), t->frames }, out);
}

static void measure(const takes *all, action_set *out)
{
    for (size_t i = 0; i < all->n; i++) {
        action_cut c[ACTION_CUTS];
        const int n = cut(&all->take[i], c);

        out->n += n;
        for (int k = 0; k < n; k++)
            out->length = c[k].last - c[k].first >= out->length ? c[k].last - c[k].first + 1 : out->length;
        if (n && all->take[i].subject >= out->subjects)
            out->subjects = all->take[i].subject + 1;
    }
}

static lt_status fill(lt_arena *arena, const takes *all, action_set *out)
{
    const size_t frames = (size_t)out->n * (size_t)out->length;
    action_clip *clip = lt_arena_array(arena, (size_t)out->n, sizeof(*clip));
    int64_t i = 0;

    out->clip = clip;
    out->body = lt_arena_array(arena, frames, 3 * ACTION_BODY * sizeof(float));
    out->hand_object = lt_arena_array(arena, frames, 3 * ACTION_HAND_OBJECT * sizeof(float));
    out->valid = lt_arena_array(arena, frames, 1);
    if (!clip || !out->body || !out->hand_object || !out->valid)
        return no_memory(out->root);
    for (size_t k = 0; k < all->n; k++) {
        action_cut c[ACTION_CUTS];
        const int n = cut(&all->take[k], c);

        for (int j = 0; j < n; j++, i++) {
            clip[i]
                = (action_clip){ .cls = c[j].cls, .subject = all->take[k].subject, .frames = c[j].last - c[j].first + 1,
                                     .onset = -1 };
            clip[i].name = lt_arena_printf(arena, "%s %s", all->take[k].name, action_classes[c[j].cls]);
            if (!clip[i].name)
                return no_memory(out->root);
            fill_clip(out, i, &all->take[k], &c[j]);
        }
    }
    return LT_OK;
}

bool action_is_takes(const char *root)
{
    return dexycb_kind.probe(root);
}

lt_status action_open_takes(lt_arena *arena, const char *root, const lt_hand_model *hand, action_set *out)
{
    static const char *const splits[] = { "train", "val", "test" };
    action_set s = { .root = root, .no_body = true, .difficulty = NAN };
    takes all = { .n = 0 };
    lt_status st = LT_OK;

    for (size_t i = 0; i < LT_COUNT(splits) && !st; i++)
        st = gather(arena, root, splits[i], hand, &all);
    if (!st)
        measure(&all, &s);
    if (!st && !s.n)
        st = lt_error(LT_EINVAL, "%s: in none of its %zu takes a hand touches an object that leaves its place", root,
                      all.n);
    st = st ? st : fill(arena, &all, &s);
    s.synthetic = all.synthetic;
    if (!st)
        *out = s;
    return st;
}
