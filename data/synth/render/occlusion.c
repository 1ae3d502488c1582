/* SPDX-License-Identifier: Apache-2.0 */
#include "data/synth/render/occlusion.h"
#include "data/synth/render/small.h"
#include "libtensor/base/parallel.h"


enum { DIRECTIONS = 6, STEPS = 3 };

static const float RADIUS = 0.06f;              /* metres */
static const float STRENGTH = 1.7f;

typedef struct {
    const synth_camera *camera;
    const float *depth;
    float *open;
    const float *rough;
    int width, height;              /* of open */
    float per_fx, per_fy, cx, cy;
} occlusion_job;

static void unproject(const occlusion_job *job, int x, int y, float z, float p[3])
{
    p[0] = ((float)x - job->cx) * job->per_fx * z;
    p[1] = ((float)y - job->cy) * job->per_fy * z;
    p[2] = z;
}

static float depth_at(const occlusion_job *job, int x, int y)
{
    x = x < 0 ? 0 : x < job->camera->width ? x : job->camera->width - 1;
    y = y < 0 ? 0 : y < job->camera->height ? y : job->camera->height - 1;
    return job->depth[(size_t)y * (size_t)job->camera->width + (size_t)x];
}

/* Of the two neighbours along an axis the one on the same surface: the smaller step in depth. */
static void slope(const occlusion_job *job, int x, int y, int dx, int dy, const float p[3], float out[3])
{
    const float before = depth_at(job, x - dx, y - dy), after = depth_at(job, x + dx, y + dy);
    const float sign = fabsf(after - p[2]) < fabsf(before - p[2]) ? 1 : -1;
    float q[3];

    unproject(job, x + (int)sign * dx, y + (int)sign * dy, sign > 0 ? after : before, q);
    for (int i = 0; i < 3; i++)
        out[i] = sign * (q[i] - p[i]);
}

/* The surface's normal at a pixel, towards the camera. */
static void find_normal(const occlusion_job *job, int x, int y, const float p[3], float n[3])
{
    float a[3], b[3];

    slope(job, x, y, 1, 0, p, a);
    slope(job, x, y, 0, 1, p, b);
    cross3(b, a, n);
    normalise3(n);
}

/* How much the point at (x, y) hides of the sky over p. */
static float hidden_by(const occlusion_job *job, int x, int y, const float p[3], const float n[3])
{
    const float z = depth_at(job, x, y);
    float q[3], d2, rise, fade;

    if (z == 0)
        return 0;
    unproject(job, x, y, z, q);
    for (int i = 0; i < 3; i++)
        q[i] -= p[i];
    d2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
    fade = 1 - d2 / (RADIUS * RADIUS);
    if (d2 == 0 || fade <= 0)
        return 0;
    rise = (q[0] * n[0] + q[1] * n[1] + q[2] * n[2]) / sqrtf(d2) - 0.12f;
    return rise > 0 ? rise * fade : 0;
}

static float open_at(const occlusion_job *job, int x, int y)
{
    static const float turn[DIRECTIONS][2] = {
        { 1, 0 }, { 0.5f, 0.8660254f }, { -0.5f, 0.8660254f },
        { -1, 0 }, { -0.5f, -0.8660254f }, { 0.5f, -0.8660254f },
    };
    const float z = depth_at(job, x, y);
    const float angle = 1.0471976f * (float)((x / 2 * 5 + y / 2 * 3) % 8) / 8;
    const float c = cosf(angle), s = sinf(angle);
    float p[3], n[3], hidden = 0, reach;

    if (z == 0)
        return 1;
    reach = least(RADIUS * (float)job->camera->fx / z, 120);
    unproject(job, x, y, z, p);
    find_normal(job, x, y, p, n);
    for (int i = 0; i < DIRECTIONS; i++)
        for (int k = 1; k <= STEPS; k++) {
            const float r = reach * (float)(k * k) / (STEPS * STEPS) * 0.9f + 1;
            const float dx = c * turn[i][0] - s * turn[i][1], dy = s * turn[i][0] + c * turn[i][1];

            hidden += hidden_by(job, x + (int)lrintf(r * dx), y + (int)lrintf(r * dy), p, n);
        }
    return most(1 - STRENGTH * hidden / (DIRECTIONS * STEPS), 0);
}

static void find_row(void *ctx, int64_t y)
{
    const occlusion_job *job = ctx;

    for (int x = 0; x < job->width; x++)
        job->open[(size_t)y * (size_t)job->width + (size_t)x] = open_at(job, 2 * x, 2 * (int)y);
}

/* Averages over the turns of the sampling pattern, but only across pixels of like depth. */
static void smooth_row(void *ctx, int64_t row)
{
    const occlusion_job *job = ctx;
    const int y = (int)row;

    for (int x = 0; x < job->width; x++) {
        const float z = depth_at(job, 2 * x, 2 * y);
        float sum = 0, weight = 0;

        for (int v = y - 2; v <= y + 2; v++)
            for (int u = x - 2; u <= x + 2; u++) {
                if (u < 0 || v < 0 || u >= job->width || v >= job->height)
                    continue;
                const float w = fabsf(depth_at(job, 2 * u, 2 * v) - z) < 0.02f * z ? 1 : 1e-4f;

                sum += w * job->rough[(size_t)v * (size_t)job->width + (size_t)u];
                weight += w;
            }
        job->open[(size_t)y * (size_t)job->width + (size_t)x] = sum / weight;
    }
}

void occlusion_find(const synth_camera *camera, const float *depth, float *open, float *scratch)
{
    occlusion_job job = {
        .camera = camera, .depth = depth, .open = scratch,
        .width = (camera->width + 1) / 2, .height = (camera->height + 1) / 2,
        .per_fx = (float)(1 / camera->fx), .per_fy = (float)(1 / camera->fy),
        .cx = (float)camera->cx, .cy = (float)camera->cy,
    };

    lt_parallel_for(job.height, find_row, &job);
    job.rough = scratch;
    job.open = open;
    lt_parallel_for(job.height, smooth_row, &job);
}

float occlusion_at(const synth_camera *camera, const float *depth, const float *open, int x, int y)
{
    const int w = (camera->width + 1) / 2, h = (camera->height + 1) / 2;
    const float z = depth[(size_t)y * (size_t)camera->width + (size_t)x];
    float sum = 0, weight = 0;

    for (int v = y / 2; v <= (y + 1) / 2 && v < h; v++)
        for (int u = x / 2; u <= (x + 1) / 2 && u < w; u++) {
            const float q = depth[(size_t)(2 * v) * (size_t)camera->width + (size_t)(2 * u)];
            const float k = fabsf(q - z) < 0.02f * z ? 1 : 1e-4f;

            sum += k * open[(size_t)v * (size_t)w + (size_t)u];
            weight += k;
        }
    return sum / weight;
}
