/* SPDX-License-Identifier: Apache-2.0 */
#include "models/action/skeleton.h"

#include "libtensor/base/arena.h"

#include <math.h>

enum { CENTRE = 7, CUBOID = 21, OBJECT = 29, MOST_NODES = SKELETON_BODY };

typedef struct { int a, b; } bone;

/* The body: pelvis, hips, knees, ankles, neck, shoulders, elbows, wrists, feet, head; fingers follow by rule. */
static const bone body_bones[] = {
    { 0, 1 }, { 0, 2 }, { 1, 3 }, { 2, 4 }, { 3, 5 }, { 4, 6 }, { 5, 14 }, { 5, 15 }, { 5, 16 }, { 6, 17 }, { 6, 18 },
    { 6, 19 }, { 0, 7 }, { 7, 8 }, { 7, 9 }, { 8, 10 }, { 9, 11 }, { 10, 12 }, { 11, 13 }, { 7, 24 }, { 24, 22 },
    { 24, 23 }, { 22, 20 }, { 23, 21 },
};

typedef struct {
    int nodes, n, degree[MOST_NODES];
    bone bone[2 * MOST_NODES];
} skeleton;

static void add_bone(skeleton *s, int a, int b)
{
    s->bone[s->n++] = (bone){ a, b };
    s->degree[a]++;
    s->degree[b]++;
}

/* Five fingers of four joints each, base to tip, from `first` on */
static void add_fingers(skeleton *s, int wrist, int first)
{
    for (int i = 0; i < 20; i++)
        add_bone(s, i % 4 ? first + i - 1 : wrist, first + i);
}

/* Steps from the centre; the body is a tree. */
static void measure(const skeleton *s, int distance[MOST_NODES])
{
    for (int v = 0; v < s->nodes; v++)
        distance[v] = v == CENTRE ? 0 : s->nodes;
    for (int round = 0; round < s->nodes; round++)
        for (int i = 0; i < s->n; i++) {
            const bone b = s->bone[i];

            distance[b.a] = distance[b.b] + 1 < distance[b.a] ? distance[b.b] + 1 : distance[b.a];
            distance[b.b] = distance[b.a] + 1 < distance[b.b] ? distance[b.a] + 1 : distance[b.b];
        }
}

/* The other end of a bone; -1: it does not end at that node */
static int neighbour(const skeleton *s, int i, int node)
{
    return s->bone[i].a == node ? s->bone[i].b : s->bone[i].b == node ? s->bone[i].a : -1;
}

/* Room for a link of each node with itself, and for two of each bone */
static const lt_adjacency *adjacency_new(lt_arena *arena, const skeleton *s, int subsets, lt_link **link)
{
    lt_adjacency *a = lt_arena_alloc(arena, sizeof(*a));

    *link = lt_arena_array(arena, (size_t)(s->nodes + 2 * s->n), sizeof(**link));
    if (!a || !*link)
        return NULL;
    *a = (lt_adjacency){ .nodes = s->nodes, .subsets = subsets, .n = s->nodes + 2 * s->n, .link = *link };
    return a;
}

/* What comes in along a bone. With distances the body's: outwards and inwards are subsets of their own, and a node
 * takes the mean of itself and its neighbours. Without them one subset, where the degrees of both ends count. */
static lt_link link_along(const skeleton *s, const int *distance, int from, int to)
{
    if (distance)
        return (lt_link){ distance[from] >= distance[to] ? 1 : 2, from, to, 1.0 / (1 + s->degree[to]) };
    return (lt_link){ 0, from, to, 1 / sqrt((1.0 + s->degree[from]) * (1 + s->degree[to])) };
}

static void link_nodes(const skeleton *s, const int *distance, lt_link *link)
{
    for (int to = 0; to < s->nodes; to++) {
        *link++ = (lt_link){ 0, to, to, 1.0 / (1 + s->degree[to]) };
        for (int i = 0; i < s->n; i++) {
            const int from = neighbour(s, i, to);

            if (from >= 0)
                *link++ = link_along(s, distance, from, to);
        }
    }
}

const lt_adjacency *skeleton_body(lt_arena *arena)
{
    skeleton s = { .nodes = SKELETON_BODY };
    int distance[MOST_NODES];
    const lt_adjacency *a;
    lt_link *link;

    for (size_t i = 0; i < LT_COUNT(body_bones); i++)
        add_bone(&s, body_bones[i].a, body_bones[i].b);
    add_fingers(&s, 12, 25);
    add_fingers(&s, 13, 45);
    measure(&s, distance);
    a = adjacency_new(arena, &s, SKELETON_SUBSETS, &link);
    if (!a)
        return NULL;
    link_nodes(&s, distance, link);
    return a;
}

/* The corners are numbered x fastest: an edge changes one bit of a corner's number. */
const lt_adjacency *skeleton_hand_object(lt_arena *arena)
{
    skeleton s = { .nodes = SKELETON_HAND_OBJECT };
    const lt_adjacency *a;
    lt_link *link;

    add_fingers(&s, 0, 1);
    for (int i = 0; i < 8; i++) {
        for (int bit = 1; bit < 8; bit *= 2)
            if (!(i & bit))
                add_bone(&s, CUBOID + i, CUBOID + (i | bit));
        add_bone(&s, OBJECT, CUBOID + i);
    }
    add_bone(&s, OBJECT, 0);
    for (int finger = 1; finger <= 5; finger++)
        add_bone(&s, OBJECT, 4 * finger);
    a = adjacency_new(arena, &s, 1, &link);
    if (!a)
        return NULL;
    link_nodes(&s, NULL, link);
    return a;
}
