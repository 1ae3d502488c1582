/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/body/graph.h"

#include "models/body/osx.h"
#include "models/body/osx_parts.h"

static void record_with(const body_graph *g, bool losses, model_record *r)
{
    const osx_weights weights = osx_weights_of(g->model);

    g->model->cls->record(g->model, losses, r);
    osx_skin(g->layer, losses ? &weights : NULL, r);
}

static lt_status record(const void *ctx, model_record *r)
{
    record_with(ctx, false, r);
    return LT_OK;
}

static lt_status record_losses(const void *ctx, model_record *r)
{
    record_with(ctx, true, r);
    return LT_OK;
}

recipe body_graph_recipe(const body_graph *g, bool losses)
{
    return (recipe){ .ctx = g, .record = losses ? record_losses : record };
}

int body_graph_joint(int i)
{
    return i < OSX_BODY_ROTATIONS ? i : i < BODY_ROTATIONS - 1 ? i - OSX_BODY_ROTATIONS + BODY_FINGERS : BODY_JAW;
}

void body_graph_nodes(const compiled *c, int i, double out[BODY_NODES][3])
{
    const lt_real *x = compiled_output(c, "nodes") + (size_t)i * BODY_NODES * 3;

    for (int k = 0; k < BODY_NODES * 3; k++)
        out[k / 3][k % 3] = x[k];
}

void body_graph_project(const compiled *c, int i, float out[BODY_NODES][2])
{
    const lt_real *camera = compiled_output(c, "camera") + (size_t)i * 3;
    double nodes[BODY_NODES][3];

    body_graph_nodes(c, i, nodes);
    for (int k = 0; k < BODY_NODES; k++) {
        const double z = nodes[k][2] + camera[2];

        out[k][0] = (float)(OSX_FOCAL * (nodes[k][0] + camera[0]) / z + OSX_WIDTH / 2.0);
        out[k][1] = (float)(OSX_FOCAL * (nodes[k][1] + camera[1]) / z + OSX_HEIGHT / 2.0);
    }
}
