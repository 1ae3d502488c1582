/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/body/mean_pose.h"

#include "tasks/body/truth.h"

#include <string.h>

enum { POSED = 200 };

static void add_nodes(const body_row *row, double n, mean_pose *m)
{
    for (int i = 0; i < BODY_NODES; i++)
        for (int k = 0; k < 3; k++)
            m->nodes[i][k] += (row->nodes_3d[i][k] - row->nodes_3d[0][k]) / n;
}

lt_status mean_pose_of(lt_arena *arena, const body_model *body, const body_set *set, mean_pose **out)
{
    const int64_t posed = lt_min_i64(POSED, set->n);
    mean_pose *m = lt_arena_alloc(arena, sizeof(*m));
    double (*vertices)[3] = lt_arena_array(arena, BODY_VERTICES, sizeof(*vertices));

    if (!m || !vertices)
        return lt_error(LT_ENOMEM, "no memory for the mean pose");
    memset(m, 0, sizeof(*m));
    for (int64_t i = 0; i < set->n; i++)
        add_nodes(&set->row[i], (double)set->n, m);
    for (int64_t i = 0; i < posed; i++) {
        double nodes[BODY_NODES][3];

        body_truth(body, &set->row[i * set->n / posed], vertices, nodes);
        for (int v = 0; v < BODY_VERTICES; v++)
            for (int k = 0; k < 3; k++)
                m->vertices[v][k] += (vertices[v][k] - nodes[0][k]) / (double)posed;
    }
    *out = m;
    return LT_OK;
}
