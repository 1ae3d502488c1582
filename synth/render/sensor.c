/* SPDX-License-Identifier: Apache-2.0 */
/* From light to bytes, and from true depth to what a stereo depth camera reports. */
#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"
#include "synth/render/small.h"
#include "synth/render/texture.h"

#include <string.h>

enum { BLUR_TAPS = 15, MAX_RADIUS = 4, TONES = 2048 };

static const float LIGHT_MAX = 4;               /* brighter is white */

typedef struct { int dx, dy; float share; } tap;

typedef struct {
    const synth_sensor *sensor;
    const synth_frame *frame;
    const float (*from)[3];
    float (*to)[3];
    tap path[BLUR_TAPS];
    int n_path;
    float kernel[2 * MAX_RADIUS + 1];
    int radius;                     /* of the blur */
    float tone[TONES + 2];          /* byte value over the root of light / LIGHT_MAX */
} image_job;

synth_sensor synth_sensor_random(uint64_t seed, uint64_t stream)
{
    lt_rng r = lt_rng_make(seed, lt_rng_mix(stream, 0x5e5));
    const double warmth = 0.06 * lt_rng_normal(&r), tint = 0.02 * lt_rng_normal(&r);
    synth_sensor s = { .seed = seed, .stream = stream };

    s.white[0] = (float)exp(warmth);
    s.white[1] = (float)exp(tint);
    s.white[2] = (float)exp(-warmth);
    s.exposure = (float)exp2(0.28 * lt_rng_normal(&r));
    s.gamma = (float)lt_rng_range(&r, 0.92, 1.12);
    s.softness = (float)lt_rng_range(&r, 0.35, 0.8);
    s.vignette = (float)lt_rng_range(&r, 0.02, 0.2);
    s.noise = (float)lt_rng_range(&r, 1, 4);
    return s;
}

/* ---- blur ------------------------------------------------------------------------------------ */

/* The pixels that a moving point passes, and for what share of BLUR_TAPS. */
static void find_path(image_job *job)
{
    const float *motion = job->sensor->motion;

    for (int k = 0; k < BLUR_TAPS; k++) {
        const float s = ((float)k + 0.5f) / BLUR_TAPS - 0.5f;
        const int dx = (int)lrintf(s * motion[0]), dy = (int)lrintf(s * motion[1]);
        tap *last = job->n_path ? &job->path[job->n_path - 1] : NULL;

        if (last && last->dx == dx && last->dy == dy)
            last->share++;
        else
            job->path[job->n_path++] = (tap){ dx, dy, 1 };
    }
}

/* Each pixel that a moving surface sweeps over shows it for a share of the time, and for the rest
 * what stands still there; where that is hidden, what stands still nearby. */
static void smear_pixel(const image_job *job, int x, int y, float out[3])
{
    const synth_frame *f = job->frame;
    const size_t here = (size_t)y * (size_t)f->width + (size_t)x;
    float moving[3] = { 0 }, still[3] = { 0 }, n_moving = 0, n_still = 0;

    for (int k = 0; k < job->n_path; k++) {
        const tap *t = &job->path[k];
        const int u = x + t->dx, v = y + t->dy;
        const size_t i = (size_t)v * (size_t)f->width + (size_t)u;

        if (u < 0 || v < 0 || u >= f->width || v >= f->height)
            continue;
        for (int c = 0; c < 3; c++)
            *(f->moving[i] ? &moving[c] : &still[c]) += t->share * job->from[i][c];
        *(f->moving[i] ? &n_moving : &n_still) += t->share;
    }
    for (int c = 0; c < 3; c++) {
        const float behind = n_still > 0 ? still[c] / n_still : 0;
        const float rest = f->moving[here] ? behind : job->from[here][c];

        out[c] = (moving[c] + rest * n_still) / (n_moving + n_still);
    }
}

/* The first and last pixel of row y that moves; false when none does. */
static bool find_moving(const synth_frame *f, int y, int *first, int *last)
{
    const uint8_t *row = f->moving + (size_t)y * (size_t)f->width;
    const uint8_t *at = memchr(row, 1, (size_t)f->width);

    if (!at)
        return false;
    *first = (int)(at - row);
    *last = f->width - 1;
    while (!row[*last])
        --*last;
    return true;
}

/* What of row y a path can reach from a moving pixel. */
static void find_reach(const image_job *job, int y, int *first, int *last)
{
    const synth_frame *f = job->frame;

    *first = f->width;
    *last = -1;
    for (int k = 0; k < job->n_path; k++) {
        const tap *t = &job->path[k];
        int lo, hi;

        if (y + t->dy < 0 || y + t->dy >= f->height || !find_moving(f, y + t->dy, &lo, &hi))
            continue;
        *first = lo - t->dx < *first ? lo - t->dx : *first;
        *last = hi - t->dx > *last ? hi - t->dx : *last;
    }
    *first = *first < 0 ? 0 : *first;
    *last = *last < f->width ? *last : f->width - 1;
}

static void smear_row(void *ctx, int64_t y)
{
    const image_job *job = ctx;
    const size_t row = (size_t)y * (size_t)job->frame->width;
    int first, last;

    memcpy(job->to[row], job->from[row], (size_t)job->frame->width * sizeof(*job->to));
    find_reach(job, (int)y, &first, &last);
    for (int x = first; x <= last; x++)
        smear_pixel(job, x, (int)y, job->to[row + (size_t)x]);
}

static int clamp(int i, int n)
{
    return i < 0 ? 0 : i < n ? i : n - 1;
}

/* out = sum of the kernel's weights times n floats from each of its rows, which are taken one by one. */
static void weigh(const image_job *job, const float *const *in, int n, float *out)
{
    const int taps = 2 * job->radius + 1;
    int i = 0;

    for (; i + 4 <= n; i += 4) {
        v4 sum = v4_all(0);

        for (int k = 0; k < taps; k++)
            sum += v4_all(job->kernel[k]) * *(const v4_at *)(in[k] + i);
        *(v4_at *)(out + i) = sum;
    }
    for (; i < n; i++) {
        out[i] = 0;
        for (int k = 0; k < taps; k++)
            out[i] += job->kernel[k] * in[k][i];
    }
}

/* Across: the row with its ends repeated, then shifted against itself. */
static void soften_across(void *ctx, int64_t y)
{
    const image_job *job = ctx;
    const int w = job->frame->width, r = job->radius;
    const float (*from)[3] = job->from + (size_t)y * (size_t)w;
    float row[SYNTH_MAX_SIDE + 2 * MAX_RADIUS][3];
    const float *in[2 * MAX_RADIUS + 1];

    for (int x = -r; x < 0; x++)
        memcpy(row[x + r], from[0], sizeof(row[0]));
    memcpy(row[r], from, (size_t)w * sizeof(row[0]));
    for (int x = w; x < w + r; x++)
        memcpy(row[x + r], from[w - 1], sizeof(row[0]));
    for (int k = 0; k <= 2 * r; k++)
        in[k] = row[k];
    weigh(job, in, 3 * w, job->to[(size_t)y * (size_t)w]);
}

static void soften_down(void *ctx, int64_t y)
{
    const image_job *job = ctx;
    const int w = job->frame->width, h = job->frame->height, r = job->radius;
    const float *in[2 * MAX_RADIUS + 1];

    for (int k = -r; k <= r; k++)
        in[k + r] = job->from[(size_t)clamp((int)y + k, h) * (size_t)w];
    weigh(job, in, 3 * w, job->to[(size_t)y * (size_t)w]);
}

static void make_kernel(image_job *job)
{
    const float sigma = least(job->sensor->softness, 1.5f);
    float sum = 0;

    job->radius = (int)(2.6f * sigma + 0.5f);
    for (int k = -job->radius; k <= job->radius; k++)
        sum += job->kernel[k + job->radius] = expf(-0.5f * (float)(k * k) / (sigma * sigma));
    for (int k = 0; k <= 2 * job->radius; k++)
        job->kernel[k] /= sum;
}

/* Runs one step over all rows, into the working buffer that it does not read. */
static void run(image_job *job, lt_task_fn row)
{
    const synth_frame *f = job->frame;

    job->to = job->from == (const float (*)[3])f->work[0] ? f->work[1] : f->work[0];
    lt_parallel_for(f->height, row, job);
    job->from = (const float (*)[3])job->to;
}

/* ---- light to bytes -------------------------------------------------------------------------- */

/* Film's shoulder: straight up to the knee, then ever slower towards 1. */
static float shoulder(float x)
{
    const float knee = 0.7f, over = x - knee;

    return x <= knee ? x : knee + (1 - knee) * over / (over + (1 - knee));
}

/* Contrast, shoulder and sRGB's curve in one table. */
static void make_tones(image_job *job)
{
    for (int i = 0; i < TONES + 2; i++) {
        const float root = (float)i / TONES;

        job->tone[i] = linear_to_srgb(shoulder(powf(root * root * LIGHT_MAX, job->sensor->gamma)));
    }
}

static float tone_of(const image_job *job, float light)
{
    const float at = TONES * sqrtf(within(light / LIGHT_MAX, 0, 1));
    const int i = (int)at;

    return job->tone[i] + (at - (float)i) * (job->tone[i + 1] - job->tone[i]);
}

/* Nearly normal numbers of mean 0 and deviation 1, four for each of two pixels: sums of four half bytes,
 * of which each word has two. */
static void eight_normals(const synth_sensor *s, uint32_t pair, float out[2][4])
{
    const uint32_t key[2] = { (uint32_t)s->seed, (uint32_t)(s->seed >> 32) };
    const uint32_t ctr[4] = { pair, 0x6e6f6973, (uint32_t)s->stream, (uint32_t)(s->stream >> 32) };
    uint32_t w[4];

    lt_philox(key, ctr, w);
    for (int i = 0; i < 4; i++) {
        const uint32_t pairs = (w[i] & 0x0f0f0f0f) + (w[i] >> 4 & 0x0f0f0f0f);
        const uint32_t sums = pairs + (pairs >> 8);

        out[0][i] = ((float)(sums & 255) - 30) / 9.22f;
        out[1][i] = ((float)(sums >> 16 & 255) - 30) / 9.22f;
    }
}

/* Shot noise grows with the root of the light; the curve of sRGB turns that into a nearly even noise
 * that is a little stronger in the dark. Most of it is common to the channels. */
static float noise_of(const synth_sensor *s, const float normal[4], int channel, float byte)
{
    const float size = s->noise * (1.25f - 0.5f * byte / 255);

    return size * (0.8f * normal[3] + 0.6f * normal[channel]);
}

static void develop_row(void *ctx, int64_t y)
{
    const image_job *job = ctx;
    const synth_sensor *s = job->sensor;
    const synth_frame *f = job->frame;
    const float cx = (float)f->width / 2, cy = (float)f->height / 2, r2 = cx * cx + cy * cy;
    float pair[2][4];

    for (int x = 0; x < f->width; x++) {
        const size_t i = (size_t)y * (size_t)f->width + (size_t)x;
        const float dx = (float)x - cx, dy = (float)y - cy;
        const float gain = s->exposure * (1 - s->vignette * (dx * dx + dy * dy) / r2);
        const float *normal = pair[x & 1];

        if (x % 2 == 0)
            eight_normals(s, (uint32_t)(y * ((f->width + 1) / 2) + x / 2), pair);
        for (int c = 0; c < 3; c++) {
            const float byte = tone_of(job, gain * s->white[c] * job->from[i][c]);

            f->rgb[i][c] = (uint8_t)within(byte + noise_of(s, normal, c, byte) + 0.5f, 0, 255);
        }
    }
}

void synth_sensor_image(const synth_sensor *sensor, synth_frame *frame)
{
    image_job job = { .sensor = sensor, .frame = frame, .from = (const float (*)[3])frame->radiance };

    find_path(&job);
    if (job.n_path > 1)
        run(&job, smear_row);
    if (sensor->softness > 0.2f) {
        make_kernel(&job);
        run(&job, soften_across);
        run(&job, soften_down);
    }
    make_tones(&job);
    lt_parallel_for(frame->height, develop_row, &job);
}

/* ---- depth ----------------------------------------------------------------------------------- */

typedef struct {
    const synth_frame *frame;
    double focal, step;
    float far;
    uint64_t seed, stream;
    float hole_share;
    float *out;
} depth_job;

static const float BASELINE = 0.055f;           /* metres */

/* Whether the surface breaks off within two pixels. */
static bool near_edge(const synth_frame *f, int x, int y, float z)
{
    static const int ring[8][2] = {
        { 2, 0 }, { -2, 0 }, { 0, 2 }, { 0, -2 }, { 1, 1 }, { -1, 1 }, { 1, -1 }, { -1, -1 },
    };

    for (int k = 0; k < 8; k++) {
        const int u = clamp(x + ring[k][0], f->width), v = clamp(y + ring[k][1], f->height);

        if (fabsf(f->depth[(size_t)v * (size_t)f->width + (size_t)u] - z) > 0.03f * z)
            return true;
    }
    return false;
}

/* Four random words of a few pixels. */
static void four_words(const depth_job *job, uint32_t x, uint32_t y, uint32_t purpose, uint32_t out[4])
{
    const uint32_t key[2] = { (uint32_t)job->seed, (uint32_t)(job->seed >> 32) };
    const uint32_t ctr[4] = { x | y << 16, purpose, (uint32_t)job->stream, (uint32_t)(job->stream >> 32) };

    lt_philox(key, ctr, out);
}

/* 0..1 */
static float uniform(uint32_t word)
{
    return (float)(word >> 8) / 16777216;
}

/* Mean 0, deviation 1, nearly normal: the sum of the word's four bytes. */
static float normal(uint32_t w)
{
    return ((float)((w & 255) + (w >> 8 & 255) + (w >> 16 & 255) + (w >> 24)) - 510) / 147.8f;
}

static void depth_row(void *ctx, int64_t row)
{
    const depth_job *job = ctx;
    const synth_frame *f = job->frame;
    const int y = (int)row;
    uint32_t pair[4], block[4];     /* of two pixels, of a hole's size */

    for (int x = 0; x < f->width; x++) {
        const size_t i = (size_t)y * (size_t)f->width + (size_t)x;
        const float z = f->depth[i], spread = 0.08f * z * z / ((float)job->focal * BASELINE);
        const uint32_t *w = pair + (x & 1) * 2;

        if (x % 2 == 0)
            four_words(job, (uint32_t)x, (uint32_t)y, 0xdeb7, pair);
        if (x % 3 == 0)
            four_words(job, (uint32_t)x / 3, (uint32_t)y / 3, 0x401e, block);
        job->out[i] = 0;
        if (z <= 0 || z > job->far || uniform(block[0]) < job->hole_share ||
            (uniform(w[0]) < 0.8f && near_edge(f, x, y, z)))
            continue;
        job->out[i] = (float)(rint((z + normal(w[1]) * spread) / job->step) * job->step);
    }
}

void synth_sensor_depth(const synth_frame *frame, double focal, double step, double far, uint64_t seed,
                        uint64_t stream, float *out)
{
    lt_rng r = lt_rng_make(seed, lt_rng_mix(stream, 0x401e));
    depth_job job = { frame, focal, step, (float)far, seed, stream, (float)lt_rng_range(&r, 0.01, 0.03), out };

    lt_parallel_for(frame->height, depth_row, &job);
}
