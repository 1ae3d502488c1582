/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Structs filled from JSON objects by a table of documented keys. Unknown keys are refused with the
 * nearest known one, so a typing error never passes for a setting.
 */
#ifndef LT_IO_TEXT_CONFIG_H
#define LT_IO_TEXT_CONFIG_H

#include "libtensor/base/arena.h"

#ifdef __cplusplus
extern "C" {
#endif

struct cJSON;

typedef enum {
    LT_CONFIG_INT,                  /* int */
    LT_CONFIG_NUMBER,               /* double */
    LT_CONFIG_BOOL,                 /* bool */
    LT_CONFIG_TEXT,                 /* const char *, in the arena */
    LT_CONFIG_CHOICE,               /* int: index into choices */
    LT_CONFIG_INTS,                 /* int[4], as a list of four */
} lt_config_type;

typedef struct {
    const char *name;               /* NULL ends a table */
    lt_config_type type;
    size_t offset;                  /* in the struct */
    const char *fallback;           /* JSON text of the default: "32", "true", "\"adam\"" */
    double lo, hi;                  /* of LT_CONFIG_INT and LT_CONFIG_NUMBER, both allowed; 0, 0: any */
    const char *const *choices;     /* NULL-terminated */
    const char *doc;                /* one line, with the unit */
} lt_config_key;

/**
 * lt_config_read - fill *out from object
 *
 *   where    the object's place in the file, for messages: "train.json: optim"
 *   object   NULL: all defaults
 *
 * Errors: LT_EINVAL with a line like `train.json: optim.lrr: no such key; did you mean "lr"?`
 */
LT_API lt_status lt_config_read(lt_arena *arena, const char *where, const struct cJSON *object,
                                const lt_config_key *keys, void *out);

/* lt_config_write - the struct as an object with every key in the table's order; the caller frees it with
 * cJSON_Delete; NULL without memory */
LT_API struct cJSON *lt_config_write(const lt_config_key *keys, const void *from);

/**
 * lt_config_set - put one override into a tree: "optim.lr=3e-4"
 *
 *   where   whose override it is, for messages: "--set"
 *
 * The value is JSON; what is no JSON is taken as text. Objects on the way are made when they are
 * missing; whether the key exists is lt_config_read's to say. Errors: LT_EUSAGE, LT_ENOMEM.
 */
LT_API lt_status lt_config_set(struct cJSON *root, const char *where, const char *assignment);

/**
 * lt_config_blame - after an error: what an override says is not in the file that it overrides
 *
 *   path    the file, with which the last error's line begins; "" where there is none
 *   where   whose overrides they are, for messages: "--set"
 *   set     the n overrides
 *   st      the error's status
 *
 * Returns LT_EUSAGE, with a line like `--set optim.lrr: no such key`, when the error is about a key of the
 * overrides; else st, and the line stays.
 */
LT_API lt_status lt_config_blame(const char *path, const char *where, const char *const *set, int n, lt_status st);

#ifdef __cplusplus
}
#endif
#endif
