/* SPDX-License-Identifier: Apache-2.0 */
/* A picture's truth as a mirror shows it. */
#include "data/body/rows.h"

#include <string.h>

/* First of the left ones, first of the right ones, how many */
typedef struct { int left, right, n; } sides;

/* Of joints left and right ones follow each other in the body, and stand in two rows of fingers. */
static const sides joints[] = {
    { BODY_HIP, BODY_HIP + 1, 1 }, { BODY_KNEE, BODY_KNEE + 1, 1 }, { BODY_ANKLE, BODY_ANKLE + 1, 1 },
    { BODY_FOOT, BODY_FOOT + 1, 1 }, { BODY_COLLAR, BODY_COLLAR + 1, 1 }, { BODY_SHOULDER, BODY_SHOULDER + 1, 1 },
    { BODY_ELBOW, BODY_ELBOW + 1, 1 }, { BODY_WRIST, BODY_WRIST + 1, 1 }, { BODY_EYE, BODY_EYE + 1, 1 },
    { BODY_FINGERS, BODY_FINGERS + BODY_HAND_JOINTS, BODY_HAND_JOINTS },
};

/* Nodes: hips, knees, ankles, shoulders, elbows, wrists, feet, ears, eyes, hands */
static const sides nodes[] = {
    { 1, 2, 1 }, { 3, 4, 1 }, { 5, 6, 1 }, { 8, 9, 1 }, { 10, 11, 1 }, { 12, 13, 1 }, { 14, 17, 3 }, { 20, 21, 1 },
    { 22, 23, 1 }, { 25, 45, 20 },
};

static const sides hands = { 0, 1, 1 };

/* size: bytes of one */
static void swap(void *list, size_t size, const sides *s)
{
    uint8_t *left = (uint8_t *)list + (size_t)s->left * size, *right = (uint8_t *)list + (size_t)s->right * size;

    for (size_t i = 0; i < (size_t)s->n * size; i++) {
        const uint8_t kept = left[i];

        left[i] = right[i];
        right[i] = kept;
    }
}

static void turn_over(body_row *row, float last)
{
    for (int i = 0; i < BODY_JOINTS; i++)
        for (int k = 1; k < 3; k++)
            row->pose[i][k] = -row->pose[i][k];
    for (int i = 0; i < BODY_NODES; i++) {
        row->nodes_3d[i][0] = -row->nodes_3d[i][0];
        row->nodes_2d[i][0] = last - row->nodes_2d[i][0];
    }
    for (int i = 0; i < BODY_BOXES; i++)
        if (row->boxes[i][2] > row->boxes[i][0]) {
            const float x0 = row->boxes[i][0];

            row->boxes[i][0] = last - row->boxes[i][2];
            row->boxes[i][2] = last - x0;
        }
    row->trans[0] = -row->trans[0];
    row->K[0][2] = last - row->K[0][2];
}

void body_row_mirror(body_row *row, int width)
{
    turn_over(row, (float)(width - 1));
    for (size_t i = 0; i < LT_COUNT(joints); i++)
        swap(row->pose, sizeof(row->pose[0]), &joints[i]);
    for (size_t i = 0; i < LT_COUNT(nodes); i++) {
        swap(row->nodes_3d, sizeof(row->nodes_3d[0]), &nodes[i]);
        swap(row->nodes_2d, sizeof(row->nodes_2d[0]), &nodes[i]);
        swap(row->seen, sizeof(row->seen[0]), &nodes[i]);
    }
    swap(row->boxes, sizeof(row->boxes[0]), &hands);
    swap(row->holds, sizeof(row->holds[0]), &hands);
}
