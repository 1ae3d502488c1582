/* SPDX-License-Identifier: Apache-2.0 */
#include "data/dexycb/split.h"

#include <string.h>

/* Sets of small numbers as bits. */
typedef struct { unsigned subjects[3], cameras[3]; } sets;

#define BIT(i) (1u << (i))
#define ALL_SUBJECTS 0x3ffu
#define ALL_CAMERAS 0xffu

static const sets of_setup[4] = {
    { .subjects = { ALL_SUBJECTS, BIT(0) | BIT(1), ALL_SUBJECTS & ~(BIT(0) | BIT(1)) },
      .cameras = { ALL_CAMERAS, ALL_CAMERAS, ALL_CAMERAS } },
    { .subjects = { BIT(0) | BIT(1) | BIT(2) | BIT(3) | BIT(4) | BIT(5) | BIT(9), BIT(6), BIT(7) | BIT(8) },
      .cameras = { ALL_CAMERAS, ALL_CAMERAS, ALL_CAMERAS } },
    { .subjects = { ALL_SUBJECTS, ALL_SUBJECTS, ALL_SUBJECTS }, .cameras = { 0x3f, BIT(6), BIT(7) } },
    { .subjects = { ALL_SUBJECTS, ALL_SUBJECTS, ALL_SUBJECTS },
      .cameras = { ALL_CAMERAS, ALL_CAMERAS, ALL_CAMERAS } },
};

/* Object slots of five sequences each that s3 keeps for validation and test. */
static const unsigned s3_val = BIT(3) | BIT(19), s3_test = BIT(7) | BIT(11) | BIT(15);

static const char *const part_name[3] = { "train", "val", "test" };

lt_status dexycb_split_parse(const char *setup, const char *part, dexycb_split *out)
{
    dexycb_split s = { .setup = setup[0] == 's' && setup[1] && !setup[2] ? setup[1] - '0' : -1 };
    int p = 0;

    if (s.setup < 0 || s.setup > 3)
        return lt_error(LT_EINVAL, "DexYCB has no setup \"%s\": s0 (all seen), s1 (unseen subjects), s2 (unseen "
                        "views) or s3 (unseen objects)", setup);
    if (!strcmp(part, "evaluation"))
        part = "test";
    while (p < 3 && strcmp(part, part_name[p]))
        p++;
    if (p == 3)
        return lt_error(LT_EINVAL, "DexYCB has no split \"%s\": train, val or test", part);
    s.part = p;
    *out = s;
    return LT_OK;
}

const char *dexycb_split_name(dexycb_split s)
{
    return part_name[s.part];
}

static bool in(unsigned set, int i)
{
    return i >= 0 && i < 32 && (set & BIT(i));
}

bool dexycb_has_subject(dexycb_split s, int subject)
{
    return in(of_setup[s.setup].subjects[s.part], subject);
}

bool dexycb_has_camera(dexycb_split s, int camera)
{
    return in(of_setup[s.setup].cameras[s.part], camera);
}

bool dexycb_has_sequence(dexycb_split s, int sequence)
{
    const int object = sequence / 5, trial = sequence % 5;

    if (s.setup == 0)
        return (trial == 4) == (s.part != DEXYCB_TRAIN);
    if (s.setup < 3)
        return true;
    if (s.part == DEXYCB_TRAIN)
        return !in(s3_val | s3_test, object);
    return in(s.part == DEXYCB_VAL ? s3_val : s3_test, object);
}
