/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/body/scores.h"

#include "eval/metrics/metrics.h"
#include "tasks/body/batch.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

enum { WRIST = 12, HAND = BODY_OF_HANDS / 2 };

const char *const body_score_keys[] = {
    [BODY_MPJPE] = "mpjpe_mm", [BODY_HAND_MPJPE] = "hand_mpjpe_mm", [BODY_PA_MPJPE] = "pa_mpjpe_mm",
    [BODY_PVE] = "pve_mm", NULL,
};

/* Mean error of n points, point `root` of p put on that of g */
static double from_root(int n, const double (*p)[3], const double (*g)[3], const double root_p[3],
                        const double root_g[3])
{
    double sum = 0;

    for (int i = 0; i < n; i++) {
        double d[3];

        for (int k = 0; k < 3; k++)
            d[k] = (p[i][k] - root_p[k]) - (g[i][k] - root_g[k]);
        sum += sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    }
    return 1000 * sum / n;
}

void body_errors_of(const double (*nodes)[3], const double (*true_nodes)[3], const double (*vertices)[3],
                    const double (*true_vertices)[3], body_errors *out)
{
    double aligned[BODY_OF_BODY][3];

    out->mm[BODY_MPJPE] = from_root(BODY_OF_BODY, nodes, true_nodes, nodes[0], true_nodes[0]);
    out->mm[BODY_HAND_MPJPE] = 0;
    for (int side = 0; side < 2; side++) {
        const int first = BODY_OF_BODY + side * HAND, wrist = WRIST + side;

        out->mm[BODY_HAND_MPJPE] += from_root(HAND, nodes + first, true_nodes + first, nodes[wrist], true_nodes[wrist])
                                    / 2;
    }
    eval_align_procrustes(EVAL_RIGID, BODY_OF_BODY, nodes[0], true_nodes[0], aligned[0]);
    out->mm[BODY_PA_MPJPE] = 1000 * eval_mpjpe(BODY_OF_BODY, aligned[0], true_nodes[0]);
    out->mm[BODY_PVE] = vertices ? from_root(BODY_VERTICES, vertices, true_vertices, nodes[0], true_nodes[0]) : NAN;
}

static void add_errors(cJSON *to, const body_errors *e)
{
    for (int k = 0; k < BODY_METRICS; k++)
        cJSON_AddNumberToObject(to, body_score_keys[k], e->mm[k]);
}

cJSON *body_scores_json(const body_scores *s)
{
    cJSON *root = cJSON_CreateObject();

    add_errors(root, &s->model);
    add_errors(cJSON_AddObjectToObject(root, "mean_pose"), &s->mean_pose);
    cJSON_AddNumberToObject(root, "images", (double)s->images);
    cJSON_AddNumberToObject(root, "subjects", s->subjects);
    cJSON_AddBoolToObject(root, "synthetic", s->synthetic);
    return root;
}

void body_scores_print(const body_scores *s, FILE *f)
{
    static const char *const names[BODY_METRICS] = { "joints", "hands' joints", "joints, PA", "vertices" };

    fprintf(f, "%spictures of persons: %lld, of %d subjects; mean errors in mm, pelvis on pelvis, hands wrist on wrist"
            "\n\n%-14s %8s %10s\n", s->synthetic ? "SYNTHETIC, " : "", (long long)s->images, s->subjects, "", "model",
            "mean pose");
    for (int k = 0; k < BODY_METRICS; k++)
        fprintf(f, "%-14s %8.1f %10.1f\n", names[k], s->model.mm[k], s->mean_pose.mm[k]);
}
