/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/run_body.h"

#include "assets/hand/hand.h"
#include "libtensor/io/file.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define OFFERED "SMPLX_NEUTRAL.npz is offered by its authors, after registration, at https://smpl-x.is.tue.mpg.de"

static const char EMBEDDED[] = "embedded";

const char *run_body_note(void)
{
    return "using the embedded synthetic body; " OFFERED ", and is named by --body, data.body or PALMAR_BODY";
}

bool run_body_is_embedded(const run_body *b)
{
    return strcmp(b->path, EMBEDDED) == 0;
}

/* Of files with hundreds of directions, the ten of each kind that explain most. */
static lt_status keep_first(lt_arena *arena, body_model *m)
{
    const size_t all = (size_t)(m->shapes + m->expressions), rows = (size_t)BODY_VERTICES * 3;
    float *kept;

    if (m->shapes == BODY_SHAPES && m->expressions == BODY_EXPRESSIONS)
        return LT_OK;
    kept = lt_arena_array(arena, rows * BODY_DIRECTIONS, sizeof(*kept));
    if (!kept)
        return lt_error(LT_ENOMEM, "no memory for the body model");
    for (size_t i = 0; i < rows; i++) {
        memcpy(kept + i * BODY_DIRECTIONS, m->shapedirs + i * all, BODY_SHAPES * sizeof(*kept));
        memcpy(kept + i * BODY_DIRECTIONS + BODY_SHAPES, m->shapedirs + i * all + m->shapes,
               BODY_EXPRESSIONS * sizeof(*kept));
    }
    m->shapedirs = kept;
    m->shapes = BODY_SHAPES;
    m->expressions = BODY_EXPRESSIONS;
    return LT_OK;
}

static lt_status make_synthetic(lt_arena *arena, run_body *b)
{
    lt_hand_model *hand;
    synth_body body;
    lt_status st = synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand);

    if (!st)
        st = synth_body_new(arena, hand, &body);
    if (!st)
        *b = (run_body){ body.model, "embedded synthetic body", EMBEDDED };
    return st;
}

static lt_status read_file(lt_arena *arena, const char *path, run_body *b)
{
    lt_status st;

    if (access(path, F_OK) != 0)
        return lt_error(LT_EIO, "%s: no such file; %s; without it the embedded body is used", path, OFFERED);
    b->path = lt_path_whole(arena, path);
    b->name = lt_arena_strdup(arena, path);
    if (!b->path || !b->name)
        return lt_error(LT_ENOMEM, "no memory for the body model");
    st = body_file_read(arena, path, &b->model);
    return st ? st : keep_first(arena, b->model);
}

lt_status run_body_open(lt_arena *arena, const char *path, run_body *out)
{
    run_body b = { .model = NULL };
    lt_status st;

    if (!path || !*path)
        path = getenv("PALMAR_BODY");
    if (!path || !*path)
        path = EMBEDDED;
    st = strcmp(path, EMBEDDED) == 0 ? make_synthetic(arena, &b) : read_file(arena, path, &b);
    if (!st)
        *out = b;
    return st;
}

lt_status run_body_layer(lt_arena *arena, const body_model *m, lt_skin_layer **out)
{
    const lt_rig rig = synth_body_rig(m);

    return lt_skin_layer_new(arena, &rig, body_node, BODY_NODES, out);
}

lt_status run_body_nodes_layer(lt_arena *arena, const body_model *m, lt_skin_layer **out)
{
    int points[BODY_NODES];
    lt_rig rig;
    const lt_status st = synth_body_nodes_rig(arena, m, &rig, points);

    return st ? st : lt_skin_layer_new(arena, &rig, points, BODY_NODES, out);
}
