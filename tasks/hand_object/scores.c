/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is measured of a predictor, by the dictionary's keys: one list, which scores.json, the tables and `palmar eval
 * --require` take theirs from.
 */
#include "tasks/hand_object/internal.h"

#include <math.h>
#include <string.h>

/* Of the object and of the model itself, which no official scorer has */
typedef enum {
    ADD01, REP5, ADD, OCE, MCE, ADDS_BELOW, ADDS_AUC, NO_POSE, ADDS, SECONDS, PER_SECOND, MEGABYTES, OWN_SCORES
} own_score;

typedef struct {
    const char *key;
    enum { FROM_HO3D, FROM_DEXYCB, FROM_OWN } from;
    int which;                      /* ho3d_score, dexycb_score or own_score */
    double times;                   /* to the key's unit */
} measure;

/* In the order of scores.json. */
static const measure measures[] = {
    { "pa_mpjpe_mm", FROM_HO3D, HO3D_XYZ_PA_MEAN, 10 }, { "pa_mpvpe_mm", FROM_HO3D, HO3D_MESH_PA_MEAN, 10 },
    { "f5_percent", FROM_HO3D, HO3D_F_AL_5, 100 }, { "f15_percent", FROM_HO3D, HO3D_F_AL_15, 100 },
    { "mpjpe_mm", FROM_DEXYCB, DEXYCB_RELATIVE_MEAN, 1 }, { "rigid_pa_mpjpe_mm", FROM_DEXYCB, DEXYCB_RIGID_MEAN, 1 },
    { "add01_percent", FROM_OWN, ADD01, 100 }, { "rep5_percent", FROM_OWN, REP5, 100 },
    { "add_mm", FROM_OWN, ADD, 1e3 }, { "oce_mm", FROM_OWN, OCE, 1e3 }, { "mce_mm", FROM_OWN, MCE, 1e3 },
    { "adds_below_2cm", FROM_OWN, ADDS_BELOW, 1 }, { "adds_auc", FROM_OWN, ADDS_AUC, 1 },
    { "adds_mm", FROM_OWN, ADDS, 1e3 },
    { "absolute_mpjpe_mm", FROM_DEXYCB, DEXYCB_MEAN, 1 }, { "absolute_auc", FROM_DEXYCB, DEXYCB_AUC, 1 },
    { "relative_auc", FROM_DEXYCB, DEXYCB_RELATIVE_AUC, 1 }, { "pa_auc", FROM_DEXYCB, DEXYCB_PA_AUC, 1 },
    { "rigid_pa_auc", FROM_DEXYCB, DEXYCB_RIGID_AUC, 1 },
    { "xyz_mean3d", FROM_HO3D, HO3D_XYZ_MEAN, 1 }, { "xyz_auc3d", FROM_HO3D, HO3D_XYZ_AUC, 1 },
    { "xyz_procrustes_al_mean3d", FROM_HO3D, HO3D_XYZ_PA_MEAN, 1 },
    { "xyz_procrustes_al_auc3d", FROM_HO3D, HO3D_XYZ_PA_AUC, 1 },
    { "xyz_scale_trans_al_mean3d", FROM_HO3D, HO3D_XYZ_ST_MEAN, 1 },
    { "xyz_scale_trans_al_auc3d", FROM_HO3D, HO3D_XYZ_ST_AUC, 1 },
    { "mesh_mean3d", FROM_HO3D, HO3D_MESH_MEAN, 1 }, { "mesh_auc3d", FROM_HO3D, HO3D_MESH_AUC, 1 },
    { "mesh_al_mean3d", FROM_HO3D, HO3D_MESH_PA_MEAN, 1 }, { "mesh_al_auc3d", FROM_HO3D, HO3D_MESH_PA_AUC, 1 },
    { "f_score_5", FROM_HO3D, HO3D_F_5, 1 }, { "f_al_score_5", FROM_HO3D, HO3D_F_AL_5, 1 },
    { "f_score_15", FROM_HO3D, HO3D_F_15, 1 }, { "f_al_score_15", FROM_HO3D, HO3D_F_AL_15, 1 },
    { "parameters_mb", FROM_OWN, MEGABYTES, 1 }, { "seconds_per_image", FROM_OWN, SECONDS, 1 },
    { "images_per_second", FROM_OWN, PER_SECOND, 1 }, { "no_object_pose_percent", FROM_OWN, NO_POSE, 1 },
};

_Static_assert(LT_COUNT(measures) <= EVALUATE_SCORES, "a summary has room for all");

const char *evaluate_key_at(int i)
{
    return i >= 0 && (size_t)i < LT_COUNT(measures) ? measures[i].key : NULL;
}

/* The share of objects with an ADD-S below so many metres */
static double adds_below(const score_set *set, double limit)
{
    int64_t close = 0;

    for (int64_t i = 0; i < set->n_adds; i++)
        close += set->adds[i] < limit;
    return (double)close / (double)set->n_adds;
}

static void own_scores(const evaluation *e, const score_set *set, double own[OWN_SCORES])
{
    own[ADD01] = eval_share_value(&set->add01);
    own[REP5] = eval_share_value(&set->rep5);
    own[ADD] = eval_mean_value(&set->add);
    own[OCE] = eval_mean_value(&set->oce);
    own[MCE] = eval_mean_value(&set->mce);
    own[ADDS] = eval_mean_value(&set->mean_adds);
    own[ADDS_BELOW] = adds_below(set, 0.02);
    own[ADDS_AUC] = set->n_adds ? eval_auc_ycb(set->n_adds, set->adds, 0.1) : NAN;
    own[NO_POSE] = 100.0 * (double)set->no_pose / (double)e->samples;
    own[MEGABYTES] = 4.0 * (double)lt_params_count(e->o.m->params, LT_WEIGHT, "") / 1048576;
    own[SECONDS] = e->o.seconds_per_image;
    own[PER_SECOND] = 1 / e->o.seconds_per_image;
}

/* Size and speed are the model's, and speed only where it was measured. */
static bool applies(const evaluation *e, const score_set *set, const measure *m)
{
    if (m->from != FROM_OWN || m->which < SECONDS)
        return true;
    return set == &e->set[EVALUATE_MODEL] && (m->which == MEGABYTES || e->o.seconds_per_image > 0);
}

static bool about_objects(const measure *m)
{
    return m->from == FROM_OWN && m->which != NO_POSE && m->which < SECONDS;
}

evaluate_summary evaluation_summary(const evaluation *e, int row)
{
    const score_set *set = &e->set[row];
    evaluate_summary s = { .label = set->label };
    double ho3d[HO3D_SCORES], dexycb[DEXYCB_SCORES], own[OWN_SCORES];
    const double *const from[] = { [FROM_HO3D] = ho3d, [FROM_DEXYCB] = dexycb, [FROM_OWN] = own };

    if (!set->label)
        return s;
    ho3d_scorer_scores(set->ho3d, ho3d);
    dexycb_scorer_scores(set->dexycb, dexycb);
    own_scores(e, set, own);
    for (size_t i = 0; i < LT_COUNT(measures); i++) {
        const measure *m = &measures[i];

        if (applies(e, set, m))
            s.score[s.n++] = (eval_score){
                .key = m->key, .value = m->times * from[m->from][m->which],
                .missing = about_objects(m) && set->n_adds == 0,
            };
    }
    return s;
}

double evaluation_score(const evaluation *e, int row, const char *key)
{
    const evaluate_summary s = evaluation_summary(e, row);

    for (int i = 0; s.label && i < s.n; i++)
        if (strcmp(s.score[i].key, key) == 0)
            return s.score[i].value;
    return NAN;
}
