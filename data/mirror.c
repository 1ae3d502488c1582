/* SPDX-License-Identifier: Apache-2.0 */
#include "data/mirror.h"

#include <assert.h>
#include <string.h>

void mirror_point(float p[3])
{
    p[0] = -p[0];
}

void mirror_rotation(float R[9])
{
    R[1] = -R[1];
    R[2] = -R[2];
    R[3] = -R[3];
    R[6] = -R[6];
}

void mirror_pose(double R[9], double t[3])
{
    R[1] = -R[1];
    R[2] = -R[2];
    R[3] = -R[3];
    R[6] = -R[6];
    t[0] = -t[0];
}

void mirror_model(double R[9], bool mirrored)
{
    for (int i = 0; i < 9 && mirrored; i += 3)
        R[i] = -R[i];
}

void mirror_camera(lt_camera *camera, int width)
{
    camera->cx = width - 1 - camera->cx;
}

void mirror_plane(void *plane, int width, int height, size_t size)
{
    uint8_t cell[16];

    assert(size <= sizeof(cell));
    for (int y = 0; plane && y < height; y++) {
        uint8_t *a = (uint8_t *)plane + (size_t)y * (size_t)width * size, *b = a + ((size_t)width - 1) * size;
        for (; a < b; a += size, b -= size) {
            memcpy(cell, a, size);
            memcpy(a, b, size);
            memcpy(b, cell, size);
        }
    }
}

static void mirror_pixels(float (*p)[2], int n, int width)
{
    for (int i = 0; i < n; i++)
        p[i][0] = (float)(width - 1) - p[i][0];
}

static void mirror_hand(dataset_sample *s)
{
    const float right = (float)(s->width - 1), x0 = s->hand_box[0];

    if (s->flags & SAMPLE_HAND_POSE)
        for (int j = 0; j < LT_HAND_JOINTS; j++)
            mirror_rotation(s->rotation[j]);
    if (s->flags & SAMPLE_JOINTS) {
        for (int j = 0; j < LT_HAND_KEYPOINTS; j++)
            mirror_point(s->joints[j]);
        mirror_pixels(s->joints2d, LT_HAND_KEYPOINTS, s->width);
    }
    if (s->flags & SAMPLE_ROOT)
        mirror_point(s->root);
    if (s->flags & SAMPLE_HAND_BOX) {
        s->hand_box[0] = right - s->hand_box[2];
        s->hand_box[2] = right - x0;
    }
}

void mirror_sample(dataset_sample *s, uint8_t *rgb, float *depth, uint8_t *silhouette)
{
    assert(!s->vertices);
    mirror_plane(rgb, s->width, s->height, 3);
    mirror_plane(depth, s->width, s->height, sizeof(*depth));
    mirror_plane(silhouette, s->width, s->height, 1);
    mirror_camera(&s->camera, s->width);
    mirror_hand(s);
    if (s->flags & SAMPLE_OBJECT) {
        mirror_rotation(s->R);
        mirror_point(s->t);
        mirror_pixels(s->control2d, 21, s->width);
    }
    s->flags ^= SAMPLE_MIRRORED;
}
