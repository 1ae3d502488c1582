/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/base/parallel.h"
#include "synth/render/occlusion.h"
#include "synth/render/small.h"

enum { STEPS = 4, TURNS = 8 };

static const float RADIUS = 0.06f;              /* metres */
static const float STRENGTH = 1.7f;

/* Everything happens at half resolution: pixel (x, y) there is (2 x, 2 y) of the picture. */
typedef struct {
    int width, height;
    float focal, per_fx, per_fy, cx, cy;
    const float *depth;
    float *open;
    const float *rough;
} occlusion_job;

static float turns[TURNS][2];                   /* cosine and sine of the sampling cross */

__attribute__((constructor)) static void make_turns(void)
{
    for (int i = 0; i < TURNS; i++) {
        turns[i][0] = (float)cos(M_PI / 2 * i / TURNS);
        turns[i][1] = (float)sin(M_PI / 2 * i / TURNS);
    }
}

static v4 unproject(const occlusion_job *job, int x, int y, float z)
{
    return (v4){ ((float)x - job->cx) * job->per_fx * z, ((float)y - job->cy) * job->per_fy * z, z, 0 };
}

static int clamp(int i, int n)
{
    return i < 0 ? 0 : i < n ? i : n - 1;
}

static float depth_at(const occlusion_job *job, int x, int y)
{
    return job->depth[clamp(y, job->height) * job->width + clamp(x, job->width)];
}

/* Of the two neighbours along an axis the one on the same surface: the smaller step in depth. */
static v4 slope(const occlusion_job *job, int x, int y, int dx, int dy, v4 p)
{
    const float before = depth_at(job, x - dx, y - dy), after = depth_at(job, x + dx, y + dy);

    if (fabsf(after - p[2]) < fabsf(before - p[2]))
        return unproject(job, x + dx, y + dy, after) - p;
    return p - unproject(job, x - dx, y - dy, before);
}

/* The surface's normal at a pixel, towards the camera. */
static v4 find_normal(const occlusion_job *job, int x, int y, v4 p)
{
    float a[3], b[3], n[3];

    v4_to3(slope(job, x, y, 1, 0, p), a);
    v4_to3(slope(job, x, y, 0, 1, p), b);
    cross3(b, a, n);
    normalise3(n);
    return v4_of3(n);
}

/* How much the points at four places hide of the sky over p. */
static float hidden_by(const occlusion_job *job, const int x[4], const int y[4], v4 p, v4 n)
{
    const v4 z = { depth_at(job, x[0], y[0]), depth_at(job, x[1], y[1]), depth_at(job, x[2], y[2]),
                   depth_at(job, x[3], y[3]) };
    const v4 u = { (float)x[0], (float)x[1], (float)x[2], (float)x[3] };
    const v4 v = { (float)y[0], (float)y[1], (float)y[2], (float)y[3] };
    const v4 qx = (u - v4_all(job->cx)) * v4_all(job->per_fx) * z - v4_all(p[0]);
    const v4 qy = (v - v4_all(job->cy)) * v4_all(job->per_fy) * z - v4_all(p[1]);
    const v4 qz = z - v4_all(p[2]);
    const v4 d2 = qx * qx + qy * qy + qz * qz;
    const v4 up = qx * v4_all(n[0]) + qy * v4_all(n[1]) + qz * v4_all(n[2]);
    const v4 fade = v4_positive(v4_all(1) - d2 * v4_all(1 / (RADIUS * RADIUS)));
    const v4 near = v4_all(1e-12f) + d2;
    const v4 distance = { sqrtf(near[0]), sqrtf(near[1]), sqrtf(near[2]), sqrtf(near[3]) };
    const v4 hidden = fade * v4_positive(up / distance - v4_all(0.12f));

    return hidden[0] + hidden[1] + hidden[2] + hidden[3];
}

/* A cross of samples at each of several distances. */
static float open_at(const occlusion_job *job, int x, int y)
{
    const float z = depth_at(job, x, y), *turn = turns[(x * 5 + y * 3) % TURNS];
    const v4 p = unproject(job, x, y, z);
    float hidden = 0, reach;
    v4 n;

    if (z == 0)
        return 1;
    reach = 0.9f * least(RADIUS * job->focal / z, 60) / (STEPS * STEPS);
    n = find_normal(job, x, y, p);
    for (int k = 1; k <= STEPS; k++) {
        const float r = reach * (float)(k * k) + 0.5f;
        const int a = (int)lrintf(r * turn[0]), b = (int)lrintf(r * turn[1]);

        hidden += hidden_by(job, (int[4]){ x + a, x - b, x - a, x + b }, (int[4]){ y + b, y + a, y - b, y - a },
                            p, n);
    }
    return most(1 - STRENGTH * hidden / (4 * STEPS), 0);
}

static void find_row(void *ctx, int64_t y)
{
    const occlusion_job *job = ctx;

    for (int x = 0; x < job->width; x++)
        job->open[(size_t)y * (size_t)job->width + (size_t)x] = open_at(job, x, (int)y);
}

/* Averages over the turns of the sampling pattern, but only across pixels of like depth. */
static float smooth(const occlusion_job *job, int x, int y)
{
    const int x0 = x > 2 ? x - 2 : 0, x1 = x + 2 < job->width ? x + 2 : job->width - 1;
    const int y0 = y > 2 ? y - 2 : 0, y1 = y + 2 < job->height ? y + 2 : job->height - 1;
    const float z = job->depth[y * job->width + x], like = 0.02f * z;
    float sum = 0, weight = 0;

    for (int v = y0; v <= y1; v++)
        for (int u = x0; u <= x1; u++) {
            const int i = v * job->width + u;
            const float w = fabsf(job->depth[i] - z) < like ? 1 : 1e-4f;

            sum += w * job->rough[i];
            weight += w;
        }
    return sum / weight;
}

static void smooth_row(void *ctx, int64_t y)
{
    const occlusion_job *job = ctx;

    for (int x = 0; x < job->width; x++)
        job->open[(size_t)y * (size_t)job->width + (size_t)x] = smooth(job, x, (int)y);
}

/* Every other pixel of every other row. */
static void halve(const synth_camera *camera, const float *depth, float *out)
{
    for (int y = 0; y < camera->height; y += 2)
        for (int x = 0; x < camera->width; x += 2)
            *out++ = depth[(size_t)y * (size_t)camera->width + (size_t)x];
}

void occlusion_find(const synth_camera *camera, const float *depth, float *open, float *scratch[2])
{
    occlusion_job job = {
        .width = (camera->width + 1) / 2, .height = (camera->height + 1) / 2,
        .focal = (float)camera->fx / 2, .per_fx = (float)(2 / camera->fx), .per_fy = (float)(2 / camera->fy),
        .cx = (float)camera->cx / 2, .cy = (float)camera->cy / 2, .depth = scratch[1], .open = scratch[0],
    };

    halve(camera, depth, scratch[1]);
    lt_parallel_for(job.height, find_row, &job);
    job.rough = scratch[0];
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
