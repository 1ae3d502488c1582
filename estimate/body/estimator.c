/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/body/estimator.h"

#include "libtensor/geometry/rotation.h"
#include "models/body/osx_losses.h"
#include "models/body/osx_parts.h"
#include "vision/person_window.h"

#include <math.h>
#include <string.h>

lt_status body_estimator_open(const char *path, body_estimator *out)
{
    body_estimator *e = out;
    lt_skin_layer *layer;
    recipe by;
    lt_status st;

    *e = (body_estimator){ .c = { .plan = NULL } };
    st = trained_open(path, "body", NULL, &e->t);
    if (!st)
        st = run_body_open(e->t.arena, e->t.body, &e->body);
    if (!st)
        st = run_body_nodes_layer(e->t.arena, e->body.model, &layer);
    if (st)
        return st;
    e->graph = (body_graph){ .model = &e->t.m, .layer = layer };
    by = body_graph_recipe(&e->graph, false);
    return compiled_new(&by, 1, false, &e->c);
}

void body_estimator_close(body_estimator *e)
{
    compiled_free(&e->c);
    trained_close(&e->t);
}

/* ---- what the network says ------------------------------------------------------------------------------- */

static bool finite_outputs(const compiled *c)
{
    static const struct { const char *name; int n; } output[] = {
        { "nodes", 3 * BODY_NODES }, { "camera", 3 }, { "rotation", 9 * BODY_ROTATIONS }, { "shape", BODY_SHAPES },
        { "expression", BODY_EXPRESSIONS },
    };
    float sum = 0;

    for (size_t i = 0; i < LT_COUNT(output); i++)
        for (int k = 0; k < output[i].n; k++)
            sum += (float)compiled_output(c, output[i].name)[k];
    return isfinite(sum);
}

static void read_parameters(const compiled *c, body_estimate *out)
{
    const lt_real *R = compiled_output(c, "rotation"), *shape = compiled_output(c, "shape");
    const lt_real *expression = compiled_output(c, "expression");

    memset(out->pose, 0, sizeof(out->pose));
    for (int i = 0; i < BODY_ROTATIONS; i++) {
        double turn[9];

        for (int k = 0; k < 9; k++)
            turn[k] = R[9 * i + k];
        lt_rot_to_axis_angle(turn, out->pose[body_graph_joint(i)]);
    }
    for (int k = 0; k < BODY_SHAPES; k++)
        out->shape[k] = shape[k];
    for (int k = 0; k < BODY_EXPRESSIONS; k++)
        out->expression[k] = expression[k];
}

/* The virtual camera sees the person through a long lens, from so far away that depth within the body hardly counts: as
 * many pixels a metre, in the picture's own camera, are that much nearer. */
static void place(const compiled *c, const person_window *w, const lt_camera *camera, body_estimate *out)
{
    const double far = (double)compiled_output(c, "camera")[2] + out->nodes[0][2];
    const double z = sqrt(camera->fx * camera->fy) * w->scale * far / OSX_FOCAL;
    const double uv[2] = { out->nodes2d[0][0], out->nodes2d[0][1] };

    lt_camera_backproject(camera, uv, z, out->pelvis);
}

static void read_body(const compiled *c, const person_window *w, const lt_camera *camera, body_estimate *out)
{
    body_graph_nodes(c, 0, out->nodes);
    body_graph_project(c, 0, out->nodes2d);
    for (int i = 0; i < BODY_NODES; i++)
        for (int k = 0; k < 2; k++)
            out->nodes2d[i][k] = (float)(((double)out->nodes2d[i][k] - w->shift[k]) / w->scale);
    place(c, w, camera, out);
    read_parameters(c, out);
}

lt_status body_estimator_run(body_estimator *e, const uint8_t *rgb, int width, int height, const float box[4],
                             const lt_camera *camera, body_estimate *out)
{
    const double around[4] = { box[0], box[1], box[2], box[3] };
    const lt_image picture = { width, height, 3, 8, (uint8_t *)rgb };
    lt_real *image = lt_plan_data(e->c.plan, model_port_find(&e->c.record.inputs, "image"));
    person_window w;

    if (!(box[2] > box[0] && box[3] > box[1] && isfinite(box[2] - box[0]) && isfinite(box[3] - box[1])))
        return lt_error(LT_EINVAL, "the person's box %g,%g,%g,%g is empty", (double)box[0], (double)box[1],
                        (double)box[2], (double)box[3]);
    w = person_window_around(around, OSX_WIDTH, OSX_HEIGHT);
    person_window_cut(&w, &picture, OSX_WIDTH, OSX_HEIGHT, image);
    lt_run(e->c.plan);
    if (!finite_outputs(&e->c))
        return lt_error(LT_ENUMERIC, "%s: the model's answer is not finite: its weights are damaged", e->t.path);
    read_body(&e->c, &w, camera, out);
    return LT_OK;
}
