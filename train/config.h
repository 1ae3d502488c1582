/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The configuration of a run: four groups of documented keys in a JSON file, "model", "data", "optim" and
 * "train". What the keys of "model" are is the model's affair, but for "name".
 */
#ifndef TRAIN_CONFIG_H
#define TRAIN_CONFIG_H

#include "libtensor/optim/optim.h"
#include "models/model.h"

#include <stdio.h>

typedef struct task task;           /* train/task.h */

/* What the group "data" of any task begins with; TRAIN_DIR_KEY and TRAIN_LOADER_KEYS are its rows in the table of
 * keys. */
typedef struct {
    const char *dir;                /* the dataset's folder */
    int threads, ahead;
    double tolerate;
} train_data_config;

#define TRAIN_DIR_KEY(config) \
    { .name = "dir", .offset = offsetof(config, common.dir), .type = LT_CONFIG_TEXT, .fallback = "\"\"", \
      .doc = "folder of the dataset" }
#define TRAIN_LOADER_KEYS(config) \
    { .name = "threads", .offset = offsetof(config, common.threads), .type = LT_CONFIG_INT, .fallback = "2", .lo = 1, \
      .hi = 64, .doc = "threads that prepare samples" }, \
    { .name = "ahead", .offset = offsetof(config, common.ahead), .type = LT_CONFIG_INT, .fallback = "2", .lo = 1, \
      .hi = 64, .doc = "batches that are prepared ahead" }, \
    { .name = "tolerate", .offset = offsetof(config, common.tolerate), .type = LT_CONFIG_NUMBER, .fallback = "0.05", \
      .lo = 0, .hi = 1, .doc = "share of unreadable samples that is skipped; 0: the first one stops" }

/* Group "optim". */
typedef struct {
    int kind;                       /* lt_optim_kind */
    double lr, weight_decay, beta1, beta2, eps, momentum;
    bool nesterov;
    double clip_norm, ema_decay;
    int schedule;                   /* lt_schedule_kind */
    double gamma, min_lr, warmup;
    int every, epochs, steps, batch, shards;
} train_optim_config;

/* Group "train". */
typedef struct {
    int seed;
    double checkpoint_minutes;
    int checkpoint_steps, keep;
    int validate_every, validate_steps, validate_samples;
    int max_bad_steps, log_every;
} train_loop_config;

typedef struct {
    const char *path;               /* for messages */
    const task *const *tasks;
    const char *const *set;         /* n_set overrides, borrowed; for messages */
    int n_set;
    const model_class *model;
    const task *task;               /* that the model is trained for */
    struct cJSON *tree;             /* as read, overrides included; owned by the config */
    struct cJSON *model_keys;       /* group "model" without "name"; owned by the config */
    train_data_config *data;        /* of task->data_size bytes, in the arena */
    train_optim_config optim;
    train_loop_config loop;
} train_config;

/**
 * train_config_load - read a configuration
 *
 *   arena   owns the texts of the config
 *   tasks   all that there are, NULL-terminated
 *   path    a JSON file
 *   set     n_set overrides like "optim.lr=3e-4", applied in order; they must outlive the config
 *
 * End with train_config_fini. Errors: LT_EINVAL, or LT_EUSAGE when an override is at fault, with the place and, for a
 * key that does not exist, the nearest that does; those of lt_json_read. The model's own keys are checked when
 * the model is made.
 */
lt_status train_config_load(lt_arena *arena, const task *const *tasks, const char *path, const char *const *set,
                            int n_set, train_config *out);

/* train_config_parse - the same from text that a checkpoint carries; name is for messages */
lt_status train_config_parse(lt_arena *arena, const task *const *tasks, const char *name, const char *text,
                             const char *const *set, int n_set, train_config *out);
void train_config_fini(train_config *c);

/* train_optim_group - what group "optim" says of any weight: a start for a task whose weights learn in groups */
lt_optim_group train_optim_group(const train_config *c);

/**
 * train_config_model - make the model that the configuration names, without values (lt_params_defer)
 *
 * hand, which may be NULL for models that pose none, and set must outlive it. Errors: those of the model's keys,
 * LT_EUSAGE when an override is at fault, LT_ENOMEM.
 */
lt_status train_config_model(const train_config *c, const lt_hand_layer *hand, lt_params *set, model *out);

/* train_config_init - initial values of the run's seed, where no checkpoint brings any. LT_ENOMEM */
lt_status train_config_init(const train_config *c, const model *m);

/* train_config_json - every key with its value, m's own included; the caller frees it with cJSON_Delete; NULL
 * without memory */
struct cJSON *train_config_json(const train_config *c, const model *m);

/* train_config_help - all keys of all groups, tasks and models: type, default, range, meaning */
void train_config_help(const task *const *tasks, FILE *f);

#endif
