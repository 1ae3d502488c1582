/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An osx with the body that it makes, recorded and fed.
 */
#ifndef TASKS_BODY_GRAPH_H
#define TASKS_BODY_GRAPH_H

#include "estimate/compiled.h"
#include "libtensor/geometry/skin/skin.h"
#include "tasks/body/batch.h"

typedef struct {
    const model *model;
    const lt_skin_layer *layer;     /* run_body_layer's */
} body_graph;

/* body_graph_recipe - with its losses, or without; g outlives it */
recipe body_graph_recipe(const body_graph *g, bool losses);

/* After a run, of the i-th sample: body_graph_nodes - from the pelvis, metres; body_graph_project - where the virtual
 * camera sees them, pixels */
void body_graph_nodes(const compiled *c, int i, double out[BODY_NODES][3]);
void body_graph_project(const compiled *c, int i, float out[BODY_NODES][2]);

#endif
