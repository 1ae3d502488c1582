/* SPDX-License-Identifier: Apache-2.0 */
/* What is told of an image: in its JSON each time, to whoever watches where it is new. */
#include "pipeline/internal.h"

#include "libtensor/base/printable.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Names are part of the format: they stay. */
static const struct {
    const char *name;
    enum { CHANGES, IMAGES, ALWAYS } each;      /* said where it changes; of each image that it holds for, but of a film
                                                 * where it changes; of each */
    const char *otherwise;          /* what is said when it holds no longer; NULL: nothing */
} kinds[PREDICT_NOTES] = {
    [NOTE_TURNED] = { "turned", CHANGES, "upright as it is stored" },
    [NOTE_HAND_BOX] = { "hand-box-assumed", CHANGES, "its hand box is known" },
    [NOTE_OBJECT_BOX] = { "object-box-assumed", CHANGES, "its object box is known" },
    [NOTE_CAMERA] = { "camera-assumed", CHANGES, "the camera is given" },
    [NOTE_CAMERA_SCALED] = { "camera-scaled", CHANGES, NULL },
    [NOTE_CAMERA_DOUBTFUL] = { "camera-doubtful", CHANGES, NULL },
    [NOTE_UNDISTORTED] = { "undistorted", CHANGES, NULL },
    [NOTE_NO_OBJECT] = { "no-object", CHANGES, NULL },
    [NOTE_NO_DEPTH] = { "no-depth", CHANGES, NULL },
    [NOTE_DEPTH_TURNED] = { "depth-turned", CHANGES, NULL },
    [NOTE_NOT_SMOOTHED] = { "not-smoothed", CHANGES, NULL },
    [NOTE_OBJECT_UNIT] = { "object-unit", CHANGES, NULL },
    [NOTE_OBJECT_AXES] = { "object-axes", CHANGES, NULL },
    [NOTE_HAND_GUESSED] = { "hand-guessed", ALWAYS, NULL },
    [NOTE_LOW_TRUST] = { "low-trust", ALWAYS, NULL },
    [NOTE_DEPTH_DOUBTFUL] = { "depth-doubtful", ALWAYS, NULL },
    [NOTE_NO_POSE] = { "object-not-found", ALWAYS, NULL },
    [NOTE_POSE_FAR] = { "object-far", ALWAYS, NULL },
    [NOTE_OBJECT_APART] = { "object-apart", ALWAYS, NULL },
    [NOTE_NOTHING] = { "nothing-found", IMAGES, "something was found" },
    [NOTE_NO_HAND] = { "no-hand", IMAGES, "a hand was found" },
    [NOTE_LOW_SCORE] = { "low-score", IMAGES, NULL },
    [NOTE_SIDE] = { "side-assumed", CHANGES, NULL },
    [NOTE_OBJECT_UNKNOWN] = { "object-unknown", CHANGES, NULL },
    [NOTE_PERSON_BOX] = { "person-box-assumed", CHANGES, "its person box is known" },
    [NOTE_NO_PERSON] = { "no-person", IMAGES, "a person was found" },
};

const char *predict_note_name(predict_note_code code)
{
    return kinds[code].name;
}

void predict_say(const predict_options *o, const char *fmt, ...)
{
    va_list args;

    if (!o->messages)
        return;
    va_start(args, fmt);
    lt_vsay(o->messages, fmt, args);
    va_end(args);
}

void predict_note_add(predict_notes *notes, const predict_view *v, predict_note_code code, const char *fmt, ...)
{
    predict_note *longer = lt_arena_grow(notes->arena, notes->note, notes->n, &notes->room, sizeof(*longer));
    const char *text;
    va_list args;

    va_start(args, fmt);
    text = lt_arena_vprintf(notes->arena, fmt, args);
    va_end(args);
    if (text && v && v->n_hands > 1)
        text = lt_arena_printf(notes->arena, "hand %d: %s", v->hand + 1, text);
    if (longer)
        notes->note = longer;
    if (longer && text)
        notes->note[notes->n++] = (predict_note){ code, text };
    else
        notes->lost = true;
}

/* All texts of a kind, a line each; "" where there is none. */
static void texts_of(const predict_notes *notes, predict_note_code code, char out[PREDICT_SAID])
{
    size_t n = 0;

    *out = '\0';
    for (size_t i = 0; i < notes->n && n < PREDICT_SAID; i++)
        if (notes->note[i].code == code)
            n += (size_t)snprintf(out + n, PREDICT_SAID - n, "%s\n", notes->note[i].text);
}

static void say_kind(const predict_options *o, const char *path, const predict_notes *notes, predict_note_code code)
{
    for (size_t i = 0; i < notes->n; i++)
        if (notes->note[i].code == code)
            predict_say(o, "%s: %s", path, notes->note[i].text);
}

/* Where it is not what was said last, which it becomes */
static bool say_change(const predict_options *o, const char *path, const predict_notes *notes, predict_note_code code,
                       char last[PREDICT_SAID])
{
    char texts[PREDICT_SAID];

    texts_of(notes, code, texts);
    if (strcmp(last, texts) == 0)
        return false;
    if (*texts)
        say_kind(o, path, notes, code);
    else if (kinds[code].otherwise)
        predict_say(o, "%s: %s", path, kinds[code].otherwise);
    memcpy(last, texts, sizeof(texts));
    return true;
}

void predict_say_notes(const predict_options *o, const char *path, bool among_many, bool film,
                       const predict_notes *notes, predict_said *said)
{
    bool any = false;

    if (o->quiet)
        return;
    for (predict_note_code k = 0; k < PREDICT_NOTES; k++)
        if (kinds[k].each == CHANGES || (kinds[k].each == IMAGES && film))
            any = say_change(o, path, notes, k, said->last[k]) || any;
    if (any && among_many && !said->explained)
        predict_say(o, "what was assumed is said again where it changes");
    said->explained = said->explained || any;
    for (predict_note_code k = 0; k < PREDICT_NOTES; k++)
        if (kinds[k].each == ALWAYS || (kinds[k].each == IMAGES && !film))
            say_kind(o, path, notes, k);
}
