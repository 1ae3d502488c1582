/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Both halves, hands and eyes in one skin. Ids that datasets and networks name are given first; the eyes and the hands
 * are in rows of their own; the rest counts down from the crown.
 */
#include "assets/body/internal.h"

#include "assets/hand/hand.h"

#include <stdlib.h>
#include <string.h>

enum { TIPS = 5, RIGHT_EYE = 9929, LEFT_EYE = 9383, LEFT_PUPIL = 9448 };

static const int hand_tip[TIPS] = { 744, 320, 443, 554, 671 };          /* of a hand model, thumb first */
static const int body_tip[2][TIPS] = { { 5361, 4933, 5058, 5169, 5286 }, { 8079, 7669, 7794, 7905, 8022 } };
static const int hand_first[2] = { 4610, 7346 };

typedef struct {
    const body_skeleton *s;
    const surface_mesh *half;
    body_skin *out;
    bool taken[V];
    int next;                                   /* free ids begin here, or later */
    int32_t (*id)[2];                           /* of a half's vertex: left, right; -1: none yet */
    int n_faces;
} join;

/* ---- ids --------------------------------------------------------------------------------------------- */

static int take_next(join *j)
{
    while (j->taken[j->next])
        j->next++;
    j->taken[j->next] = true;
    return j->next;
}

static void give(join *j, int v, int right, int left)
{
    j->id[v][1] = right;
    j->id[v][0] = left < 0 ? right : left;
    j->taken[right] = true;
    if (left >= 0)
        j->taken[left] = true;
}

/* The nearest vertex goes there. */
static void give_landmarks(join *j, surface_mesh *half)
{
    const surface_skin skin = body_shape_skin(j->s);

    for (int k = 0; k < LANDMARKS; k++) {
        const int rim = k == 0 ? RIM_MIDDLE : 0;
        const vec3 p = skin.snap(skin.ctx, j->s->landmark[k], rim);
        int best = -1;

        for (int v = 0; v < half->n_vertices; v++)
            if (half->loop[v] == rim && j->id[v][1] < 0 &&
                (best < 0 || dist(half->vertex[v], p) < dist(half->vertex[best], p)))
                best = v;
        half->vertex[best] = p;
        give(j, best, body_landmark_id[k][0], body_landmark_id[k][1]);
    }
}

static void give_hands(join *j, const int wrist[WRIST_EDGES])
{
    for (int side = 0; side < 2; side++) {
        int32_t *hand = j->out->hand[side];

        memset(hand, -1, sizeof(j->out->hand[side]));
        for (int k = 0; k < TIPS; k++)
            hand[hand_tip[k]] = body_tip[side][k];
        for (int k = 0; k < TIPS; k++)
            j->taken[body_tip[side][k]] = true;
        j->next = hand_first[side];
        for (int v = 0; v < HAND; v++)
            if (hand[v] < 0)
                hand[v] = take_next(j);
    }
    for (int i = 0; i < WRIST_EDGES; i++) {
        const int v = synth_hand_wrist_loop[i];

        give(j, wrist[i], j->out->hand[1][v], j->out->hand[0][v]);
    }
}

typedef struct { double y; int vertex; } level;

static int from_above(const void *a, const void *b)
{
    const level *p = a, *q = b;

    return p->y != q->y ? (p->y > q->y ? -1 : 1) : p->vertex - q->vertex;
}

static lt_status give_rest(lt_arena *arena, join *j)
{
    const int n = j->half->n_vertices;
    level *list = lt_arena_array(arena, (size_t)n, sizeof(*list));

    if (!list)
        return lt_error(LT_ENOMEM, "synthetic body: no memory for its ids");
    for (int v = 0; v < n; v++)
        list[v] = (level){ j->half->vertex[v].y, v };
    qsort(list, (size_t)n, sizeof(*list), from_above);
    j->next = 0;
    for (int i = 0; i < n; i++) {
        const int v = list[i].vertex;

        if (j->id[v][1] < 0) {
            const int right = take_next(j);
            give(j, v, right, j->half->loop[v] == RIM_MIDDLE ? -1 : take_next(j));
        }
    }
    return LT_OK;
}

/* ---- vertices and faces ------------------------------------------------------------------------------ */

static void put(join *j, int id, vec3 p, body_source source, int row, bool left)
{
    j->out->vertex[id] = left ? body_mirror(p) : p;
    j->out->source[id] = (uint8_t)source;
    j->out->row[id] = (int16_t)row;
    j->out->left[id] = left;
}

/* A face of the right side, and its mirror image. */
static void add_faces(join *j, const int right[3], const int left[3])
{
    int32_t (*f)[3] = j->out->face + j->n_faces;

    for (int k = 0; k < 3; k++) {
        f[0][k] = right[k];
        f[1][k] = left[2 - k];
    }
    j->n_faces += 2;
}

static void add_half(join *j)
{
    for (int v = 0; v < j->half->n_vertices; v++)
        for (int side = 1; side >= (j->half->loop[v] == RIM_MIDDLE); side--)
            put(j, j->id[v][side], j->half->vertex[v], FROM_SKIN, 0, side == 0);
    for (int f = 0; f < j->half->n_faces; f++) {
        int id[2][3];

        for (int k = 0; k < 3; k++)
            for (int side = 0; side < 2; side++)
                id[side][k] = j->id[j->half->face[f][k]][side];
        add_faces(j, id[1], id[0]);
    }
}

static void add_hands(join *j, const lt_hand_model *hand)
{
    for (int side = 0; side < 2; side++)
        for (int v = 0; v < HAND; v++) {
            const float *p = hand->v_template[v];

            put(j, j->out->hand[side][v], madd(j->s->hand, vec(p[0], p[1], p[2]), 1000), FROM_HAND, v, side == 0);
        }
    for (int f = 0; f < LT_HAND_FACES; f++) {
        int id[2][3];

        for (int k = 0; k < 3; k++)
            for (int side = 0; side < 2; side++)
                id[side][k] = j->out->hand[side][hand->faces[f][k]];
        add_faces(j, id[1], id[0]);
    }
}

/* Vertices of an eye go from its pupil back, ring by ring. The left pupil has another id than the first. */
static int eye_id(bool left, int i)
{
    const int pupil = LEFT_PUPIL - LEFT_EYE;

    return left ? LEFT_EYE + (i == 0 ? pupil : i == pupil ? 0 : i) : RIGHT_EYE + i;
}

static int ring_vertex(int ring, int i)
{
    if (ring == 0)
        return 0;
    return ring > EYE_RINGS ? EYE_VERTICES - 1 : 1 + (ring - 1) * EYE_AROUND + i % EYE_AROUND;
}

static void add_eye_face(join *j, int a, int b, int c)
{
    const int right[3] = { eye_id(false, a), eye_id(false, b), eye_id(false, c) };
    const int left[3] = { eye_id(true, a), eye_id(true, b), eye_id(true, c) };

    add_faces(j, right, left);
}

static void add_eyes(join *j)
{
    for (int ring = 0; ring <= EYE_RINGS + 1; ring++)
        for (int i = 0; i < (ring % (EYE_RINGS + 1) ? EYE_AROUND : 1); i++) {
            const double back = M_PI * ring / (EYE_RINGS + 1), turn = 2 * M_PI * i / EYE_AROUND;
            const vec3 out = vec(sin(back) * cos(turn), sin(back) * sin(turn), cos(back));

            for (int left = 0; left < 2; left++)
                put(j, eye_id(left, ring_vertex(ring, i)), madd(j->s->eye, out, j->s->eye_radius), FROM_EYE, 0, left);
        }
    for (int ring = 0; ring <= EYE_RINGS; ring++)
        for (int i = 0; i < EYE_AROUND; i++) {
            const int a = ring_vertex(ring, i), b = ring_vertex(ring + 1, i);
            const int c = ring_vertex(ring + 1, i + 1), d = ring_vertex(ring, i + 1);

            if (b != c)
                add_eye_face(j, a, b, c);
            if (a != d)
                add_eye_face(j, a, c, d);
        }
}

lt_status body_skin_join(lt_arena *arena, const body_skeleton *s, surface_mesh *half, const int wrist[WRIST_EDGES],
                         const lt_hand_model *hand, body_skin *out)
{
    join j = { .s = s, .half = half, .out = out,
               .id = lt_arena_array(arena, (size_t)half->n_vertices, sizeof(*j.id)) };
    lt_status st;

    if (!j.id)
        return lt_error(LT_ENOMEM, "synthetic body: no memory for its ids");
    memset(j.id, -1, (size_t)half->n_vertices * sizeof(*j.id));
    for (int i = 0; i < EYE_VERTICES; i++)
        j.taken[RIGHT_EYE + i] = j.taken[LEFT_EYE + i] = true;
    give_landmarks(&j, half);
    give_hands(&j, wrist);
    st = give_rest(arena, &j);
    if (st)
        return st;
    add_half(&j);
    add_hands(&j, hand);
    add_eyes(&j);
    return LT_OK;
}
