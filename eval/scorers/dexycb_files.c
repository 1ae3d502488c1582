/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/scorers/dexycb_files.h"

#include "data/mirror.h"
#include "eval/scorers/hpe_file.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { J = LT_HAND_KEYPOINTS, HAND_CATEGORY = 22 };

typedef enum { HPE, BOP, COCO } kind;

struct dexycb_results {
    lt_atomic_file file;
    kind kind;
    bool any;
};

/* ---- writing ---- */

lt_status dexycb_results_open(const char *path, dexycb_results **out)
{
    static const char *const ending[] = { ".txt", ".csv", ".json" };
    dexycb_results *f;
    lt_status st;
    int k = 0;

    while (k < 3 && !lt_ends_with(path, ending[k]))
        k++;
    if (k == 3)
        return lt_error(LT_EINVAL,
                        "%s: which result file of DexYCB's? .txt for hand joints (HPE), .csv for object poses "
                        "(BOP), .json for detections (COCO)", path);
    f = calloc(1, sizeof(*f));
    if (!f)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    f->kind = (kind)k;
    st = lt_atomic_open(&f->file, path);
    if (st) {
        free(f);
        return st;
    }
    if (f->kind == BOP)
        fputs("scene_id,im_id,obj_id,score,R,t,time\n", f->file.stream);
    *out = f;
    return LT_OK;
}

static void put(FILE *f, const char *before, double x)
{
    char number[LT_NUMBER_TEXT];

    fprintf(f, "%s%s", before, lt_print_double(x, number));
}

static void add_bop(FILE *f, const dexycb_result *r)
{
    const int object = r->place.target[r->place.grasped];
    lt_pose p = r->object;

    if (!r->place.keyframe || !r->has_object)
        return;
    if (r->mirrored)
        mirror_pose(p.R, p.t);
    fprintf(f, "%d,%d,%d", r->place.scene, r->place.image, object);
    put(f, ",", r->score);
    for (int i = 0; i < 9; i++)
        put(f, i ? " " : ",", p.R[i]);
    for (int i = 0; i < 3; i++)
        put(f, i ? " " : ",", p.t[i]);
    put(f, ",", r->seconds);
    fputc('\n', f);
}

/* Key points x, y, 2 and the box around them; in the picture that is on disk. */
static void add_coco(FILE *f, const dexycb_result *r, bool first)
{
    double uv[J][2], lo[2] = { INFINITY, INFINITY }, hi[2] = { -INFINITY, -INFINITY };

    for (int i = 0; i < J; i++) {
        const double p[3] = { r->joints[i][0], r->joints[i][1], r->joints[i][2] };
        lt_camera_project(&r->camera, p, uv[i]);
        if (r->mirrored)
            uv[i][0] = r->width - 1 - uv[i][0];
        for (int k = 0; k < 2; k++) {
            lo[k] = fmin(lo[k], uv[i][k]);
            hi[k] = fmax(hi[k], uv[i][k]);
        }
    }
    fprintf(f, "%s{\"image_id\":%lld,\"category_id\":%d,\"bbox\":", first ? "" : ",\n", (long long)r->place.index,
            HAND_CATEGORY);
    put(f, "[", lo[0]);
    put(f, ",", lo[1]);
    put(f, ",", hi[0] - lo[0]);
    put(f, ",", hi[1] - lo[1]);
    fputs("],\"score\":1,\"keypoints\":", f);
    for (int i = 0; i < J; i++) {
        put(f, i ? "," : "[", uv[i][0]);
        put(f, ",", uv[i][1]);
        fputs(",2", f);
    }
    fputs("]}", f);
}

static void add_hpe(FILE *f, const dexycb_result *r)
{
    float joints[J][3];

    memcpy(joints, r->joints, sizeof(joints));
    for (int i = 0; i < J && r->mirrored; i++)
        mirror_point(joints[i]);
    dexycb_hpe_line(f, r->place.index, joints[0]);
}

void dexycb_results_add(dexycb_results *f, const dexycb_result *r)
{
    switch (f->kind) {
    case HPE: add_hpe(f->file.stream, r); break;
    case BOP: add_bop(f->file.stream, r); break;
    case COCO:
        if (!f->any)
            fputc('[', f->file.stream);
        add_coco(f->file.stream, r, !f->any);
        break;
    }
    f->any = true;
}

lt_status dexycb_results_close(dexycb_results *f)
{
    lt_status st;

    if (f->kind == COCO)
        fputs(f->any ? "]\n" : "[]\n", f->file.stream);
    st = lt_atomic_commit(&f->file);
    free(f);
    return st;
}

void dexycb_results_abort(dexycb_results *f)
{
    if (!f)
        return;
    lt_atomic_abort(&f->file);
    free(f);
}

/* ---- scoring an HPE file ---- */

static lt_status score_lines(const dataset *d, const char *path, const hpe_file *file, dexycb_scorer *scorer)
{
    for (int64_t i = 0; i < d->count; i++) {
        const int64_t index = dexycb_place_of(d, i).index;
        const hpe_line *found = hpe_file_find(file, index);
        lt_arena *arena = lt_arena_new();
        dataset_sample s;
        lt_status st = arena ? dataset_annotation(d, i, arena, &s) : lt_error(LT_ENOMEM, "%s: no memory", path);

        lt_arena_free(arena);
        if (!st && !found)
            st = lt_error(LT_EFORMAT, "%s: has no line for sample %lld, %s", path, (long long)index,
                          dataset_name(d, i));
        if (st)
            return st;
        if (s.flags & SAMPLE_MIRRORED)
            for (int j = 0; j < J; j++)
                mirror_point(s.joints[j]);
        dexycb_scorer_add(scorer, 1, found->joints[0], s.joints[0], NULL);
    }
    return LT_OK;
}

lt_status dexycb_score_hpe(const dataset *d, const char *path, double scores[DEXYCB_SCORES])
{
    lt_arena *arena = lt_arena_new();
    dexycb_scorer *scorer = dexycb_scorer_new();
    hpe_file file;
    lt_status st = arena && scorer ? hpe_file_read(arena, path, &file) : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (!st)
        st = score_lines(d, path, &file, scorer);
    if (!st)
        dexycb_scorer_scores(scorer, scores);
    dexycb_scorer_free(scorer);
    lt_arena_free(arena);
    return st;
}
