/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/reid/scores.h"

#include "eval/scorers/mot.h"
#include "eval/tables/scores_file.h"

#include <cjson/cJSON.h>
#include <string.h>
#include <unistd.h>

enum { COUNTS = 5, KEYS = 7 };     /* from COUNTS on keys are counts, not shares */

const char *const track_score_keys[KEYS + 1] = {
    "hota", "deta", "assa", "mota", "idf1", "switches", "switches_unlike", NULL,
};

static void values_of(const track_counts *c, double out[KEYS])
{
    const track_scores s = track_scores_of(c);

    out[0] = s.hota;
    out[1] = s.deta;
    out[2] = s.assa;
    out[3] = s.mota;
    out[4] = s.idf1;
    out[5] = s.switches;
    out[6] = s.taken;
}

static void add_values(cJSON *to, const track_counts *c)
{
    double value[KEYS];

    values_of(c, value);
    for (int k = 0; k < KEYS; k++)
        cJSON_AddNumberToObject(to, track_score_keys[k], value[k]);
}

struct cJSON *track_score_json(const track_score_table *t)
{
    cJSON *root = cJSON_CreateObject(), *rows;

    add_values(root, &t->row[0].counts);
    rows = cJSON_AddArrayToObject(root, "rows");
    for (int i = 0; i < t->n; i++) {
        cJSON *row = cJSON_CreateObject();

        cJSON_AddStringToObject(row, "tracker", t->row[i].name);
        add_values(row, &t->row[i].counts);
        cJSON_AddItemToArray(rows, row);
    }
    cJSON_AddNumberToObject(root, "sequences", t->sequences);
    cJSON_AddStringToObject(root, "data", "MOTChallenge");
    cJSON_AddBoolToObject(root, "synthetic", t->synthetic);
    return root;
}

/* Of a column, its heading above it */
static int width_of(int k)
{
    return (int)lt_max_i64(8, (int64_t)strlen(track_score_keys[k]));
}

void track_score_print(const track_score_table *t, FILE *f)
{
    fprintf(f, "%sMOTChallenge, %d sequences\n%-12s", t->synthetic ? "SYNTHETIC, " : "", t->sequences, "tracker");
    for (int k = 0; k < KEYS; k++)
        fprintf(f, " %*s", width_of(k), track_score_keys[k]);
    for (int i = 0; i < t->n; i++) {
        double value[KEYS];

        values_of(&t->row[i].counts, value);
        fprintf(f, "\n%-12s", t->row[i].name);
        for (int k = 0; k < KEYS; k++)
            fprintf(f, " %*.*f", width_of(k), k >= COUNTS ? 0 : 4, value[k]);
    }
    fputc('\n', f);
}

lt_status track_score_page(const track_score_table *t, const char *folder)
{
    lt_atomic_file f;
    const lt_status st = scores_table_open(folder, &f);

    if (st)
        return st;
    fputs("### Trackers\n\n| tracker | HOTA | DetA | AssA | MOTA | IDF1 | switches | of unlike ones |\n"
          "| - | -: | -: | -: | -: | -: | -: | -: |\n", f.stream);
    for (int i = 0; i < t->n; i++) {
        double value[KEYS];

        values_of(&t->row[i].counts, value);
        fprintf(f.stream, "| %s |", t->row[i].name);
        for (int k = 0; k < KEYS; k++)
            fprintf(f.stream, " %.*f |", k >= COUNTS ? 0 : 4, value[k]);
        fputc('\n', f.stream);
    }
    fprintf(f.stream, "\nProtocol: TrackEval's, %sMOTChallenge, %d sequences\n", t->synthetic ? "SYNTHETIC, " : "",
            t->sequences);
    return lt_atomic_commit(&f);
}

/* ---- files ---- */

static const char *results_of(lt_arena *arena, const char *folder, const char *name)
{
    const char *beside = lt_arena_printf(arena, "%s/%s.txt", folder, name);
    const char *within = lt_arena_printf(arena, "%s/data/%s.txt", folder, name);

    return within && access(within, F_OK) == 0 ? within : beside;
}

static lt_status score_sequence(const mot_looks *looks, const mot_sequence *s, const char *folder, track_counts *sum)
{
    lt_arena *arena = lt_arena_new();
    const char *path = arena ? results_of(arena, folder, s->name) : NULL;
    mot_frame *truth, *results;
    track_counts counts;
    lt_status st = !path ? lt_error(LT_ENOMEM, "%s: no memory to score it", s->name)
                   : !s->truth ? lt_error(LT_EIO, "%s: has no gt/gt.txt to score with", s->folder)
                   : mot_read(arena, s->truth, MOT_TRUTH, s->frames, &truth);

    if (!st)
        st = mot_read(arena, path, MOT_RESULTS, s->frames, &results);
    if (!st)
        st = mot_count(s->name, looks, truth, results, s->frames, &counts);
    if (!st)
        track_counts_add(sum, &counts);
    lt_arena_free(arena);
    return st;
}

lt_status track_score_files(const char *data, const char *split, const char *folder,
                            bool (*progress)(void *ctx, int64_t done, int64_t total), track_score_table *out)
{
    lt_arena *arena = lt_arena_new();
    mot_set set = { .n = 0 };
    lt_status st = arena ? mot_open(arena, data, split, &set) : lt_error(LT_ENOMEM, "no memory to score");

    *out = (track_score_table){ .row[0].name = "results", .n = 1, .sequences = set.n, .synthetic = set.synthetic };
    for (int k = 0; !st && k < set.n; k++) {
        st = score_sequence(&set.looks, &set.sequence[k], folder, &out->row[0].counts);
        if (!st && progress && !progress(NULL, k + 1, set.n))
            st = lt_error(LT_ESTOPPED, "stopped");
    }
    lt_arena_free(arena);
    return st;
}
