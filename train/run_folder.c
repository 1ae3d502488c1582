/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The folder of a run and the files in it that say how it came about.
 */
#include "train/trainer_internal.h"

#include "data/dataset.h"
#include "estimate/checkpoint/folder.h"
#include "libtensor/base/cpu.h"
#include "libtensor/base/parallel.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"
#include "libtensor/kernels/kernels.h"

#include <cjson/cJSON.h>
#include <config.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/utsname.h>
#include <unistd.h>
#include <zlib.h>

static const char readme[] =
    "A run of palmar train.\n"
    "\n"
    "config.json   every setting of the run; palmar train --config THIS_FOLDER repeats it\n"
    "env.json      version, host, processor and data that it ran with\n"
    "log.jsonl     one object a line: each step's losses, learning rate, gradient norm, speed;\n"
    "              each validation's errors; steps that were skipped say for which tensor\n"
    "metrics.csv   one line for each validation; errors in millimetres\n"
    "tb/           both again for TensorBoard: tensorboard --logdir THIS_FOLDER\n"
    "stderr.log    what was noted on the way, warnings among it, and when\n"
    "checkpoints/  step-NNNNNN.safetensors, the newest few; last and best are further names of\n"
    "              two of them; palmar train --resume goes on from the newest sound one\n";

/* A file system without locks is not held against anybody. */
static lt_status lock(trainer *t)
{
    t->locked = open(t->opt->out, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (t->locked < 0)
        return lt_error(lt_errno_status(errno), "%s: %s", t->opt->out, strerror(errno));
    if (flock(t->locked, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return lt_error(LT_EINVAL, "%s: another palmar train is at work there; wait for it, or choose another --out",
                        t->opt->out);
    return LT_OK;
}

lt_status run_folder_lock(trainer *t)
{
    const train_options *o = t->opt;

    return o->dry_run || !ranks_lead(o->ranks) || t->locked >= 0 || !lt_is_folder(o->out) ? LT_OK : lock(t);
}

/* One that was stopped before its first checkpoint left nothing to go on from, and is begun again. */
lt_status run_folder_check(const trainer *t)
{
    const char *const *paths;
    int n;
    const lt_status st = checkpoint_list(t->arena, t->checkpoints, &paths, &n);

    if (st == LT_OK && n)
        return lt_error(LT_EINVAL, "%s: holds a run already; go on with --resume, or choose another --out",
                        t->opt->out);
    return st;
}

static lt_status write_config(const trainer *t, const char *path)
{
    cJSON *tree = train_config_json(&t->config, &t->model);
    const lt_status st = tree ? lt_json_write(path, tree) : lt_error(LT_ENOMEM, "%s: no memory", path);

    cJSON_Delete(tree);
    return st;
}

static lt_status write_env(const trainer *t, const char *path)
{
    cJSON *env = cJSON_CreateObject();
    char hash[16];
    const char *of = dataset_crc32(t->arena, t->config.data->dir, hash);
    struct utsname host;
    lt_status st;

    cJSON_AddStringToObject(env, "version", PACKAGE_VERSION);
    cJSON_AddStringToObject(env, "host", uname(&host) == 0 ? host.nodename : "");
    cJSON_AddStringToObject(env, "cpu", lt_cpu_model());
    cJSON_AddStringToObject(env, "isa", lt_isa_name(lt_k->isa));
    cJSON_AddNumberToObject(env, "threads", lt_threads());
    cJSON_AddNumberToObject(env, "ranks", t->opt->ranks ? t->opt->ranks->size : 1);
    t->config.task->facts(t->run, env);
    cJSON_AddStringToObject(env, "data_crc32", hash);
    cJSON_AddStringToObject(env, "data_crc32_of", of ? of : "");
    st = env ? lt_json_write(path, env) : lt_error(LT_ENOMEM, "%s: no memory", path);
    cJSON_Delete(env);
    return st;
}

/* Of a run that goes on with other data than it had nothing else would tell. */
static void compare_data(trainer *t, const char *env)
{
    cJSON *old = NULL;
    const char *was;
    char now[16];
    const char *of;

    if (access(env, R_OK) != 0 || lt_json_read(env, &old))
        return;
    of = dataset_crc32(t->arena, t->config.data->dir, now);
    was = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(old, "data_crc32"));
    if (was && strcmp(was, now))
        progress_warn(&t->progress, "%s holds other data than the run had: the CRC-32 of %s is %s, and was %s",
                      t->config.data->dir, of ? of : "its list", now, was);
    cJSON_Delete(old);
}

/* What a rank trains on, with what: all must have the same. */
typedef struct {
    char host[65], version[32], isa[16], config[16], data[16];
    int64_t step;
} identity;

static identity identify(const trainer *t)
{
    identity me = { .step = t->state.step };
    struct utsname host;

    snprintf(me.host, sizeof(me.host), "%s", uname(&host) == 0 ? host.nodename : "");
    snprintf(me.version, sizeof(me.version), "%s", PACKAGE_VERSION);
    snprintf(me.isa, sizeof(me.isa), "%s", lt_isa_name(lt_k->isa));
    snprintf(me.config, sizeof(me.config), "%08lx",
             crc32(0, (const Bytef *)t->config_text, (uInt)strlen(t->config_text)));
    dataset_crc32(t->arena, t->config.data->dir, me.data);
    return me;
}

lt_status run_folder_agree(const trainer *t)
{
    const identity me = identify(t);
    identity first = me;
    const lt_status st = ranks_tell(t->opt->ranks, &first, sizeof(first));
    const struct { const char *what, *mine, *theirs; } same[] = {
        { "palmar of version", me.version, first.version }, { "instructions", me.isa, first.isa },
        { "a configuration of CRC-32", me.config, first.config }, { "data whose list has CRC-32", me.data, first.data },
    };

    if (st)
        return st;
    for (size_t i = 0; i < LT_COUNT(same); i++)
        if (strcmp(same[i].mine, same[i].theirs))
            return lt_error(LT_EINVAL, "rank %d on %s has %s %s, but rank 0 on %s has %s; all must have the same",
                            t->opt->ranks->rank, me.host, same[i].what, same[i].mine, first.host, same[i].theirs);
    if (me.step != first.step)
        return lt_error(LT_EINVAL, "rank %d on %s goes on from step %" PRId64 ", but rank 0 on %s from %" PRId64
                        "; do all see the same %s?", t->opt->ranks->rank, me.host, me.step, first.host, first.step,
                        t->opt->out);
    return LT_OK;
}

lt_status run_folder_make(trainer *t)
{
    const char *config = lt_path_join(t->arena, t->opt->out, "config.json");
    const char *env = lt_path_join(t->arena, t->opt->out, "env.json");
    const char *about = lt_path_join(t->arena, t->opt->out, "README.txt");
    const char *said = lt_path_join(t->arena, t->opt->out, "stderr.log");
    lt_status st = config && env && about && said ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", t->opt->out);

    if (st == LT_OK)
        st = lt_make_dirs(t->opt->out);
    if (st == LT_OK)
        st = run_folder_lock(t);
    if (st == LT_OK && !t->opt->resume)
        st = run_folder_check(t);       /* again, as only now nobody else can begin one */
    if (st == LT_OK)
        st = lt_make_own_folder(t->checkpoints);
    if (st == LT_OK) {
        lt_atomic_sweep(t->opt->out);
        lt_atomic_sweep(t->checkpoints);
    }
    if (st == LT_OK)
        st = progress_keep(&t->progress, said);
    if (st == LT_OK && t->opt->resume)
        compare_data(t, env);
    if (st == LT_OK && t->state.step < t->total_steps)
        st = write_config(t, config);
    if (st == LT_OK && t->state.step < t->total_steps)
        st = write_env(t, env);
    if (st == LT_OK)
        st = lt_write_file(about, readme, sizeof(readme) - 1);
    return st;
}
