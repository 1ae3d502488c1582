/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The configuration of a run: four groups of documented keys in a JSON file, "model", "data", "optim" and
 * "train". What the keys of "model" are is the model's affair, but for "name".
 */
#ifndef TRAIN_CONFIG_H
#define TRAIN_CONFIG_H

#include "models/model.h"

#include <stdio.h>

/* Group "data". */
typedef struct {
    const char *dir;                /* the dataset's folder */
    const char *objects;            /* folder of the object models; "": in the dataset's, or beside it */
    const char *hand;               /* hand model file; "": the embedded hand */
    const char *hand_left;          /* DexYCB: left hand model file; "": the right one's mirror image */
    int setup, filter;              /* DexYCB: train_setup_name, train_filter_name */
    int threads, ahead;
    double tolerate;
    bool augment, bilinear;
    double contact_mm;              /* train where the hand comes this close to the object; 0: everywhere */
    double centre_jitter, scale_jitter, rotation_deg, rotation_chance;
    double blur, brightness, contrast, saturation, hue;
    double background;              /* chance of another background */
} train_data_config;

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
    const char *const *set;         /* n_set overrides, borrowed; for messages */
    int n_set;
    const model_class *model;
    struct cJSON *tree;             /* as read, overrides included; owned by the config */
    struct cJSON *model_keys;       /* group "model" without "name"; owned by the config */
    train_data_config data;
    train_optim_config optim;
    train_loop_config loop;
} train_config;

/**
 * train_config_load - read a configuration
 *
 *   arena   owns the texts of the config
 *   path    a JSON file
 *   set     n_set overrides like "optim.lr=3e-4", applied in order; they must outlive the config
 *
 * End with train_config_fini. Errors: LT_EINVAL, or LT_EUSAGE when an override is at fault, with the place and, for a
 * key that does not exist, the nearest that does; those of lt_json_read. The model's own keys are checked when
 * the model is made.
 */
lt_status train_config_load(lt_arena *arena, const char *path, const char *const *set, int n_set,
                            train_config *out);

/* train_config_parse - the same from text that a checkpoint carries; name is for messages */
lt_status train_config_parse(lt_arena *arena, const char *name, const char *text, const char *const *set,
                             int n_set, train_config *out);
void train_config_fini(train_config *c);

/**
 * train_config_model - make the model that the configuration names, with initial values of its seed
 *
 * hand and set must outlive it. Errors: those of the model's keys, LT_EUSAGE when an override is at fault, LT_ENOMEM.
 */
lt_status train_config_model(const train_config *c, const lt_hand_layer *hand, lt_params *set, model *out);

/* train_config_describe - the same without values (lt_params_defer), which a checkpoint brings */
lt_status train_config_describe(const train_config *c, const lt_hand_layer *hand, lt_params *set, model *out);

/* train_config_json - every key with its value, m's own included; the caller frees it with cJSON_Delete; NULL
 * without memory */
struct cJSON *train_config_json(const train_config *c, const model *m);

/* train_setup_name, train_filter_name - data.setup and data.filter as dataset_open takes them */
const char *train_setup_name(const train_config *c);
const char *train_filter_name(const train_config *c);

/* train_config_help - all keys of all groups and models: type, default, range, meaning */
void train_config_help(FILE *f);

#endif
