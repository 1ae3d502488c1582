/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/info/data.h"

#include "assets/hand_file.h"
#include "cli/cli.h"
#include "data/check.h"
#include "data/kind.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

/* Annotated hands that are compared with the model; masks that are held against hands. */
enum { HANDS = 200, MASKS = 50 };

typedef struct {
    const info_data_options *o;
    const dataset_kind *kind;
    cli_hand hand;
    lt_arena *arena;
    const lt_hand_model *left;
    cJSON *root, *notes;
    int faults;                     /* what is wrong, over all splits; fault: the first */
    char fault[1024], slip[SLIP_TEXT];          /* slip: what may have led to it */
} survey;

static void add_note(survey *v, const char *code, const char *split, const char *what)
{
    cJSON *note = cJSON_CreateObject();
    char text[1200];

    snprintf(text, sizeof(text), "%s: %s", split, what);
    cJSON_AddStringToObject(note, "code", code);
    cJSON_AddStringToObject(note, "text", text);
    cJSON_AddItemToArray(v->notes, note);
}

static void add_fault(survey *v, const char *code, const char *split, const char *what)
{
    add_note(v, code, split, what);
    if (!v->faults++)
        snprintf(v->fault, sizeof(v->fault), "%s: %s: %s", v->o->root, split, what);
}

/* The first slip that is found stands for what else is wrong: the lines before it may be its consequence. */
static void add_slip(survey *v, const slip *s)
{
    if (!*v->slip)
        snprintf(v->slip, sizeof(v->slip), "%s", s->text);
}

/* ---- one split ---- */

static lt_status survey_files(survey *v, const dataset *d, cJSON *split)
{
    char line[900];
    check_missing m;
    const lt_status st = check_files(d, v->arena, &m);

    if (st)
        return st;
    cJSON_AddNumberToObject(split, "samples that lack a file", (double)m.samples);
    if (m.first) {
        cJSON_AddStringToObject(split, "first missing file", m.first);
        snprintf(line, sizeof(line), "%lld samples lack a file, the first %s", (long long)m.samples, m.first);
        add_fault(v, "missing-file", d->split, line);
    }
    return LT_OK;
}

static lt_status survey_samples(survey *v, const dataset *d, cJSON *split)
{
    check_samples s;
    const lt_status st = check_read(d, v->o->samples, v->arena, &s);

    if (st)
        return st;
    cJSON_AddNumberToObject(split, "read and checked", (double)s.read);
    cJSON_AddNumberToObject(split, "unreadable of these", (double)s.bad);
    if (s.bad) {
        cJSON_AddItemToObject(split, "unreadable", cJSON_CreateStringArray(s.line, s.n_lines));
        add_fault(v, "unreadable", d->split, s.line[0]);
    }
    return LT_OK;
}

static lt_status survey_side(survey *v, const dataset *d, bool left, cJSON *split)
{
    const char *side = left ? "left" : "right";
    char line[600];
    check_hands c;
    cJSON *test;
    const lt_status st = check_pose(d, v->hand.model, HANDS, left, &c);

    if (st || !c.hands)
        return st;
    test = cJSON_AddObjectToObject(split, left ? "left hands on the hand model" : "right hands on the hand model");
    cJSON_AddNumberToObject(test, "compared", (double)c.hands);
    cJSON_AddNumberToObject(test, "joints off by mm", c.rms_mm);
    cJSON_AddNumberToObject(test, "share in view", c.in_view);
    if (check_hands_good(&c))
        return LT_OK;
    snprintf(line, sizeof(line), "%s hands are %.1f mm from the hand model (%s), %.0f %% in view%s%s", side, c.rms_mm,
             v->hand.name, 100 * c.in_view, c.slip.code ? "; it looks as if " :
             "; were they made with another hand model?", c.slip.text);
    cJSON_AddStringToObject(test, "wrong", line);
    add_fault(v, c.slip.code ? c.slip.code : "hands", d->split, line);
    add_slip(v, &c.slip);
    return LT_OK;
}

/* The hand on the stored parameters must meet the stored joints. */
static lt_status survey_hands(survey *v, dataset *d, cJSON *split)
{
    double rms_mm;
    lt_status st = LT_OK;

    dataset_check_tips(d, v->hand.model, &rms_mm);      /* chooses d->tips; what is wrong is told below */
    for (int left = 0; !st && left < 2; left++)
        st = survey_side(v, d, left, split);
    return st;
}

/* Objects are held against hands, and so after these have been found sound. */
static lt_status survey_scene(survey *v, const dataset *d, cJSON *split)
{
    char line[600];
    check_scene c;
    const lt_status st = check_cameras_and_objects(d, HANDS, &c);

    if (st)
        return st;
    if (c.odd_cameras) {
        snprintf(line, sizeof(line), "%lld of %lld samples have odd intrinsics, the first %s; it looks as if %s",
                 (long long)c.odd_cameras, (long long)c.samples, c.odd_camera, c.camera.text);
        add_fault(v, c.camera.code, d->split, line);
        add_slip(v, &c.camera);
    }
    if (c.objects)
        cJSON_AddNumberToObject(split, "objects from hands, m", c.apart);
    if (c.object.code && !*v->slip) {
        snprintf(line, sizeof(line), "objects are %.3g m from the hands that hold them; it looks as if %s", c.apart,
                 c.object.text);
        add_fault(v, c.object.code, d->split, line);
        add_slip(v, &c.object);
    }
    return LT_OK;
}

/* Colours that mean something else make hand or object background where data.background asks. */
static lt_status survey_masks(survey *v, const dataset *d, cJSON *split)
{
    char line[200];
    check_masks c;
    const lt_status st = check_masks_on_hands(d, MASKS, &c);

    if (st || !c.joints)
        return st;
    cJSON_AddNumberToObject(split, "share of joints on masks", (double)c.on_mask / (double)c.joints);
    if (check_masks_good(&c))
        return LT_OK;
    snprintf(line, sizeof(line), "masks have %.0f %% of the joints: their colours are not those of hand and object",
             100 * (double)c.on_mask / (double)c.joints);
    add_fault(v, "masks", d->split, line);
    return LT_OK;
}

/* Labels are looked at as they are: those of another size are refused when they are read as samples. */
static lt_status survey_labels(survey *v, dataset *d, cJSON *split)
{
    lt_status st;

    d->any_size = true;
    st = survey_hands(v, d, split);
    if (!st)
        st = survey_scene(v, d, split);
    d->any_size = false;
    return st ? st : survey_masks(v, d, split);
}

static void describe(survey *v, const dataset *d)
{
    if (cJSON_GetObjectItem(v->root, "dataset"))
        return;
    cJSON_AddStringToObject(v->root, "dataset", d->title);
    cJSON_AddBoolToObject(v->root, "synthetic", d->synthetic);
    cJSON_AddNumberToObject(v->root, "objects", d->n_objects);
    cJSON_AddStringToObject(v->root, "hand", v->hand.name);
}

static dataset_options options_of(const survey *v, const char *split)
{
    return (dataset_options){ .kind = v->kind, .root = v->o->root, .split = split, .setup = v->o->setup,
                              .hand = v->hand.model, .left = v->left };
}

static lt_status survey_split(survey *v, const char *name)
{
    const dataset_options o = options_of(v, name);
    cJSON *split;
    dataset *d;
    lt_status st = dataset_open(&o, &d);

    if (st)
        return st;
    describe(v, d);
    split = cJSON_AddObjectToObject(v->root, name);
    cJSON_AddNumberToObject(split, v->kind->counted, (double)d->count);
    if (d->partial)
        add_note(v, "partial", name, d->partial);
    st = survey_files(v, d, split);
    if (!st)
        st = survey_samples(v, d, split);
    if (!st)
        st = survey_labels(v, d, split);
    dataset_free(d);
    return st;
}

static lt_status open_hands(survey *v)
{
    lt_hand_model *left;
    lt_status st = cli_hand_open(v->o->hand, NULL, &v->hand);

    if (!st && v->o->left) {
        st = hand_file_read(v->arena, v->o->left, &left);
        v->left = st ? NULL : left;
    } else if (!st) {
        v->left = v->hand.left;
    }
    return st;
}

static lt_status survey_splits(survey *v)
{
    const char *const *split = v->kind->splits;
    int opened = 0;

    for (int i = 0; split[i]; i++) {
        const dataset_options o = options_of(v, split[i]);
        const char *absent = v->kind->absent ? v->kind->absent(&o, v->arena) : NULL;
        lt_status st;
        if (absent)
            add_note(v, "empty-split", split[i], absent);
        /* the last one is opened in any case: where no split is there, its line says which would be wanted */
        if (absent && (opened || split[i + 1]))
            continue;
        st = survey_split(v, split[i]);
        if (st)
            return st;
        opened++;
    }
    return LT_OK;
}

/* The first thing that is wrong, and what may have led to it. */
static lt_status verdict(const survey *v)
{
    if (!v->faults)
        return LT_OK;
    if (*v->slip && !strstr(v->fault, v->slip))
        return lt_error(LT_EFORMAT, "%s; it looks as if %s", v->fault, v->slip);
    return lt_error(LT_EFORMAT, "%s", v->fault);
}

static lt_status survey_all(survey *v)
{
    dataset_options o;
    lt_status st = open_hands(v);

    if (!st)
        st = dataset_find_kind(v->o->root, &v->kind);
    o = options_of(v, NULL);
    if (!st && v->kind->describe)
        st = v->kind->describe(&o, v->arena, v->root);
    if (!st)
        st = survey_splits(v);
    return st ? st : verdict(v);
}

lt_status info_data(const info_data_options *o, cJSON *root)
{
    survey v = { .o = o, .root = root, .arena = lt_arena_new(), .notes = cJSON_CreateArray() };
    lt_status st = v.arena && v.notes ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", o->root);

    cJSON_AddStringToObject(root, "folder", o->root);
    if (!st)
        st = survey_all(&v);
    cJSON_AddItemToObject(root, "notes", v.notes);
    cli_hand_close(&v.hand);
    lt_arena_free(v.arena);
    return st;
}
