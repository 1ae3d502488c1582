/* SPDX-License-Identifier: Apache-2.0 */
/*
 * When and where the run is kept, and how it is found again.
 */
#include "train/trainer_internal.h"

#include "estimate/checkpoint/folder.h"
#include "libtensor/base/clock.h"
#include "libtensor/base/cpu.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"
#include "libtensor/kernels/kernels.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <string.h>
#include <sys/statvfs.h>

/* ---- the task's own state ------------------------------------------------------------------------------- */

static int own_save(void *ctx, lt_named_array *out, int room)
{
    const trainer *t = ctx;

    return t->config.task->save(t->run, out, room);
}

static lt_status own_load(void *ctx, const char *path, const lt_named_array *entry, size_t n)
{
    const trainer *t = ctx;

    return t->config.task->load(t->run, path, entry, n);
}

static checkpoint_own own_of(trainer *t)
{
    return (checkpoint_own){ .ctx = t, .save = own_save, .load = own_load };
}

/* ---- saving --------------------------------------------------------------------------------------------- */

lt_status trainer_save(trainer *t)
{
    const checkpoint_own own = own_of(t);
    const char *path = checkpoint_name(t->arena, t->checkpoints, t->state.step);
    lt_status st = LT_OK;

    if (!path)
        return lt_error(LT_ENOMEM, "no memory for the checkpoint's name");
    if (t->saved_step != t->state.step || t->improved)
        st = checkpoint_save(path, &t->model, t->optim, t->config_text, &t->state, t->config.task->save ? &own : NULL);
    if (st == LT_OK)
        st = checkpoint_alias(t->checkpoints, "last.safetensors", path);
    if (st == LT_OK && t->improved)
        st = checkpoint_alias(t->checkpoints, "best.safetensors", path);
    if (st == LT_OK)
        st = checkpoint_prune(t->checkpoints, t->state.step, t->config.loop.keep);
    if (st)
        return st;
    t->saved_step = t->state.step;
    t->saved_at = lt_clock();
    t->improved = false;
    return LT_OK;
}

/* ---- resume ------------------------------------------------------------------------------------------- */

/* What one optimiser keeps of its past means nothing to another, and batches are counted in batches of one size. */
static lt_status check_optim(const trainer *t, const cJSON *had, const cJSON *have)
{
    static const char *const keys[] = { "kind", "batch" };
    const cJSON *before = cJSON_GetObjectItemCaseSensitive(had, "optim");
    const cJSON *now = cJSON_GetObjectItemCaseSensitive(have, "optim");

    for (size_t i = 0; i < LT_COUNT(keys); i++) {
        const cJSON *a = cJSON_GetObjectItemCaseSensitive(before, keys[i]);
        const cJSON *b = cJSON_GetObjectItemCaseSensitive(now, keys[i]);

        if (!a || !b || cJSON_Compare(a, b, true))
            continue;
        if (cJSON_IsString(a) && cJSON_IsString(b))
            return lt_error(LT_EINVAL, "%s: optim.%s: %s, but the run to resume has %s", t->config.path, keys[i],
                            b->valuestring, a->valuestring);
        return lt_error(LT_EINVAL, "%s: optim.%s: %g, but the run to resume has %g", t->config.path, keys[i],
                        b->valuedouble, a->valuedouble);
    }
    return LT_OK;
}

/* isa: what the checkpoint says it was computed with, or NULL. */
static lt_status check_same_run(const trainer *t, const char *path, const char **isa)
{
    cJSON *had = NULL, *have = train_config_json(&t->config, &t->model);
    checkpoint_head head;
    lt_status st = checkpoint_head_read(t->arena, path, &head);

    if (st == LT_OK)
        st = lt_json_parse(path, head.config, strlen(head.config), &had);
    if (st == LT_OK)
        st = check_optim(t, had, have);
    *isa = st ? NULL : head.isa;
    cJSON_Delete(had);
    cJSON_Delete(have);
    return st;
}

static lt_status load(trainer *t, const char *path)
{
    const char *isa, *here = lt_isa_name(lt_k->isa);
    const checkpoint_own own = own_of(t);
    lt_status st = check_same_run(t, path, &isa);

    if (st == LT_OK)
        st = checkpoint_load(path, &t->model, t->optim, &t->state, t->config.task->load ? &own : NULL);
    if (st == LT_OK && isa && strcmp(isa, here) != 0)
        progress_note(&t->progress, "%s was computed with %s instructions and goes on with %s, so not to the same bits",
                      path, isa, here);
    return st;
}

/* An older checkpoint than others of the folder would begin a second branch in it, and they would win. */
static lt_status load_named(trainer *t, const char *named)
{
    const char *path = checkpoint_last(t->arena, named);
    const char *const *paths;
    int n;
    lt_status st = path ? load(t, path) : lt_error(LT_ENOMEM, "%s: no memory", named);

    if (st == LT_OK)
        st = checkpoint_list(t->arena, t->checkpoints, &paths, &n);
    if (st || !n || checkpoint_step(paths[0]) <= t->state.step)
        return st;
    return lt_error(LT_EINVAL, "%s: of step %" PRId64 ", but %s is there already; choose another --out, or remove what "
                    "came after", path, t->state.step, paths[0]);
}

static lt_status load_newest(trainer *t)
{
    const char *const *paths;
    lt_status st;
    int n;

    st = checkpoint_list(t->arena, t->checkpoints, &paths, &n);
    if (st)
        return st;
    for (int i = 0; i < n; i++) {
        st = load(t, paths[i]);
        if (st == LT_OK)
            progress_note(&t->progress, "going on from %s", paths[i]);
        if (st != LT_EFORMAT && st != LT_EIO)
            return st;
        progress_warn(&t->progress, "%s; taking the checkpoint before it", lt_last_error());
    }
    return lt_error(LT_EINVAL, n ? "%s: no sound checkpoint to resume from"
                                 : "%s: no checkpoint to resume from; begin again without --resume", t->checkpoints);
}

lt_status trainer_resume(trainer *t)
{
    const char *from = t->opt->resume;
    lt_status st = *from ? load_named(t, from) : load_newest(t);

    if (st)
        return st;
    if (t->state.seed != (uint64_t)t->config.loop.seed)
        return lt_error(LT_EINVAL, "%s: train.seed: %d, but the run to resume has %" PRIu64, t->config.path,
                        t->config.loop.seed, t->state.seed);
    t->saved_step = *from ? -1 : t->state.step;
    t->improved = t->state.validated && t->state.best_step == t->state.step;       /* its second name may be missing */
    return LT_OK;
}

/* ---- the disk ----------------------------------------------------------------------------------------- */

/* The file system of the nearest folder above out that is there. */
static bool free_bytes(lt_arena *arena, const char *path, double *out)
{
    struct statvfs fs;

    while (path && statvfs(path, &fs) != 0) {
        if (strcmp(path, ".") == 0 || strcmp(path, "/") == 0 || !*path)
            return false;
        path = lt_path_folder(arena, path);
    }
    if (!path)
        return false;
    *out = (double)fs.f_bavail * (double)fs.f_frsize;
    return true;
}

/* Those that are kept; last, best and the one being written */
size_t trainer_disk_bytes(const trainer *t)
{
    return checkpoint_bytes(&t->model, t->optim) * (size_t)(t->config.loop.keep + 3);
}

lt_status trainer_check_disk(trainer *t)
{
    const double one = (double)checkpoint_bytes(&t->model, t->optim), need = (double)trainer_disk_bytes(t);
    double have;

    if (!free_bytes(t->arena, t->opt->out, &have))
        return LT_OK;
    progress_note(&t->progress, "disk         %.1f MB for checkpoints, %.1f MB free",
                  1e-6 * need, 1e-6 * have);
    if (have < 2 * one)
        return lt_error(LT_ENOSPC, "%s: %.1f MB are free, and two checkpoints take %.1f; make room, or choose another "
                        "--out", t->opt->out, 1e-6 * have, 2e-6 * one);
    if (have < need)
        progress_warn(&t->progress, "the disk may fill up; train.keep=1 needs less");
    return LT_OK;
}
