/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Vertex ids: those that datasets name lie where they expect them, the rest are grouped by part.
 */
#include "assets/hand/internal.h"

#include <stdlib.h>
#include <string.h>

const int synth_hand_wrist_loop[SYNTH_HAND_WRIST_LOOP] = {
    92, 38, 122, 118, 117, 119, 120, 108, 79, 78, 121, 214, 215, 279, 239, 234,
};

const int32_t synth_hand_cap[SYNTH_HAND_CAP_FACES][3] = {
    { 92, 38, 122 }, { 234, 92, 122 }, { 239, 234, 122 }, { 279, 239, 122 }, { 215, 279, 122 },
    { 215, 122, 118 }, { 215, 118, 117 }, { 215, 117, 119 }, { 215, 119, 120 }, { 215, 120, 108 },
    { 215, 108, 79 }, { 215, 79, 78 }, { 215, 78, 121 }, { 215, 121, 214 },
};

/* Places on a finger tip, in radii of the tip: back along the bone, towards the nail, sideways. */
static const vec3 tip_place[5] = {
    { 0, 0, 0 }, { -0.2, -0.1, 0.5 }, { -0.2, -0.45, 0 }, { -0.2, -0.1, -0.5 }, { -0.9, -0.9, 0 }
};
static const int tip_id[DIGITS][5] = {          /* -1: fewer conventions name this digit */
    [DIGIT_INDEX] = { 320, 317, 353, 333, -1 }, [DIGIT_MIDDLE] = { 443, 444, 442, 445, -1 },
    [DIGIT_LITTLE] = { 671, 673, 694, 657, 672 }, [DIGIT_RING] = { 554, 556, 576, 555, -1 },
    [DIGIT_THUMB] = { 744, 745, 728, -1, -1 },
};

typedef struct {
    const surface_mesh *m;
    int32_t to[LT_HAND_VERTICES];   /* new id of each vertex, -1 while it has none */
    bool taken[LT_HAND_VERTICES];
} numbering;

static void give(numbering *n, int32_t vertex, int id)
{
    n->to[vertex] = id;
    n->taken[id] = true;
}

static int32_t nearest_free(const numbering *n, vec3 p)
{
    int32_t best = -1;

    for (int32_t v = 0; v < n->m->n_vertices; v++)
        if (n->to[v] < 0 && !n->m->loop[v]
            && (best < 0 || dist(n->m->vertex[v], p) < dist(n->m->vertex[best], p)))
            best = v;
    return best;
}

static int32_t next_on_border(const surface_mesh *m, int32_t v)
{
    for (int f = 0; f < m->n_faces; f++)        /* the cap runs against the faces: v comes second */
        for (int k = 0; k < 3; k++) {
            const int32_t a = m->face[f][k], b = m->face[f][(k + 1) % 3];
            int others = 0;

            if (b != v || !m->loop[a] || !m->loop[b])
                continue;
            for (int g = 0; g < m->n_faces; g++)
                for (int j = 0; j < 3; j++)
                    others += m->face[g][j] == b && m->face[g][(j + 1) % 3] == a;
            if (!others)
                return a;
        }
    return v;
}

static void number_wrist(numbering *n)
{
    int32_t v = -1;

    for (int32_t u = 0; u < n->m->n_vertices; u++)      /* start at the thumb's side */
        if (n->m->loop[u] && (v < 0 || n->m->vertex[u].z > n->m->vertex[v].z))
            v = u;
    for (int i = 0; i < WRIST_LOOP; i++, v = next_on_border(n->m, v))
        give(n, v, synth_hand_wrist_loop[i]);
}

static void number_tips(const hand_skeleton *s, numbering *n)
{
    for (int d = 0; d < DIGITS; d++) {
        const vec3 bone = s->bone[d][2], up = unit(reject(s->dorsal[d], bone)),
                   side = cross(up, bone);

        for (int i = 0; i < 5; i++) {
            const vec3 q = scale(tip_place[i], s->radius[d][3]);
            const vec3 p =
                add(s->joint[d][3], add(scale(bone, q.x), add(scale(up, q.y), scale(side, q.z))));

            if (tip_id[d][i] >= 0)
                give(n, nearest_free(n, p), tip_id[d][i]);
        }
    }
}

static void number_palm(const hand_skeleton *s, numbering *n)
{
    const vec3 middle = mix(s->wrist, s->joint[DIGIT_MIDDLE][0], 0.65);

    give(n, nearest_free(n, add(middle, vec(0, -15, 0))), 95);
    give(n, nearest_free(n, add(middle, vec(0, 12, 0))), 22);
}

typedef struct { int rank; double along; int32_t vertex; } place;

static int by_place(const void *a, const void *b)
{
    const place *p = a, *q = b;

    if (p->rank != q->rank)
        return p->rank - q->rank;
    return p->along != q->along ? (p->along < q->along ? -1 : 1) : p->vertex - q->vertex;
}

/* Palm, index, middle, ring, little, thumb; base to tip within each. */
static void number_rest(const hand_skeleton *s, numbering *n)
{
    static const int digit_rank[DIGITS] = { 1, 2, 4, 3, 5 };
    place order[LT_HAND_VERTICES];
    int count = 0, id = 0;

    for (int32_t v = 0; v < n->m->n_vertices; v++) {
        double w[LT_HAND_JOINTS];
        int part = 0;

        if (n->to[v] >= 0)
            continue;
        hand_weights_at(s, n->m->vertex[v], w);
        for (int j = 1; j < LT_HAND_JOINTS; j++)
            part = w[j] > w[part] ? j : part;
        order[count++] = (place){ part ? 3 * digit_rank[(part - 1) / 3] + (part - 1) % 3 : 0,
                                  -n->m->vertex[v].x, v };
    }
    qsort(order, (size_t)count, sizeof(*order), by_place);
    for (int i = 0; i < count; i++) {
        while (n->taken[id])
            id++;
        give(n, order[i].vertex, id);
    }
}

static int by_corners(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(int32_t[3]));
}

/* Move vertices to their ids; each face starts at its lowest corner, faces in the order of corners. */
static void apply(const numbering *n, surface_mesh *m)
{
    vec3 vertex[LT_HAND_VERTICES];
    uint8_t loop[LT_HAND_VERTICES];

    for (int v = 0; v < m->n_vertices; v++) {
        vertex[n->to[v]] = m->vertex[v];
        loop[n->to[v]] = m->loop[v];
    }
    memcpy(m->vertex, vertex, sizeof(vertex));
    memcpy(m->loop, loop, sizeof(loop));
    for (int f = 0; f < m->n_faces; f++) {
        const int32_t *old = m->face[f];
        const int32_t c[3] = { n->to[old[0]], n->to[old[1]], n->to[old[2]] };
        const int k = c[0] < c[1] && c[0] < c[2] ? 0 : c[1] < c[2] ? 1 : 2;

        for (int i = 0; i < 3; i++)
            m->face[f][i] = c[(k + i) % 3];
    }
    qsort(m->face, (size_t)m->n_faces, sizeof(*m->face), by_corners);
}

void hand_number(const hand_skeleton *s, surface_mesh *m)
{
    numbering n = { .m = m };

    memset(n.to, -1, sizeof(n.to));
    number_wrist(&n);
    number_tips(s, &n);
    number_palm(s, &n);
    number_rest(s, &n);
    apply(&n, m);
}
