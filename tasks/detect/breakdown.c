/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/detect/breakdown.h"

#include "eval/metrics/ap.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"
#include "tasks/detect/kept.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WORST = 12 };
static const double SURE = 0.25, SAME = 0.5;            /* score, IoU */

/* ---- which finding is of which object --------------------------------------------------------------------------- */

/* The object that finding f overlaps most of those that are free: of its class, or of any; DETECT_NOBODY: none */
static int free_object(const kept *k, const detect_match *m, int f, bool any)
{
    int best = DETECT_NOBODY;

    for (int t = 0; t < k->head.n_truth; t++) {
        const float *iou = k->box_iou + (int64_t)f * k->head.n_truth;

        if (m->finder_of[t] != DETECT_NOBODY || k->truth[t].crowd || (!any && k->truth[t].cls != k->found[f].cls))
            continue;
        if ((double)iou[t] >= SAME && (best < 0 || iou[t] > iou[best]))
            best = t;
    }
    return best;
}

static bool in_crowd(const kept *k, int f)
{
    for (int t = 0; t < k->head.n_truth; t++)
        if (k->truth[t].crowd && k->truth[t].cls == k->found[f].cls &&
            (double)k->box_iou[(int64_t)f * k->head.n_truth + t] >= SAME)
            return true;
    return false;
}

static void take(const kept *k, detect_match *m, bool any)
{
    for (int f = 0; f < k->head.n_found; f++) {
        const int t = m->object_of[f] == DETECT_NOBODY ? free_object(k, m, f, any) : DETECT_NOBODY;

        if (t < 0)
            continue;
        m->object_of[f] = t;
        m->finder_of[t] = f;
        m->right += !any;
        m->confused += any;
    }
}

static lt_status match(lt_arena *arena, const kept *k, detect_match *m)
{
    *m = (detect_match){ .object_of = lt_arena_array(arena, (size_t)k->head.n_found, sizeof(*m->object_of)),
                         .finder_of = lt_arena_array(arena, (size_t)k->head.n_truth, sizeof(*m->finder_of)) };
    if (!m->object_of || !m->finder_of)
        return lt_error(LT_ENOMEM, "no memory to score an image");
    for (int f = 0; f < k->head.n_found; f++)
        m->object_of[f] = (double)k->found[f].score > SURE ? DETECT_NOBODY : DETECT_UNSURE;
    for (int t = 0; t < k->head.n_truth; t++)
        m->finder_of[t] = DETECT_NOBODY;
    take(k, m, false);
    take(k, m, true);
    for (int f = 0; f < k->head.n_found; f++)
        if (m->object_of[f] == DETECT_NOBODY && in_crowd(k, f))
            m->object_of[f] = DETECT_IN_CROWD;
    for (int f = 0; f < k->head.n_found; f++)
        m->wrong += m->object_of[f] == DETECT_NOBODY;
    for (int t = 0; t < k->head.n_truth; t++)
        m->missed += m->finder_of[t] == DETECT_NOBODY && !k->truth[t].crowd;
    return LT_OK;
}

lt_status detect_match_of(lt_arena *arena, const records *all, int64_t i, detect_match *out)
{
    kept k;
    const lt_status st = kept_read(arena, all, i, &k);

    return st ? st : match(arena, &k, out);
}

/* ---- confusion, and images --------------------------------------------------------------------------------------- */

typedef struct { int64_t at; int errors; } image_errors;

typedef struct {
    const detection_set *set;
    const records *all;
    lt_arena *arena;
    int64_t *count;                 /* (classes + 1, classes + 1): truth, found; the last ones: nothing, missed */
    image_errors *image;            /* (all->n) */
    const char *folder;
} breakdown;

static void count_image(const breakdown *b, const kept *k, const detect_match *m)
{
    const int n = b->set->classes + 1;

    for (int t = 0; t < k->head.n_truth; t++)
        if (!k->truth[t].crowd) {
            const int found = m->finder_of[t] < 0 ? n - 1 : k->found[m->finder_of[t]].cls;

            b->count[(int64_t)k->truth[t].cls * n + found]++;
        }
    for (int f = 0; f < k->head.n_found; f++)
        if (m->object_of[f] == DETECT_NOBODY)
            b->count[(int64_t)(n - 1) * n + k->found[f].cls]++;
}

static const char *image_name(const breakdown *b, int64_t i)
{
    return b->set->image[b->all->place[i].sample].name;
}

static const char *class_name(const detection_set *set, int c)
{
    return set->class_name[c] ? set->class_name[c] : "";
}

/* A cell of text: quotes are doubled */
static void put_cell(FILE *f, const char *text)
{
    fputc('"', f);
    for (; *text; text++) {
        if (*text == '"')
            fputc('"', f);
        fputc(*text == '\n' || *text == '\r' ? ' ' : *text, f);
    }
    fputc('"', f);
}

static lt_status open_file(const breakdown *b, const char *name, lt_atomic_file *f)
{
    const char *path = lt_path_join(b->arena, b->folder, name);

    return path ? lt_atomic_open(f, path) : lt_error(LT_ENOMEM, "%s: no memory", name);
}

static lt_status write_images(breakdown *b)
{
    lt_arena *scratch = lt_arena_new();
    lt_atomic_file f;
    lt_status st = scratch ? open_file(b, "per-image.csv", &f) : lt_error(LT_ENOMEM, "no memory to score");

    if (st) {
        lt_arena_free(scratch);
        return st;
    }
    fputs("image,errors,right,confused,missed,where nothing is\n", f.stream);
    for (int64_t i = 0; i < b->all->n && !st; i++) {
        detect_match m;
        kept k;

        lt_arena_reset(scratch);
        st = kept_read(scratch, b->all, i, &k);
        st = st ? st : match(scratch, &k, &m);
        if (st)
            break;
        count_image(b, &k, &m);
        b->image[i] = (image_errors){ i, m.confused + m.missed + m.wrong };
        put_cell(f.stream, image_name(b, i));
        fprintf(f.stream, ",%d,%d,%d,%d,%d\n", b->image[i].errors, m.right, m.confused, m.missed, m.wrong);
    }
    lt_arena_free(scratch);
    if (st) {
        lt_atomic_abort(&f);
        return st;
    }
    return lt_atomic_commit(&f);
}

static lt_status write_confusion(const breakdown *b)
{
    const int n = b->set->classes;
    lt_atomic_file f;
    const lt_status st = open_file(b, "confusion.csv", &f);

    if (st)
        return st;
    fputs("truth", f.stream);
    for (int c = 0; c <= n; c++) {
        fputc(',', f.stream);
        put_cell(f.stream, c < n ? class_name(b->set, c) : "missed");
    }
    for (int t = 0; t <= n; t++) {
        fputc('\n', f.stream);
        put_cell(f.stream, t < n ? class_name(b->set, t) : "nothing");
        for (int c = 0; c <= n; c++)
            fprintf(f.stream, ",%" PRId64, b->count[(int64_t)t * (n + 1) + c]);
    }
    fputc('\n', f.stream);
    return lt_atomic_commit(&f);
}

static int most_errors_first(const void *a, const void *b)
{
    const image_errors *x = a, *y = b;

    return x->errors != y->errors ? y->errors - x->errors : x->at < y->at ? -1 : 1;
}

static lt_status write_worst(const breakdown *b)
{
    const char *path = lt_path_join(b->arena, b->folder, "pictures.png");
    int64_t place[WORST];
    int n = 0;

    if (!path)
        return lt_error(LT_ENOMEM, "no memory for the pictures");
    if (b->all->n)
        qsort(b->image, (size_t)b->all->n, sizeof(*b->image), most_errors_first);
    for (; n < WORST && n < b->all->n && b->image[n].errors; n++)
        place[n] = b->image[n].at;
    return n ? detect_worst_write(b->set, b->all, place, n, path) : LT_OK;
}

/* ---- curves ------------------------------------------------------------------------------------------------------ */

enum { HANDS, PEOPLE, OBJECTS, ALL, GROUPS };
enum { AT_50 = 0, AT_75 = 5 };          /* thresholds */

static int group_of(const char *name)
{
    if (name && (!strcmp(name, "hand") || !strcmp(name, "left_hand") || !strcmp(name, "right_hand")))
        return HANDS;
    return name && !strcmp(name, "person") ? PEOPLE : OBJECTS;
}

/* The mean over a group's classes with objects; false: there is none */
static bool mean_curve(const detection_set *set, const double *curves, int group, int t, double out[AP_RECALLS])
{
    int n = 0;

    memset(out, 0, AP_RECALLS * sizeof(*out));
    for (int c = 0; c < set->classes; c++) {
        const double *curve = curves + ((int64_t)c * AP_THRESHOLDS + t) * AP_RECALLS;

        if (isnan(curve[0]) || (group != ALL && group_of(set->class_name[c]) != group))
            continue;
        n++;
        for (int k = 0; k < AP_RECALLS; k++)
            out[k] += curve[k];
    }
    for (int k = 0; k < AP_RECALLS; k++)
        out[k] /= n ? n : 1;
    return n;
}

static cJSON *group_json(const detection_set *set, const double *curves, int group, int t)
{
    static const char *const names[] = { "hands", "people", "objects", "all classes" };
    double curve[AP_RECALLS];
    cJSON *one;

    if (!mean_curve(set, curves, group, t, curve))
        return NULL;
    one = cJSON_CreateObject();
    cJSON_AddStringToObject(one, "name", names[group]);
    cJSON_AddNumberToObject(one, "iou", t == AT_50 ? 0.5 : 0.75);
    cJSON_AddItemToObject(one, "precision", cJSON_CreateDoubleArray(curve, AP_RECALLS));
    return one;
}

static lt_status write_curves(const breakdown *b, const double *curves)
{
    static const int thresholds[] = { AT_50, AT_75 };
    const char *path = lt_path_join(b->arena, b->folder, "curves.json");
    cJSON *list = cJSON_CreateArray();
    lt_status st;

    for (size_t i = 0; i < LT_COUNT(thresholds); i++)
        for (int g = 0; g < GROUPS; g++) {
            cJSON *one = group_json(b->set, curves, g, thresholds[i]);

            if (one)
                cJSON_AddItemToArray(list, one);
        }
    st = path && list ? lt_json_write(path, list) : lt_error(LT_ENOMEM, "no memory for the curves");
    cJSON_Delete(list);
    return st;
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

static double area_under(const double *curve)
{
    double sum = 0;

    for (int k = 0; k < AP_RECALLS; k++)
        sum += curve[k];
    return sum / AP_RECALLS;
}

static void put_number(FILE *f, double x)
{
    if (isnan(x))
        fputs(" - |", f);
    else
        fprintf(f, " %.3f |", x);
}

/* A name in a table of Markdown */
static void put_name(FILE *f, const char *text)
{
    fputs("| ", f);
    for (; *text; text++)
        fputc(*text == '|' || *text == '\n' ? ' ' : *text, f);
    fputs(" |", f);
}

static lt_status write_table(const breakdown *b, const double *curves, const double value[DETECT_METRICS])
{
    lt_atomic_file f;
    const lt_status st = open_file(b, "table.md", &f);

    if (st)
        return st;
    fputs("### Average precision\n\n| metric | value |\n| ------ | ----: |\n", f.stream);
    for (int k = 0; k < DETECT_METRICS; k++) {
        put_name(f.stream, detect_metrics[k]);
        put_number(f.stream, value[k]);
        fputc('\n', f.stream);
    }
    fputs("\n### By class, boxes\n\n| class | AP50 | AP75 | AP |\n| ----- | ---: | ---: | -: |\n", f.stream);
    for (int c = 0; c < b->set->classes; c++) {
        const double *curve = curves + (int64_t)c * AP_THRESHOLDS * AP_RECALLS;
        double mean = 0;

        for (int t = 0; t < AP_THRESHOLDS; t++)
            mean += area_under(curve + t * AP_RECALLS) / AP_THRESHOLDS;
        put_name(f.stream, class_name(b->set, c));
        put_number(f.stream, area_under(curve + AT_50 * AP_RECALLS));
        put_number(f.stream, area_under(curve + AT_75 * AP_RECALLS));
        put_number(f.stream, mean);
        fputc('\n', f.stream);
    }
    fprintf(f.stream, "\nProtocol: COCO's, %s%s, split %s, %" PRId64 " images\n", b->set->synthetic ? "SYNTHETIC " : "",
            b->set->title, b->set->split, b->all->n);
    return lt_atomic_commit(&f);
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

static lt_status measure(const breakdown *b, double *curves)
{
    static const ap_range any = { 0, 1e10 };
    detect_images of;
    const lt_status st = detect_images_of(b->arena, b->all, &of);

    return st ? st : ap_curves(of.box, b->all->n, b->set->classes, any, curves);
}

lt_status detect_breakdown_write(const detection_set *set, const records *all, const double value[DETECT_METRICS],
                                 const char *folder)
{
    const size_t classes = (size_t)set->classes;
    breakdown b = { .set = set, .all = all, .arena = lt_arena_new(), .folder = folder };
    double *curves = NULL;
    lt_status st;

    if (b.arena) {
        b.count = lt_arena_array(b.arena, (classes + 1) * (classes + 1), sizeof(*b.count));
        b.image = lt_arena_array(b.arena, (size_t)all->n, sizeof(*b.image));
        curves = lt_arena_array(b.arena, classes * AP_THRESHOLDS * AP_RECALLS, sizeof(*curves));
    }
    st = b.count && b.image && curves ? measure(&b, curves) : lt_error(LT_ENOMEM, "no memory to score");
    st = st ? st : write_table(&b, curves, value);
    st = st ? st : write_curves(&b, curves);
    st = st ? st : write_images(&b);
    st = st ? st : write_confusion(&b);
    st = st ? st : write_worst(&b);
    lt_arena_free(b.arena);
    return st;
}
