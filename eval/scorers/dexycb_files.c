/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/scorers/dexycb_files.h"

#include "data/mirror.h"
#include "data/slip.h"
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

enum { LOOK = 256 };                /* hands of a side that slips are looked for in */

/* Estimated and true joints of some hands, as they are on disk: right, left. */
typedef struct { float found[2][LOOK][J][3], wanted[2][LOOK][J][3]; int n[2]; } looked_at;

static void keep(looked_at *k, bool left, const float (*found)[3], const float (*wanted)[3])
{
    const int i = k->n[left];

    if (i == LOOK)
        return;
    memcpy(k->found[left][i], found, sizeof(k->found[left][i]));
    memcpy(k->wanted[left][i], wanted, sizeof(k->wanted[left][i]));
    k->n[left]++;
}

static slip slip_of_side(const looked_at *k, bool left)
{
    const slip_points p = { .what = "the joints", .file.millimetres = true, .n = k->n[left], .points = J, .skip = -1,
                            .found = k->found[left][0][0], .wanted = k->wanted[left][0][0], .places = true };
    slip out;

    slip_in_points(&p, &out);
    return out;
}

/* Left hands may have a slip of their own: they were not mirrored back. */
static void look_for_slips(const char *path, const looked_at *k, eval_notes *notes)
{
    const slip right = slip_of_side(k, false), left = slip_of_side(k, true);
    const bool same = !k->n[0] || !k->n[1] || !strcmp(right.text, left.text);
    const slip *one = k->n[0] ? &right : &left;

    if (same && one->code)
        eval_note(notes, one->code, "%s: it looks as if %s", path, one->text);
    if (!same && right.code)
        eval_note(notes, right.code, "%s: right hands: it looks as if %s", path, right.text);
    if (!same && left.code)
        eval_note(notes, left.code, "%s: left hands: it looks as if %s", path, left.text);
}

static void count_unknown(const dataset *d, const char *path, const hpe_file *file, eval_notes *notes)
{
    const int64_t length = dexycb_list_length(d);
    const hpe_line *first = NULL;
    int64_t n = 0;

    for (int64_t i = 0; i < file->n; i++) {
        const hpe_line *line = &file->line[i];
        if (line->index < length)
            continue;
        n++;
        if (!first || line->number < first->number)
            first = line;
    }
    if (n)
        eval_note(notes, "unknown-id", "%s: %lld of %lld lines are for no sample of split %s; the first, line %lld: "
                  "sample %lld, and there are %lld", path, (long long)n, (long long)file->n, d->split,
                  (long long)first->number, (long long)first->index, (long long)length);
}

static lt_status score_lines(const dataset *d, const char *path, const hpe_file *file, looked_at *k,
                             dexycb_scorer *scorer)
{
    const int64_t step = (d->count + LOOK - 1) / LOOK;

    for (int64_t i = 0; i < d->count; i++) {
        const int64_t index = dexycb_place_of(d, i).index;
        const hpe_line *found = hpe_file_find(file, index);
        lt_arena *arena = lt_arena_new();
        dataset_sample s;
        bool left;
        lt_status st = arena ? dataset_annotation(d, i, arena, &s) : lt_error(LT_ENOMEM, "%s: no memory", path);

        lt_arena_free(arena);
        if (!st && !found)
            st = lt_error(LT_EFORMAT, "%s: has no line for sample %lld, %s", path, (long long)index,
                          dataset_name(d, i));
        if (st)
            return st;
        left = s.flags & SAMPLE_MIRRORED;
        for (int j = 0; left && j < J; j++)
            mirror_point(s.joints[j]);
        dexycb_scorer_add(scorer, 1, found->joints[0], s.joints[0], NULL);
        if (i % step == 0)
            keep(k, left, (const float (*)[3])found->joints, (const float (*)[3])s.joints);
    }
    return LT_OK;
}

lt_status dexycb_score_hpe(const dataset *d, const char *path, double scores[DEXYCB_SCORES], eval_notes *notes)
{
    lt_arena *arena = lt_arena_new();
    looked_at *k = arena ? lt_arena_alloc(arena, sizeof(*k)) : NULL;
    dexycb_scorer *scorer = dexycb_scorer_new();
    hpe_file file;
    lt_status st = k && scorer ? hpe_file_read(arena, path, &file) : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (!st)
        st = score_lines(d, path, &file, k, scorer);
    if (!st) {
        count_unknown(d, path, &file, notes);
        look_for_slips(path, k, notes);
        dexycb_scorer_scores(scorer, scores);
    }
    dexycb_scorer_free(scorer);
    lt_arena_free(arena);
    return st;
}
