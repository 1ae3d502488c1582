/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/eval_file.h"

#include "cli/cli.h"
#include "data/dexycb/dexycb.h"
#include "data/ho3d/ho3d.h"
#include "data/kind.h"
#include "eval/scorers/bop_score.h"
#include "eval/scorers/dexycb_files.h"
#include "eval/scorers/ho3d/files.h"
#include "eval/scorers/result_kind.h"
#include "libtensor/base/printable.h"
#include "libtensor/io/file.h"

#include <stdio.h>

static lt_status is_synthetic(const eval_file_options *o, bool *out)
{
    const ho3d_options evaluation = { .root = o->data, .split = "evaluation", .no_objects = true };
    dataset *d = NULL;
    const lt_status st = ho3d_open(&evaluation, &d);

    *out = !st && d->synthetic;
    dataset_free(d);
    return st;
}

/* Before the scores, which may be read by a program that stops at any line. */
static void say(const eval_notes *notes)
{
    for (int i = 0; i < notes->n; i++)
        lt_say(stderr, "%s", notes->note[i].text);
}

/* HO3D's own 14 lines, and as scores.txt in --out. */
static lt_status score_ho3d(const eval_file_options *o, lt_arena *arena)
{
    const char *xyz = lt_path_join(arena, o->data, "evaluation_xyz.json");
    const char *verts = lt_path_join(arena, o->data, "evaluation_verts.json");
    const char *out = o->out ? lt_path_join(arena, o->out, "scores.txt") : NULL;
    double scores[HO3D_SCORES];
    eval_notes notes = { 0 };
    bool synthetic = false;
    int64_t n;
    lt_status st = xyz && verts ? is_synthetic(o, &synthetic) : lt_error(LT_ENOMEM, "%s: no memory", o->pred);

    st = st ? st : ho3d_score_files(o->pred, xyz, verts, scores, &n, &notes, o->progress, NULL);
    say(&notes);
    if (st)
        return st;
    fprintf(stderr,
            "Protocol: %sHO3D evaluation; %lld samples; *_al_*: similarity per sample, reflections allowed; means in "
            "cm\n", synthetic ? "SYNTHETIC, " : "", (long long)n);
    ho3d_print_scores(stdout, scores);
    st = out ? lt_make_dirs(o->out) : LT_OK;
    return st || !out ? st : ho3d_write_scores(out, scores);
}

static lt_status score_hands(const eval_file_options *o, const dataset *d)
{
    double scores[DEXYCB_SCORES];
    eval_notes notes = { 0 };
    const lt_status st = dexycb_score_hpe(d, o->pred, scores, &notes);

    say(&notes);
    if (st)
        return st;
    fprintf(stderr, "Protocol: %s%s, split %s; %lld samples with a hand; pa: similarity per sample, reflections "
            "allowed; pa_rigid: without\n", d->synthetic ? "SYNTHETIC, " : "", d->title, d->split, (long long)d->count);
    for (int i = 0; i < DEXYCB_SCORES; i++)
        printf("%s: %f\n", dexycb_score_name((dexycb_score)i), scores[i]);
    return LT_OK;
}

static void print_recall(const char *name, const bop_recall *r)
{
    printf("%-10s %9lld %9lld %9.6f %9.6f %9.6f %9.6f\n", name, (long long)r->targets, (long long)r->estimated, r->vsd,
           r->mssd, r->mspd, r->ar);
}

static lt_status score_objects(const eval_file_options *o, const dataset *d, lt_arena *arena)
{
    const char *models_info;
    eval_notes notes = { 0 };
    bop_recalls r;
    lt_status st = dexycb_models_info(d, arena, &models_info);

    if (!st)
        st = bop_score(d, o->pred, models_info, &notes, o->progress, NULL, &r);
    say(&notes);
    if (st)
        return st;
    fprintf(stderr, "Protocol: %s%s, split %s; BOP 2019, key frames; VSD delta 15 mm; %s%s\n",
            d->synthetic ? "SYNTHETIC, " : "", d->title, d->split, models_info ? "symmetries and diameters of " :
            "symmetries by geometric class; diameter max_dist", models_info ? models_info : "");
    printf("%-10s %9s %9s %9s %9s %9s %9s\n", "", "targets", "estimated", "vsd", "mssd", "mspd", "mean");
    print_recall("all", &r.all);
    print_recall("grasp only", &r.grasped);
    return LT_OK;
}

/* Object poses are asked for in every key frame, hand joints where a hand is annotated. */
static lt_status score_dexycb(const eval_file_options *o, bool poses, lt_arena *arena)
{
    dataset *d = NULL;
    cli_hand hand;
    lt_status st = cli_hand_open(o->hand, NULL, &hand);
    const dataset_options part = { .root = o->data, .split = o->split, .models = o->models, .setup = o->setup,
                                   .filter = poses ? "every" : "valid", .hand = hand.model, .left = hand.left };

    if (!st)
        st = dataset_open(&part, &d);
    if (!st && d->partial)
        lt_say(stderr, "%s: %s", o->data, d->partial);
    if (!st)
        st = poses ? score_objects(o, d, arena) : score_hands(o, d);
    dataset_free(d);
    cli_hand_close(&hand);
    return st;
}

static lt_status score_hpe(const eval_file_options *o, lt_arena *arena) { return score_dexycb(o, false, arena); }
static lt_status score_bop(const eval_file_options *o, lt_arena *arena) { return score_dexycb(o, true, arena); }

/* Which results belong to which kind of dataset; those without a row are not scored. */
static const struct {
    result_kind result;
    const dataset_kind *data;
    lt_status (*score)(const eval_file_options *o, lt_arena *arena);
} scorers[] = {
    { RESULT_HO3D, &ho3d_kind, score_ho3d },
    { RESULT_HPE, &dexycb_kind, score_hpe },
    { RESULT_BOP, &dexycb_kind, score_bop },
};

static lt_status score(const eval_file_options *o, result_kind result, const dataset_kind *kind, lt_arena *arena)
{
    for (size_t i = 0; i < LT_COUNT(scorers); i++) {
        if (scorers[i].result == result && scorers[i].data == kind)
            return scorers[i].score(o, arena);
        if (scorers[i].result == result)
            return lt_error(LT_EINVAL, "%s: %s, and %s is a folder of %s", o->pred, result_kind_name(result), o->data,
                            kind->title);
    }
    return lt_error(LT_EINVAL, "%s: %s, which is not scored; DexYCB's text of hand joints (HPE) and csv of object "
                    "poses (BOP) are", o->pred, result_kind_name(result));
}

lt_status eval_file(const eval_file_options *o)
{
    lt_arena *arena = lt_arena_new();
    const dataset_kind *kind;
    result_kind result;
    lt_status st = arena ? dataset_find_kind(o->data, &kind) : lt_error(LT_ENOMEM, "%s: no memory", o->pred);

    if (!st)
        st = result_kind_of(o->pred, &result);
    if (!st)
        st = score(o, result, kind, arena);
    lt_arena_free(arena);
    return st;
}
