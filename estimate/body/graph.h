/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An osx with the body that it makes: recorded, and what a run of it says.
 */
#ifndef ESTIMATE_BODY_GRAPH_H
#define ESTIMATE_BODY_GRAPH_H

#include "assets/body/body.h"
#include "estimate/compiled.h"
#include "libtensor/geometry/skin/skin.h"

enum { BODY_ROTATIONS = 53 };       /* that the network gives */

typedef struct {
    const model *model;
    const lt_skin_layer *layer;     /* run_body_layer's */
} body_graph;

/* body_graph_recipe - with its losses, or without; g outlives it. It feeds nothing. */
recipe body_graph_recipe(const body_graph *g, bool losses);

/* body_graph_joint - the body model's joint that the network's i-th rotation is of */
int body_graph_joint(int i);

/* After a run, of the i-th sample: body_graph_nodes - from the pelvis in camera axes, metres; body_graph_project -
 * where the virtual camera sees them, pixels of the network's picture */
void body_graph_nodes(const compiled *c, int i, double out[BODY_NODES][3]);
void body_graph_project(const compiled *c, int i, float out[BODY_NODES][2]);

#endif
