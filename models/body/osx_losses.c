/* SPDX-License-Identifier: Apache-2.0 */
#include "models/body/osx_losses.h"

#include "models/body/osx_parts.h"

#include <math.h>

static const double CELL = OSX_WIDTH / (double)OSX_COLUMNS;

void osx_loss_add(model_record *r, const char *name, lt_tensor *loss, double weight)
{
    loss = lt_output(weight == 1 ? loss : lt_scale(loss, weight), name);
    model_port_add(&r->losses, name, loss);
    r->loss = r->loss ? lt_add(r->loss, loss) : loss;
}

lt_tensor *osx_l1(const model_record *r, lt_tensor *a, lt_tensor *b, lt_tensor *known)
{
    if (known) {
        known = lt_reshape(known, LT_SHAPE(lt_dim(known, 0), lt_dim(known, 1), 1));
        a = lt_mul(a, known);
        b = lt_mul(b, known);
    }
    return lt_l1_loss(a, b, model_port_find(&r->inputs, "weight"));
}

/* Of the body's joints: the jaw stands before the hands there, and the eyes, which look ahead, behind it */
static lt_tensor *rig_rotations(lt_tensor *R)
{
    const int hands = OSX_BODY_ROTATIONS, jaw = hands + 2 * OSX_HAND_ROTATIONS;
    const lt_real ahead[2 * 9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1 };
    lt_tensor *eyes = lt_constant(R->graph, LT_F32, LT_SHAPE(2, 3, 3), ahead);

    eyes = lt_add(lt_scale(lt_slice(R, 1, 0, 2), 0), eyes);             /* of any number of samples */
    return lt_concat((lt_tensor *[]){ lt_slice(R, 1, 0, hands), lt_slice(R, 1, jaw, 1), eyes,
                                      lt_slice(R, 1, hands, 2 * OSX_HAND_ROTATIONS) }, 4, 1);
}

/* (B, N, 3) -> (B, N, 2) */
static lt_tensor *bearings(lt_tensor *points)
{
    lt_tensor *direction = lt_l2_normalise(lt_permute(points, (int[]){ 0, 2, 1 }), 1e-9);

    return lt_scale(lt_permute(lt_slice(direction, 1, 0, 2), (int[]){ 0, 2, 1 }), OSX_FOCAL / CELL);
}

void osx_bearing(const double point[3], double out[2])
{
    const double length = sqrt(point[0] * point[0] + point[1] * point[1] + point[2] * point[2]);

    for (int k = 0; k < 2; k++)
        out[k] = point[k] / length * (OSX_FOCAL / CELL);
}

void osx_skin(const lt_skin_layer *body, const osx_weights *weights, model_record *r)
{
    const int64_t B = r->batch;
    lt_tensor *R = model_port_find(&r->outputs, "rotation"), *camera = model_port_find(&r->outputs, "camera");
    lt_tensor *shape = lt_concat((lt_tensor *[]){ model_port_find(&r->outputs, "shape"),
                                                  model_port_find(&r->outputs, "expression") }, 2, 1);
    lt_tensor *vertices = lt_skin(body, rig_rotations(R), shape), *nodes = lt_result(vertices, 1), *seen;

    model_port_add(&r->outputs, "vertices", lt_output(vertices, "vertices"));
    model_port_add(&r->outputs, "nodes", lt_output(nodes, "nodes"));
    if (!weights)
        return;
    osx_loss_add(r, "nodes", osx_l1(r, nodes, model_input(r, "nodes", nodes->shape), NULL), weights->nodes);
    seen = bearings(lt_add(nodes, lt_reshape(camera, LT_SHAPE(B, 1, 3))));
    osx_loss_add(r, "bearing", osx_l1(r, seen, model_input(r, "bearing", seen->shape),
                                      model_input(r, "node_known", LT_SHAPE(B, OSX_NODES))), 1);
    lt_output(r->loss, "loss with the skin's");
}
