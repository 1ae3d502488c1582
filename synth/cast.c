/* SPDX-License-Identifier: Apache-2.0 */
/* Presets, and dealing subjects and objects to takes. */
#include "synth/cast.h"

#include "assets/ycb/objects.h"

#include <stdio.h>
#include <string.h>

enum { MAX_FRAMES = 200 };          /* of a sequence */

/* Numbers of training subjects and training objects have no common divisor, so that dealing both in turn
 * comes by every pair, where there are takes enough. In pretrain every take has a subject of its own; the jug, which is
 * taken by its handle alone, comes twice as often as others: else hardly a hand would close around a thin thing. */
typedef struct {
    const char *name;
    int train_subjects, new_subjects;
    int train_takes, evaluation_takes;
    int cameras, frames, rounds;
    int evaluation_frames;          /* of a sequence; 0: as many as in training */
    bool hogs;
    int train_object[9], evaluation_object[4];      /* ends with 0 */
} preset;

static const preset presets[] = {
    [SYNTH_TINY] = { "tiny", 2, 0, 4, 2, 1, 16, 1, 0, false, { 5, 9, 12 }, { 5, 9, 12 } },
    [SYNTH_SMALL] = { "small", 3, 1, 38, 10, 1, 48, 24, 0, false, { 2, 5, 9, 12, 14 }, { 5, 9, 12, 11 } },
    [SYNTH_DEMO] = { "demo", 3, 0, 142, 9, 1, 16, 8, 0, false, { 5, 9, 12, 14 }, { 5, 9, 12 } },
    [SYNTH_PRETRAIN] = { "pretrain", 240, 2, 240, 6, 1, 48, 48, 0, false,
                         { 2, SYNTH_JUG, 3, 5, 14, 9, 12, SYNTH_JUG, 15 }, { 5, 9, 12 } },
    [SYNTH_DEFAULT] = { "default", 8, 2, 87, 13, 2, 70, 1, 0, false,
                        { 2, 3, 5, 9, 10, 12, 14, 15, 17 }, { 5, 9, 12, 11 } },
    [SYNTH_HOGS] = { "hogs", 2, 0, 24, 8, 1, 83, 1, 50, true, { 5, 9, 12, 14 }, { 5, 9, 12, 14 } },
    [SYNTH_DETECT] = { .name = "detect" },          /* no takes: synth/detect, synth/track, synth/actions */
    [SYNTH_TRACK] = { .name = "track" },
    [SYNTH_ACTIONS] = { .name = "actions" },
    [SYNTH_BODY] = { .name = "body" },
    [SYNTH_TURNTABLE] = { .name = "turntable" },
    [SYNTH_WORLD] = { .name = "world" },
};

static const struct { int id; const char *letters; } initials[] = {
    { 2, "CB" }, { 3, "SB" }, { 5, "MB" }, { 9, "PM" }, { 10, "BA" }, { 11, "PB" }, { 12, "BC" },
    { 14, "MU" }, { 15, "PD" }, { 17, "SC" }, { SYNTH_JUG, "JU" },
};

lt_status synth_parse_preset(const char *name, synth_preset *out)
{
    for (size_t i = 0; i < LT_COUNT(presets); i++)
        if (!strcmp(name, presets[i].name)) {
            *out = (synth_preset)i;
            return LT_OK;
        }
    return lt_error(LT_EINVAL, "no preset \"%s\": tiny, small, demo, pretrain, default, hogs, detect, track, actions, "
                    "body, turntable or world", name);
}

const char *synth_preset_name(synth_preset which)
{
    return presets[which].name;
}

static int count(const int *list, int most)
{
    int n = 0;

    while (n < most && list[n])
        n++;
    return n;
}

static const char *letters_of(int object)
{
    for (size_t i = 0; i < LT_COUNT(initials); i++)
        if (initials[i].id == object)
            return initials[i].letters;
    return "XX";
}

static void add_object(synth_cast *c, int id)
{
    for (int i = 0; i < c->n_objects; i++)
        if (c->object[i] == id)
            return;
    c->object[c->n_objects++] = id;
}

static void add_take(synth_cast *c, int subject, int object, bool evaluation)
{
    synth_take *t = &c->take[c->n_takes];
    int before = 0;

    for (int i = 0; i < c->n_takes; i++)
        before += c->take[i].subject == subject && c->take[i].object == object;
    *t = (synth_take){ .subject = subject, .object = object, .evaluation = evaluation };
    snprintf(t->base, sizeof(t->base), "SYN%d%s%d", subject, letters_of(object), before);
    add_object(c, object);
    c->n_takes++;
}

/* Every third take of the evaluation has a new subject, where there are any. */
static int evaluation_subject(const preset *p, int k)
{
    if (p->new_subjects && k % 3 == 0)
        return p->train_subjects + k / 3 % p->new_subjects;
    return (p->train_takes + k) % p->train_subjects;
}

/* Subjects and objects of hogs have a common divisor: a cycle of both begins with the next subject. */
static int every_pair(const preset *p, int k, int n_objects)
{
    return (k + k / n_objects) % p->train_subjects;
}

static lt_status deal_frames(const preset *p, int frames, synth_cast *c)
{
    const int sequences = c->n_takes * c->n_cameras, all = frames ? frames : p->frames * sequences;
    const int each = all / sequences, more = all % sequences / c->n_cameras;

    if (each < 1 || each + 1 > MAX_FRAMES)
        return lt_error(LT_EINVAL, "%d frames: preset %s has %d sequences, and each needs 1 to %d frames",
                        all, p->name, sequences, MAX_FRAMES - 1);
    for (int i = 0; i < c->n_takes; i++) {
        c->take[i].frames = frames || !p->evaluation_frames || !c->take[i].evaluation ? each + (i < more)
                                                                                     : p->evaluation_frames;
        c->take[i].rounds = lt_min_i64(p->rounds, c->take[i].frames);
    }
    return LT_OK;
}

lt_status synth_cast_plan(synth_preset which, int frames, synth_cast *out)
{
    const preset *p = &presets[which];
    const int n_train = count(p->train_object, 9), n_evaluation = count(p->evaluation_object, 4);

    *out = (synth_cast){ .n_subjects = p->train_subjects + p->new_subjects, .n_cameras = p->cameras,
                         .shrink = p->hogs ? 2 : 1, .hogs = p->hogs };
    for (int j = 0; j < p->train_takes; j++)
        add_take(out, p->hogs ? every_pair(p, j, n_train) : j % p->train_subjects, p->train_object[j % n_train],
                 false);
    for (int k = 0; k < p->evaluation_takes; k++)
        add_take(out, p->hogs ? every_pair(p, k, n_evaluation) : evaluation_subject(p, k),
                 p->evaluation_object[k % n_evaluation], true);
    return deal_frames(p, frames, out);
}
