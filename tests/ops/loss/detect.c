/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The detector's assigner against NumPy's tables of all cells and objects, and its losses against torch: images of 64
 * pixels with 8 x 8, 4 x 4 and 2 x 2 cells, prototypes of 16 x 16.
 */
#include "models/detect/losses.h"
#include "tests/ops/suite.h"

#include <string.h>

enum { B = 2, G = 3, NC = 3, CELLS = 84, BINS = 64, SIDE = 16, WORDS = SIDE * SIDE / 32 };

static lt_tensor *channels(lt_tensor *x, int64_t first, int64_t n)
{
    return lt_slice(x, 1, first, n);
}

/* in[0 .. 2]: box and cls of a level, joined; objects; what the result is multiplied with */
static lt_tensor *assigned(lt_tensor **in)
{
    detect_maps maps = { .proto = NULL };

    for (int i = 0; i < DETECT_LEVELS; i++) {
        maps.box[i] = channels(in[i], 0, BINS);
        maps.cls[i] = channels(in[i], BINS, NC);
    }
    return lt_mul(detect_assign(&maps, in[3]), in[4]);
}

static lt_tensor *unlike(lt_tensor **in)
{
    const detect_maps maps = { .box = { in[0], in[0], in[0] }, .cls = { in[1], in[1], in[2] } };

    return detect_assign(&maps, in[3]);
}

static lt_tensor *class_loss(lt_tensor **in)
{
    return detect_class_loss(&(detect_maps){ .cls = { in[0], in[1], in[2] } }, in[3], in[4]);
}

static lt_tensor *box_loss(lt_tensor **in)
{
    return detect_box_loss(&(detect_maps){ .box = { in[0], in[1], in[2] } }, in[3], in[4]);
}

/* Bit p of every mask is set where p % 3 is 0 or the object's number is 1. */
static lt_tensor *masks(lt_graph *g)
{
    int32_t word[B][G][WORDS] = { 0 };

    for (int b = 0; b < B; b++)
        for (int k = 0; k < G; k++)
            for (int p = 0; p < SIDE * SIDE; p++)
                if (p % 3 == 0 || k == 1)
                    word[b][k][p / 32] = (int32_t)((uint32_t)word[b][k][p / 32] | UINT32_C(1) << p % 32);
    return lt_constant(g, LT_I32, LT_SHAPE(B, G, WORDS), word);
}

static lt_tensor *mask_loss(lt_tensor **in)
{
    const detect_maps maps = { .mask = { in[0], in[1], in[2] }, .proto = in[3] };

    return detect_mask_loss(&maps, in[4], masks(in[0]->graph), in[5]);
}

/* The first image has two objects, the second of which has no known mask, the second image has one and no objects. */
static void fill_objects(lt_real *v)
{
    static const lt_real rows[B * G * OBJECT_NUMBERS] = {
        2, 5, 9, 40.5, 33, 1,   0, 30, 2.5, 61, 50, 0,      -1, 0, 0, 0, 0, 0,
        -1, 0, 0, 0, 0, 0,      1, 11, 20, 43, 60, 1,       -1, 0, 0, 0, 0, 0,
    };

    memcpy(v, rows, sizeof(rows));
}

/* A few cells of each level, whatever their centres are */
static void fill_assigned(lt_real *v, lt_rng *r)
{
    for (int i = 0; i < B * CELLS; i++) {
        const bool has = i % 7 == 3, second = i >= CELLS;

        v[i * ASSIGNED_NUMBERS + ASSIGNED_OBJECT] = !has ? -1 : second ? 1 : i % 2;
        v[i * ASSIGNED_NUMBERS + ASSIGNED_SCORE] = has ? (lt_real)lt_rng_range(r, 0.1, 0.9) : 0;
        v[i * ASSIGNED_NUMBERS + ASSIGNED_ALPHA] = has ? (lt_real)lt_rng_range(r, 0.1, 0.5) : 0;
    }
}

static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    const lt_shape *s = &c->in[input].shape;

    if (s->rank == 3 && s->dim[2] == OBJECT_NUMBERS)
        fill_objects(v);
    else if (s->rank == 3 && c->in[input].role == OP_CONSTANT)
        fill_assigned(v, r);
    else
        fill_clear_of_zero(c, input, v, n, r);
}

#define MAPS(M, channels) M(B, channels, 8, 8), M(B, channels, 4, 4), M(B, channels, 2, 2)
#define OBJECTS C(B, G, OBJECT_NUMBERS)
#define ASSIGNED C(B, CELLS, ASSIGNED_NUMBERS)

static const op_case assign_cases[] = {
    { "assigned", assigned, .in = { MAPS(C, BINS + NC), OBJECTS, S(B, CELLS, ASSIGNED_NUMBERS) }, .fill = fill },
};
static const op_case class_cases[] = {
    { "classes", class_loss, .in = { MAPS(S, NC), OBJECTS, ASSIGNED }, .fill = fill },
};
static const op_case box_cases[] = { { "boxes", box_loss, .in = { MAPS(S, BINS), OBJECTS, ASSIGNED }, .fill = fill } };
static const op_case mask_cases[] = {
    { "masks", mask_loss, .in = { MAPS(S, 32), S(B, 32, SIDE, SIDE), OBJECTS, ASSIGNED }, .fill = fill },
};

static const op_bad_case assign_bad[] = {
    { unlike, { S(2, 60, 8, 8), S(2, 3, 8, 8), S(2, 3, 8, 8), OBJECTS },
      "detect_assign: boxes of level 0 has 2 images and 60 channels, want 2 and 64" },
    { unlike, { S(2, 64, 8, 8), S(2, 3, 8, 8), S(2, 4, 8, 8), OBJECTS },
      "detect_assign: classes is (2, 4, 8, 8), want (2, 3, 8, 8)" },
    { unlike, { S(2, 64, 8, 8), S(2, 3, 8, 8), S(2, 3, 8, 8), C(2, 3, 5) },
      "detect_assign: objects is (2, 3, 5), want (2, 3, 6)" },
};
static const op_bad_case class_bad[] = {
    { class_loss, { MAPS(S, NC), OBJECTS, C(B, 83, 3) }, "detect_class_loss: assigned is (2, 83, 3), want (2, 84, 3)" },
};
static const op_bad_case box_bad[] = {
    { box_loss, { MAPS(S, 32), OBJECTS, ASSIGNED },
      "detect_box_loss: boxes of level 0 has 2 images and 32 channels, want 2 and 64" },
};
static const op_bad_case mask_bad[] = {
    { mask_loss, { MAPS(S, 32), S(B, 31, SIDE, SIDE), OBJECTS, ASSIGNED },
      "detect_mask_loss: prototypes is (2, 31, 16, 16), want (2, 32, 16, 16)" },
    { mask_loss, { MAPS(S, 32), S(B, 32, 8, 8), OBJECTS, ASSIGNED },
      "detect_mask_loss: masks is (2, 3, 8), want (2, 3, 2)" },
};

const op_suite detect_assign_suite = { "detect_assign", CASES(assign_cases), BAD(assign_bad) };
const op_suite detect_class_loss_suite = { "detect_class_loss", CASES(class_cases), BAD(class_bad) };
const op_suite detect_box_loss_suite = { "detect_box_loss", CASES(box_cases), BAD(box_bad) };
const op_suite detect_mask_loss_suite = { "detect_mask_loss", CASES(mask_cases), BAD(mask_bad) };
