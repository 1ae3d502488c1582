/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The body model of a run: SMPL-X's file where it is, the synthetic body elsewhere.
 */
#ifndef ASSETS_RUN_BODY_H
#define ASSETS_RUN_BODY_H

#include "assets/body/body.h"
#include "libtensor/geometry/skin/skin.h"

typedef struct {
    body_model *model;              /* with BODY_SHAPES and BODY_EXPRESSIONS directions, the first of a file's */
    const char *name;               /* of the file, or "embedded synthetic body" */
    const char *path;               /* what names the same body again, whatever $PALMAR_BODY says then */
} run_body;

/**
 * run_body_open - the body, in the arena
 *
 *   path     SMPLX_NEUTRAL.npz or another of its files, also as .pkl; "embedded": the synthetic body; NULL or "": what
 *            $PALMAR_BODY names; without that the synthetic body
 *
 * Errors: those of body_file_read; a file that is not there names the page that offers it.
 */
lt_status run_body_open(lt_arena *arena, const char *path, run_body *out);

/* run_body_is_embedded - the synthetic body, not somebody's file */
bool run_body_is_embedded(const run_body *b);

/* run_body_note - one line that says how to have SMPL-X instead of the synthetic body */
const char *run_body_note(void);

/* run_body_layer - what networks pose it by; its points are the 65 nodes. Errors: those of lt_skin_layer_new. */
lt_status run_body_layer(lt_arena *arena, const body_model *m, lt_skin_layer **out);

/* run_body_nodes_layer - the same for who wants the nodes alone: it has hardly any vertices but those */
lt_status run_body_nodes_layer(lt_arena *arena, const body_model *m, lt_skin_layer **out);

#endif
