/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The command line of `palmar eval`.
 */
#ifndef CLI_EVAL_ARGS_H
#define CLI_EVAL_ARGS_H

#include "cli/cli.h"
#include "eval/tables/require.h"

enum { EVAL_REQUIREMENTS = 64, EVAL_LPIPS_FILES = 2 };

typedef struct {
    const char *checkpoint, *data, *split, *setup, *filter, *models, *hand, *out, *submit, *pred;
    int batch, limit, meshes;      /* meshes: -1 where nothing was said */
    eval_requirement require[EVAL_REQUIREMENTS];
    int n_require;
    const char *lpips[EVAL_LPIPS_FILES];
    int n_lpips;
    cli_overrides over;
    const char *runs;               /* of --claims or --tables */
    bool json, no_bench, claims, tables;
} eval_args;

/* eval_argp - for argp_parse, with an eval_args */
extern const struct argp eval_argp;

#endif
