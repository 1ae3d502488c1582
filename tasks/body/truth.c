/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/body/truth.h"

#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <stdlib.h>

enum { CHECKED = 3 };                           /* pictures, spread over the set */
static const double ROUNDING = 1e-3;            /* metres by which nodes may be elsewhere */

void body_truth(const body_model *m, const body_row *row, double (*vertices)[3], double nodes[BODY_NODES][3])
{
    const lt_rig rig = synth_body_rig(m);
    double R[BODY_JOINTS][9], shape[BODY_DIRECTIONS], trans[3], joints[BODY_JOINTS][3];

    for (int j = 0; j < BODY_JOINTS; j++)
        lt_rot_from_axis_angle((double[]){ row->pose[j][0], row->pose[j][1], row->pose[j][2] }, R[j]);
    for (int k = 0; k < BODY_SHAPES; k++)
        shape[k] = row->shape[k];
    for (int k = 0; k < BODY_EXPRESSIONS; k++)
        shape[BODY_SHAPES + k] = row->expression[k];
    for (int k = 0; k < 3; k++)
        trans[k] = row->trans[k];
    lt_rig_pose(&rig, R[0], shape, trans, vertices[0], joints[0]);
    body_nodes(vertices[0], joints[0], nodes);
}

lt_status body_truth_check(const run_body *b, const body_set *set)
{
    double (*vertices)[3] = malloc(BODY_VERTICES * sizeof(*vertices)), most = 0;

    if (!vertices)
        return lt_error(LT_ENOMEM, "no memory for a body");
    for (int i = 0; i < CHECKED; i++) {
        const body_row *row = &set->row[i * set->n / CHECKED];
        double nodes[BODY_NODES][3];

        body_truth(b->model, row, vertices, nodes);
        for (int k = 0; k < BODY_NODES; k++)
            for (int a = 0; a < 3; a++)
                most = fmax(most, fabs(nodes[k][a] - (double)row->nodes_3d[k][a]));
    }
    free(vertices);
    if (most > ROUNDING)
        return lt_error(LT_EINVAL, "%s: its poses were made with another body than %s: posed by them, nodes are up to "
                        "%.1f mm elsewhere; name the body that they belong to, such as %s/body.npz, with --body",
                        set->root, b->name, 1000 * most, set->root);
    return LT_OK;
}
