/* SPDX-License-Identifier: Apache-2.0 */
/* The memory of a batch: which arrays it has, and how much of each is a slot's. */
#include "data/hand_object.h"

#include "libtensor/geometry/box21.h"

#include <string.h>

void hand_object_batch_free(hand_object_batch *b)
{
    if (!b)
        return;
    lt_arena_free(b->memory);
    lt_release(b);
}

/* Memory for per numbers of size bytes in each slot; remembers that one was refused. */
static void *slots(hand_object_batch *b, size_t per, size_t size, bool *ok)
{
    void *p = lt_arena_array(b->memory, (size_t)b->capacity * per, size);

    *ok = *ok && p;
    return p;
}

/* The arrays that a sample fills, numbers of each; all but the scratch and what is not float. */
typedef struct { float **p; size_t per; } field;
enum { FIELDS = 18 };

static void fields_of(hand_object_batch *b, field out[FIELDS])
{
    const size_t pixels = (size_t)b->size * (size_t)b->size, cells = (size_t)b->cells * (size_t)b->cells;
    const field all[FIELDS] = {
        { &b->image, 3 * pixels }, { &b->depth, pixels }, { &b->metres, pixels },
        { &b->mask, cells }, { &b->weight, 1 }, { &b->object_weight, 1 },
        { &b->hand_box, 4 }, { &b->joints2d, 2 * LT_HAND_KEYPOINTS }, { &b->rotation, 9 * LT_HAND_JOINTS },
        { &b->beta, LT_HAND_BETAS }, { &b->joints, 3 * LT_HAND_KEYPOINTS }, { &b->wrist, 3 },
        { &b->object_box, 4 }, { &b->points2d, 2 * LT_BOX_POINTS }, { &b->R, 9 }, { &b->t, 3 },
        { &b->affine, 6 }, { &b->K, 9 },
    };

    memcpy(out, all, sizeof(all));
}

static bool allocate(hand_object_batch *b)
{
    field f[FIELDS];
    bool ok = true;

    fields_of(b, f);
    for (int k = 0; k < FIELDS; k++)
        *f[k].p = slots(b, f[k].per, sizeof(float), &ok);
    b->object = slots(b, 1, sizeof(*b->object), &ok);
    b->flags = slots(b, 1, sizeof(*b->flags), &ok);
    b->vertices = slots(b, 1, sizeof(*b->vertices), &ok);
    b->index = slots(b, 1, sizeof(*b->index), &ok);
    b->scratch = slots(b, (size_t)b->size * (size_t)b->size, sizeof(float), &ok);
    return ok;
}

hand_object_batch *hand_object_batch_new(int capacity, int size, int cells)
{
    hand_object_batch *b = lt_alloc(sizeof(*b));

    if (!b)
        return NULL;
    *b = (hand_object_batch){ .capacity = capacity, .size = size, .cells = cells };
    b->memory = lt_arena_new();
    if (!b->memory || !allocate(b)) {
        hand_object_batch_free(b);
        return NULL;
    }
    return b;
}

hand_object_batch hand_object_batch_slot(const hand_object_batch *b, int slot)
{
    const size_t i = (size_t)slot;
    hand_object_batch one = *b;
    field f[FIELDS];

    fields_of(&one, f);
    for (int k = 0; k < FIELDS; k++)
        *f[k].p += i * f[k].per;
    one.object += i;
    one.flags += i;
    one.vertices += i;
    one.index += i;
    one.count = one.capacity = 1;
    one.memory = NULL;
    return one;
}

void hand_object_batch_clear(hand_object_batch *b, int slot, int64_t index)
{
    const size_t i = (size_t)slot;
    field f[FIELDS];

    fields_of(b, f);
    for (int k = 0; k < FIELDS; k++)
        memset(*f[k].p + i * f[k].per, 0, f[k].per * sizeof(float));
    b->object[i] = -1;
    b->flags[i] = 0;
    b->vertices[i] = NULL;
    b->index[i] = index;
}
