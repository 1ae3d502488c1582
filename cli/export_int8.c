/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/export_int8.h"

#include "data/kind.h"
#include "libtensor/base/parallel.h"
#include "tasks/hand_object/config.h"
#include "tasks/hand_object/int8.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>

enum { SCORED = 256 };                  /* samples at most */

static bool show_progress(void *ctx, int64_t done, int64_t total)
{
    (void)ctx;
    cli_progress("samples", done, total);
    return !cli_stop_requested();
}

/* ---- what came of it --------------------------------------------------------------------------------------- */

static double loss_percent(const export_int8_report *r)
{
    return 100 * (r->pa_mpjpe_mm[1] / r->pa_mpjpe_mm[0] - 1);
}

static double gain(const export_int8_report *r)
{
    return r->ms[0] / r->ms[1];
}

static void print_text(const char *path, const export_int8_report *r)
{
    static const char *const name[] = { "float", "int8" };

    printf("%s: %.1f MB\n", path, (double)r->bytes / 1e6);
    calibration_print(&r->layers, stdout);
    printf("%8s %14s %12s\n", "", "PA-MPJPE (mm)", "1 image (ms)");
    for (int i = 0; i < 2; i++)
        printf("%8s %14.3f %12.2f\n", name[i], r->scored ? r->pa_mpjpe_mm[i] : NAN, r->ms[i]);
    if (r->scored)
        printf("PA-MPJPE %+.2f %% on %lld samples; %.2f times as fast with %d threads\n", loss_percent(r),
               (long long)r->scored, gain(r), lt_threads());
    else
        printf("%.2f times as fast with %d threads\n", gain(r), lt_threads());
}

static void add_pair(cJSON *root, const char *name, const double v[2])
{
    cJSON *pair = cJSON_AddObjectToObject(root, name);

    cJSON_AddNumberToObject(pair, "float", v[0]);
    cJSON_AddNumberToObject(pair, "int8", v[1]);
}

static void add_layer(cJSON *list, const calibrated_layer *l)
{
    cJSON *one = cJSON_CreateObject();

    cJSON_AddStringToObject(one, "name", l->layer);
    cJSON_AddBoolToObject(one, "int8", l->integers);
    cJSON_AddNumberToObject(one, "db", l->db);
    cJSON_AddItemToArray(list, one);
}

static lt_status print_json(const char *path, const export_int8_report *r)
{
    cJSON *root = cJSON_CreateObject(), *list;

    cJSON_AddStringToObject(root, "file", path);
    cJSON_AddNumberToObject(root, "bytes", (double)r->bytes);
    cJSON_AddNumberToObject(root, "scored", (double)r->scored);
    if (r->scored) {
        add_pair(root, "pa_mpjpe_mm", r->pa_mpjpe_mm);
        cJSON_AddNumberToObject(root, "loss_percent", loss_percent(r));
    }
    add_pair(root, "ms", r->ms);
    cJSON_AddNumberToObject(root, "gain", gain(r));
    list = cJSON_AddArrayToObject(root, "layers");
    for (int i = 0; list && i < r->layers.n; i++)
        add_layer(list, &r->layers.layer[i]);
    if (!list) {
        cJSON_Delete(root);
        root = NULL;
    }
    return cli_print_json(root, "the report");
}

/* ---- the export -------------------------------------------------------------------------------------------- */

static lt_status open_split(const cli_int8 *o, const cli_checkpoint *c, const char *split, dataset **out)
{
    dataset_options d = cli_checkpoint_data(c, o->data, split);

    d.vertices = true;
    return dataset_open(&d, out);
}

static lt_status run(const cli_int8 *o, cli_checkpoint *c, const char *path, const dataset *training,
                     const dataset *scored, bool json)
{
    const export_int8_options e = {
        .m = &c->m, .from = c->path, .calibration = training, .scored = scored, .hand = c->hand.model,
        .hand_name = c->hand.name, .bilinear = hand_object_config_of(&c->config)->bilinear, .samples = o->samples,
        .limit = SCORED, .progress = show_progress,
    };
    export_int8_report r;
    lt_status st = export_int8(c->arena, &e, path, &r);

    if (st)
        return st;
    if (json)
        return print_json(path, &r);
    print_text(path, &r);
    return LT_OK;
}

lt_status cli_export_int8(const cli_int8 *o, cli_checkpoint *c, const char *path, bool json)
{
    dataset *training = NULL, *scored = NULL;
    lt_status st = open_split(o, c, "train", &training);

    cli_catch_signals();
    if (st == LT_OK && open_split(o, c, "evaluation", &scored)) {
        fprintf(stderr, "not scored: %s\n", lt_last_error());
        scored = NULL;
    }
    if (st == LT_OK)
        st = run(o, c, path, training, scored, json);
    dataset_free(scored);
    dataset_free(training);
    return st;
}
