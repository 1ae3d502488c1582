/* SPDX-License-Identifier: Apache-2.0 */
/* Subjects and sequences as DexYCB counts them: five takes of each object, the fifth for evaluation. */
#include "synth/cast.h"

#include "libtensor/base/rng.h"

#include <stdio.h>
#include <string.h>

enum { TRIALS = 5, MAX_FRAMES = 200, OTHERS = 0x4f544852, FEWEST = 2 };

typedef struct {
    const char *name;
    int subjects, cameras, frames;
    int object[21];                 /* in the hand, by their slots; ends with 0 */
    int also[6];                    /* besides these, on the table; ends with 0 */
} preset;

static const preset presets[] = {
    [SYNTH_TINY] = { "tiny", 3, 2, 4, { 5, 9 }, { 2, 12, 14 } },
    [SYNTH_SMALL] = { "small", 4, 4, 8, { 2, 5, 9, 12, 14 }, { 3 } },
    [SYNTH_DEMO] = { "demo", 4, 2, 4, { 5, 9, 12, 14 }, { 2 } },
    [SYNTH_PRETRAIN] = { "pretrain", 8, 2, 12, { 2, 3, 5, 9, 12, 14, 15 }, { 10, 17 } },
    [SYNTH_DEFAULT] = { "default", 10, 8, 9,
                        { 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 20, 21 }, { 19 } },
};

static int count(const int *list, int most)
{
    int n = 0;

    while (n < most && list[n])
        n++;
    return n;
}

/* 2 to 4 different things for the table, none of them the one in the hand. */
static void deal_others(const synth_cast *c, uint64_t seed, int number, synth_take *t)
{
    lt_rng rng = lt_rng_make(seed, lt_rng_mix(OTHERS, (uint64_t)number));
    uint32_t order[21];
    const int most = FEWEST + (int)lt_rng_below(&rng, SYNTH_MAX_OTHERS - FEWEST + 1);

    lt_rng_permute(&rng, order, (uint32_t)c->n_objects);
    for (int i = 0; i < c->n_objects && t->n_others < most; i++)
        if (c->object[order[i]] != t->object)
            t->other[t->n_others++] = c->object[order[i]];
}

static void add_subject(const preset *p, int subject, int frames, uint64_t seed, synth_cast *c)
{
    const int n = count(p->object, 21);

    for (int i = 0; i < n * TRIALS; i++) {
        const int slot = i / TRIALS, trial = i % TRIALS;
        synth_take *t = &c->take[c->n_takes];
        *t = (synth_take){ .subject = subject, .object = p->object[slot], .frames = frames, .rounds = 1,
                           .evaluation = trial == TRIALS - 1, .left = (slot + trial + subject) % 2 };
        snprintf(t->base, sizeof(t->base), "202601%02d-subject-%02d/202601%02d_%06d", subject + 1, subject + 1,
                 subject + 1, 100000 + i);
        deal_others(c, seed, c->n_takes++, t);
    }
}

lt_status synth_cast_plan_dexycb(synth_preset which, int frames, uint64_t seed, synth_cast *out)
{
    const preset *p = &presets[which];
    const int objects = count(p->object, 21), also = count(p->also, 6);
    const int sequences = p->subjects * objects * TRIALS * p->cameras, each = frames ? frames / sequences : p->frames;

    if (each < 1 || each > MAX_FRAMES)
        return lt_error(LT_EINVAL, "%d frames: preset %s has %d views of its sequences, and each needs 1 to %d frames",
                        frames, p->name, sequences, MAX_FRAMES);
    *out = (synth_cast){ .shrink = 1, .n_subjects = p->subjects, .n_cameras = p->cameras, .n_objects = objects + also };
    memcpy(out->object, p->object, (size_t)objects * sizeof(int));
    memcpy(out->object + objects, p->also, (size_t)also * sizeof(int));
    for (int i = 0; i < p->subjects; i++)
        add_subject(p, i, each, seed, out);
    return LT_OK;
}
