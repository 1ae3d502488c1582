/* SPDX-License-Identifier: Apache-2.0 */
/* Adds up what synth_look found. */
#include "synth/stats.h"

#include "libtensor/base/order.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

lt_status synth_stats_add(synth_stats *s, const synth_visibility *frame)
{
    synth_visibility *longer = lt_arena_grow(s->arena, s->frame, (size_t)s->n, &s->room, sizeof(*longer));

    if (!longer)
        return lt_error(LT_ENOMEM, "synth: no memory for the figures of %lld frames", (long long)s->n + 1);
    s->frame = longer;
    s->frame[s->n++] = *frame;
    return LT_OK;
}

/* ---- figures ---- */

static double hidden(const synth_visibility *f) { return (double)f->hidden / fmax(1, f->inside); }
static double by_object(const synth_visibility *f) { return (double)f->hidden_by_object / fmax(1, f->inside); }
static double object_seen(const synth_visibility *f) { return f->object_visible; }
static double object_mostly_hidden(const synth_visibility *f) { return f->object_visible < 0.4; }
static double hand_seen(const synth_visibility *f) { return f->hand_visible; }
static double well_inside(const synth_visibility *f) { return f->inside >= 0.8 * LT_HAND_KEYPOINTS; }

static double mean(const synth_stats *s, double (*of)(const synth_visibility *))
{
    double sum = 0;

    for (int64_t i = 0; i < s->n; i++)
        sum += of(&s->frame[i]);
    return s->n ? sum / (double)s->n : NAN;
}

/* Share of the frames of handling in which hand and object touch. */
static double contact_share(const synth_stats *s)
{
    int64_t all = 0, touching = 0;

    for (int64_t i = 0; i < s->n; i++)
        if (s->frame[i].phase == SYNTH_MANIPULATE) {
            all++;
            touching += s->frame[i].contact;
        }
    return all ? (double)touching / (double)all : NAN;
}

/* Median over fingers and frames of handling with contact, millimetres. */
static double tip_distance_mm(const synth_stats *s)
{
    double *d = malloc(sizeof(*d) * 5 * (size_t)lt_max_i64(1, s->n)), median = NAN;
    size_t n = 0;

    if (!d)
        return NAN;
    for (int64_t i = 0; i < s->n; i++)
        for (int f = 0; f < 5 && s->frame[i].phase == SYNTH_MANIPULATE && s->frame[i].contact; f++)
            d[n++] = s->frame[i].tip[f];
    qsort(d, n, sizeof(*d), lt_ascending);
    if (n)
        median = 1000 * d[n / 2];
    free(d);
    return median;
}

int synth_stats_figures(const synth_stats *s, synth_figure out[SYNTH_FIGURES])
{
    const synth_figure all[] = {
        { "joints hidden, mean share", mean(s, hidden), 0.40, 0.55 },
        { "joints behind the object, mean share", mean(s, by_object), 0.15, 0.30 },
        { "object visible, mean share", mean(s, object_seen), 0.60, 0.80 },
        { "frames with under 40 % of the object visible", mean(s, object_mostly_hidden), 0.10, 1 },
        { "hand visible, mean share", mean(s, hand_seen), 0.70, 0.85 },
        { "frames with 80 % of the joints in the picture", mean(s, well_inside), 0.95, 1 },
        { "frames of handling with contact", contact_share(s), 0.70, 1 },
        { "finger tip to object, median mm", tip_distance_mm(s), 0, 3 },
    };

    memcpy(out, all, sizeof(all));
    memcpy(out + LT_COUNT(all), s->more, (size_t)s->n_more * sizeof(*out));
    return (int)LT_COUNT(all) + s->n_more;
}

static cJSON *figure_json(const synth_figure *f)
{
    cJSON *j = cJSON_CreateObject();

    cJSON_AddStringToObject(j, "name", f->name);
    cJSON_AddNumberToObject(j, "value", f->value);
    cJSON_AddNumberToObject(j, "at_least", f->lo);
    cJSON_AddNumberToObject(j, "at_most", f->hi);
    cJSON_AddBoolToObject(j, "within", synth_figure_within(f));
    return j;
}

lt_status synth_figures_write(const char *root, const char *counted, int64_t count, const synth_figure *figure, int n)
{
    lt_arena *arena = lt_arena_new();
    char *path = arena ? lt_path_join(arena, root, "stats.json") : NULL;
    cJSON *j = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(j, "figures");
    lt_status st;

    cJSON_AddNumberToObject(j, counted, (double)count);
    for (int i = 0; i < n; i++)
        cJSON_AddItemToArray(list, figure_json(&figure[i]));
    st = path && list ? lt_json_write(path, j) : lt_error(LT_ENOMEM, "%s/stats.json: no memory", root);
    cJSON_Delete(j);
    lt_arena_free(arena);
    return st;
}
