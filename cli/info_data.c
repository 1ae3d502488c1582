/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/info_data.h"

#include "assets/hand_file.h"
#include "cli/cli.h"
#include "data/check.h"
#include "data/dexycb/dexycb.h"
#include "data/open.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

enum { HANDS = 200 };               /* annotated hands that are compared with the model */

typedef struct {
    const info_data_options *o;
    dataset_layout layout;
    cli_hand hand;
    lt_arena *arena;
    const lt_hand_model *left;
    cJSON *root;
    int faults;                     /* what is wrong, over all splits; fault: the first */
    char fault[1024];
} survey;

static void add_fault(survey *v, const char *split, const char *what)
{
    if (!v->faults++)
        snprintf(v->fault, sizeof(v->fault), "%s: %s: %s", v->o->root, split, what);
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
        add_fault(v, d->split, line);
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
        add_fault(v, d->split, s.line[0]);
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
             v->hand.name, 100 * c.in_view, c.slip ? "; it looks as if " : "; were they made with another hand model?",
             c.slip ? c.slip : "");
    cJSON_AddStringToObject(test, "wrong", line);
    add_fault(v, d->split, line);
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

static lt_status survey_split(survey *v, const char *name)
{
    const dataset_options o = { .root = v->o->root, .split = name, .setup = v->o->setup, .hand = v->hand.model,
                                .left = v->left };
    cJSON *split;
    dataset *d;
    lt_status st = dataset_open(&o, &d);

    if (st)
        return st;
    if (!cJSON_GetObjectItem(v->root, "dataset")) {
        cJSON_AddStringToObject(v->root, "dataset", d->kind);
        cJSON_AddBoolToObject(v->root, "synthetic", d->synthetic);
        cJSON_AddNumberToObject(v->root, "objects", d->n_objects);
        cJSON_AddStringToObject(v->root, "hand", v->hand.name);
    }
    split = cJSON_AddObjectToObject(v->root, name);
    cJSON_AddNumberToObject(split, v->layout == DATASET_DEXYCB ? "samples with a hand" : "samples", (double)d->count);
    st = survey_files(v, d, split);
    if (!st)
        st = survey_samples(v, d, split);
    if (!st)
        st = survey_hands(v, d, split);
    dataset_free(d);
    return st;
}

/* ---- the lists of DexYCB ---- */

/* All frames of each setup's splits; a split may be empty where subjects were left out. */
static void list_setups(survey *v)
{
    static const char *const setup[] = { "s0", "s1", "s2", "s3" }, *const part[] = { "train", "val", "test" };
    cJSON *lists = cJSON_AddObjectToObject(v->root, "frames of the official lists");

    for (int i = 0; i < 4; i++) {
        cJSON *list = cJSON_AddObjectToObject(lists, setup[i]);
        for (int k = 0; k < 3; k++) {
            const dexycb_options o = { .root = v->o->root, .setup = setup[i], .split = part[k],
                                       .filter = DEXYCB_EVERY, .hand = v->hand.model, .no_objects = true };
            dataset *d;
            if (dexycb_open(&o, &d)) {
                cJSON_AddNumberToObject(list, part[k], 0);
                continue;
            }
            cJSON_AddNumberToObject(list, part[k], (double)d->count);
            dataset_free(d);
        }
    }
}

static lt_status survey_all(survey *v)
{
    static const char *const of_layout[2][3] = { { "train", "evaluation" }, { "train", "val", "test" } };
    lt_status st = dataset_find_layout(v->o->root, &v->layout);
    lt_hand_model *left;

    if (!st)
        st = cli_hand_open(v->o->hand, NULL, &v->hand);
    if (!st && v->o->left) {
        st = hand_file_read(v->arena, v->o->left, &left);
        v->left = st ? NULL : left;
    } else if (!st) {
        v->left = v->hand.left;
    }
    if (!st && v->layout == DATASET_DEXYCB)
        list_setups(v);
    for (int i = 0; !st && i < 3 && of_layout[v->layout][i]; i++)
        st = survey_split(v, of_layout[v->layout][i]);
    if (!st && v->faults)
        st = lt_error(LT_EFORMAT, "%s", v->fault);
    return st;
}

lt_status info_data(const info_data_options *o, cJSON *root)
{
    survey v = { .o = o, .root = root, .arena = lt_arena_new() };
    lt_status st = v.arena ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", o->root);

    cJSON_AddStringToObject(root, "folder", o->root);
    if (!st)
        st = survey_all(&v);
    cli_hand_close(&v.hand);
    lt_arena_free(v.arena);
    return st;
}
