/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/score.h"

#include "data/hand_pose.h"
#include "eval/metrics/image.h"
#include "eval/metrics/object_pose.h"

#include <math.h>

const char *const hogs_score_keys[] = {
    "psnr_db", "ssim", "lpips_raw01", "lpips_sym", "psnr_fg_db", "oce_mm", "mce_mm", "adds_mm", "penetration_mm",
    "intersection_cm3", "contact_share", "cd_h_cm2", "f_h_1mm", "f_h_5mm", "cd_o_cm2", "cd_o_norot_cm2", "f_o_5mm",
    "f_o_10mm", "cd_o_vertices_cm2", "f_o_10mm_percent", "cd_pose_cm2", NULL,
};

void hogs_score_clear(double out[HOGS_SCORES])
{
    for (int i = 0; i < HOGS_SCORES; i++)
        out[i] = NAN;
}

lt_status hogs_score_images(const hogs *m, const hogs_frame *f, const lt_real *drawn, double out[HOGS_SCORES])
{
    const int64_t pixels = (int64_t)m->config.width * m->config.height;
    float *cut = lt_alloc(3 * (size_t)pixels * sizeof(*cut));
    const eval_pictures p = { .a = cut, .b = f->target, .channels = 3, .height = m->config.height,
                              .width = m->config.width, .plane = pixels, .row = m->config.width };
    lt_status st;

    if (!cut)
        return lt_error(LT_ENOMEM, "no memory to score a frame");
    for (int64_t i = 0; i < 3 * pixels; i++)
        cut[i] = fminf(1, fmaxf(0, (float)drawn[i]));
    out[HOGS_PSNR] = eval_psnr(&p, NULL);
    out[HOGS_PSNR_FG] = eval_psnr(&p, f->segments);
    st = eval_ssim(&p, EVAL_SSIM_VALID, &out[HOGS_SSIM]);
    lt_release(cut);
    return st;
}

lt_status hogs_score_pose(const dataset *d, const hogs_frame *f, const float R[9], const float t[3],
                          double out[HOGS_SCORES])
{
    const dataset_object *o = &d->objects[f->data_object];
    const lt_pose e = lt_pose_of(R, t), g = lt_pose_of(f->truth.R, f->truth.t);
    double (*x)[3] = f->known ? lt_alloc((size_t)o->n_points * sizeof(*x)) : NULL;
    lt_status st;

    if (!f->known)
        return LT_OK;
    if (!x)
        return lt_error(LT_ENOMEM, "no memory to score a pose");
    for (int i = 0; i < 3 * o->n_points; i++)
        x[i / 3][i % 3] = (double)o->point[i / 3][i % 3];
    out[HOGS_OCE] = 1e3 * eval_oce(&e, &g);
    out[HOGS_MCE] = 1e3 * eval_mce(o->n_points, &x[0][0], &e, &g);
    st = eval_adds(EVAL_FROM_ESTIMATE, o->n_points, &x[0][0], &e, &g, &out[HOGS_ADDS]);
    out[HOGS_ADDS] *= 1e3;
    lt_release(x);
    return st;
}

/* ---- touching -------------------------------------------------------------------------------------------- */

lt_status hogs_touch_open(lt_arena *arena, const dataset *d, const lt_hand_model *hand, hogs_touch *out)
{
    lt_status st = LT_OK;

    *out = (hogs_touch){ .data = d, .hand = hand,
                         .object = lt_arena_array(arena, (size_t)d->n_objects, sizeof(*out->object)) };
    if (!out->object)
        return lt_error(LT_ENOMEM, "no memory to see how hands touch objects");
    eval_close_hand(hand, out->face);
    for (int i = 0; i < d->n_objects && !st; i++)
        st = eval_contact_object_new(arena, &d->objects[i].mesh, &out->object[i]);
    return st;
}

lt_status hogs_score_contact(const hogs_touch *touch, const hogs *m, const hogs_frame *f, const float R[9],
                             const float t[3], double out[HOGS_SCORES])
{
    const lt_pose pose = lt_pose_of(R, t);
    double at[LT_HAND_VERTICES][3];
    float vertex[LT_HAND_VERTICES][3], beta[LT_HAND_BETAS];
    const lt_mesh hand = { .n_vertices = LT_HAND_VERTICES, .n_faces = EVAL_CLOSED_HAND_FACES, .vertex = vertex,
                           .face = (int32_t (*)[3])touch->face };
    eval_contact_score s;
    lt_status st;

    hogs_beta(m, f->subject, beta);
    hand_pose_at(touch->hand, f->initial.rotation[0], beta, f->initial.root, at);
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        for (int k = 0; k < 3; k++)
            vertex[i][k] = (float)at[i][k];
    st = eval_contact(touch->object[f->data_object], pose.R, pose.t, &hand, &s);
    if (st)
        return st;
    out[HOGS_PENETRATION] = s.penetration_mm;
    out[HOGS_INTERSECTION] = s.intersection_cm3;
    out[HOGS_CONTACT] = s.contact;
    return LT_OK;
}

lt_status hogs_score_frame(const model *m, const dataset *d, const hogs_frame *f, const compiled *c,
                           double out[HOGS_SCORES])
{
    const lt_real *R = compiled_output(c, "pose_rotation"), *t = compiled_output(c, "pose_translation");
    float rotation[9], translation[3];
    lt_status st;

    hogs_score_clear(out);
    for (int k = 0; k < 9; k++)
        rotation[k] = (float)R[k];
    for (int k = 0; k < 3; k++)
        translation[k] = (float)t[k];
    st = hogs_score_images(hogs_of(m), f, compiled_output(c, "frame"), out);
    return st ? st : hogs_score_pose(d, f, rotation, translation, out);
}

void hogs_means_add(hogs_means *m, const double frame[HOGS_SCORES])
{
    for (int i = 0; i < HOGS_SCORES; i++)
        if (isfinite(frame[i])) {
            m->sum[i] += frame[i];
            m->n[i]++;
        }
}

double hogs_means_of(const hogs_means *m, hogs_score which)
{
    return m->n[which] ? m->sum[which] / (double)m->n[which] : NAN;
}
