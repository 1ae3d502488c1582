/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What looks at pictures beside a model of hands, in `palmar predict` and `palmar watch`: a detector, a network for
 * bodies, one that tells looks.
 */
#ifndef CLI_VISION_MODELS_H
#define CLI_VISION_MODELS_H

#include "estimate/body/estimator.h"
#include "estimate/detection/detector.h"
#include "estimate/embedder.h"

/* Runs or files, as the options --detector, --body and --reid name them; NULL: none */
typedef struct {
    const char *detector, *body, *reid;
} cli_vision_names;

/* Each is NULL where none is named. Zeroed at first; it stays where it is while it is open. */
typedef struct {
    detector *detector;
    body_estimator *body;
    embedder *embedder;
    detector own_detector;          /* memory of the first two */
    body_estimator own_body;
} cli_vision_models;

/* cli_vision_models_open - those that are named; cli_vision_models_close frees them, also after a failure. Errors:
 * those of opening each */
lt_status cli_vision_models_open(const cli_vision_names *names, cli_vision_models *out);
void cli_vision_models_close(cli_vision_models *m);

/* cli_starter_find - the weights of a small model that comes with palmar, by its role (estimate/starter.h), in arena
 * memory. Errors: those of starter_find */
lt_status cli_starter_find(lt_arena *arena, const char *role, const char **out);

#endif
