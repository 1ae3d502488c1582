/* SPDX-License-Identifier: Apache-2.0 */
/* When what learns, and how fast. */
#include "tasks/hogs/run.h"

#include <string.h>

enum { SKIN_STEPS = 1000, WARM = 1000 };
/* A Gaussian whose opacity was reset needs some steps to show again before it may be taken out. */
enum { LEAST_EVERY = 100, LEAST_RESET = 500 };
enum { CPU_ITERATIONS = 20000, FULL_ITERATIONS = 360000 };

/* A number of iterations of a profile, as long as this run is */
static int64_t part(int64_t iterations, int64_t of_profile, int64_t profile)
{
    return lt_max_i64(1, iterations * of_profile / profile);
}

/* The cpu profile's intervals, and those of DexYCB's 360,000 iterations; shorter runs have shorter ones. */
hogs_schedule hogs_schedule_of(const hogs *m, int64_t iterations, int64_t pose_epochs, int64_t frames)
{
    const bool small = m->config.small;
    const int64_t profile = small ? CPU_ITERATIONS : FULL_ITERATIONS;
#define OF(cpu, full) part(iterations, small ? (cpu) : (full), profile)

    return (hogs_schedule){
        .skin = lt_min_i64(SKIN_STEPS, iterations),
        .iterations = iterations,
        .poses = m->is->gpm ? pose_epochs * lt_ceil_div(frames, HOGS_POSE_BATCH) : 0,
        .warm = lt_min_i64(WARM, OF(WARM, iterations)),
        .gpm_start = m->is->gpm ? OF(4000, 60000) : iterations,
        .bend_start = iterations / 45,
        .sh_step = OF(1500, 25000), .place_steps = OF(30000, 30000), .lists = OF(1000, 1000),
        .lpips_every = small ? 4 : 1,
        .density = { .start = OF(1000, 12000), .end = OF(16000, 300000),
                     .every = lt_max_i64(LEAST_EVERY, OF(1000, 10000)),
                     .reset = lt_max_i64(LEAST_RESET, OF(5000, 60000)) },
    };
#undef OF
}

hogs_stage hogs_stage_of(const hogs_schedule *s, int64_t step)
{
    const int64_t iteration = step - s->skin;

    if (iteration < 0)
        return HOGS_SKIN;
    if (iteration >= s->iterations)
        return HOGS_POSES;
    if (iteration >= s->gpm_start)
        return HOGS_JOINT;
    return iteration < s->warm ? HOGS_WARM : HOGS_GAUSSIANS;
}

/* ---- groups of the optimiser ----------------------------------------------------------------------------- */

enum {
    CENTRE, DC, REST, OPACITY, SCALE, ROTATION, SKIN, TRUNK, HASH, HAND_COLOUR, OBJECT_COLOUR, POSES, VIT,
    FEATURE, FRAME_CODE, AVATAR, N
};

#define NAMES(...) (const char *const[]){ __VA_ARGS__, NULL }

/* In 20,000 iterations a network that begins with nothing gets nowhere by the rates of 360,000; but at ten times
 * SMALL_POSE_RATE the heads of G-PM die: all units behind their relus are 0, and biases alone still move. */
static const double SMALL_RATE = 1e-3, SMALL_POSE_RATE = 1e-4;
/* Colours begin white: at the paper's rate those of an object of four, seen in every fourth step, are not there after
 * thousands of steps. */
static const double COLOUR_RATE = 1e-3, SMALL_COLOUR_RATE = 1e-2;
static const double EPS = 1e-15, CLIP = 0.1, LAST = 0.01;      /* of a network's rate, at the end */

/* Constant, or in a line of the logarithm to `end` of it */
static lt_optim_group group_of(const char *name, const char *const *prefix, double lr, double end, int64_t steps,
                               bool network)
{
    lt_optim_group g = { .name = name, .prefix = prefix, .kind = LT_ADAMW, .by_step = true, .eps = EPS,
                         .clip_norm = network ? CLIP : 0, .schedule = { .kind = LT_CONSTANT_LR, .lr = lr } };

    if (end < 1 && lr > 0) {
        g.schedule.kind = LT_LOG_LINEAR_LR;
        g.schedule.min_lr = end * lr;
        g.schedule.epochs = (int)steps;
    }
    return g;
}

static lt_optim_group network(const char *name, const char *const *prefix, double lr, const hogs_schedule *s)
{
    return group_of(name, prefix, lr, LAST, s->skin + s->iterations, true);
}

const lt_optim_group *hogs_optim_groups(const hogs *m, const hogs_schedule *s, lt_optim_group out[HOGS_GROUPS], int *n)
{
    static const char *const centre[] = { "gaussians.centre", NULL }, *const dc[] = { "gaussians.dc", NULL },
        *const rest[] = { "gaussians.rest", NULL }, *const opacity[] = { "gaussians.opacity", NULL },
        *const scale[] = { "gaussians.log_scale", NULL }, *const rotation[] = { "gaussians.quaternion", NULL },
        *const skin[] = { "skin.", NULL }, *const backbone[] = { "vit.", NULL }, *const poses[] = { "gpm.", NULL },
        *const trunk[] = { "hand.trunk", "hand.reduce", "object.trunk", "object.reduce", NULL },
        *const hash[] = { "hand.hash", "object.hash", NULL },
        *const hand[] = { "hand.alpha", "hand.colour", NULL },
        *const object[] = { "object.alpha", "object.colour", NULL }, *const feature[] = { "gaussians.feature", NULL },
        *const code[] = { "avatar.code", NULL }, *const others[] = { "avatar.", NULL };
    const bool small = m->config.small;
    const double colour = small ? SMALL_COLOUR_RATE : COLOUR_RATE;

    out[CENTRE] = group_of("centre", centre, 1.6e-4 * HOGS_EXTENT, 0.01, s->place_steps, false);
    out[DC] = group_of("dc", dc, colour, 1, 0, false);
    out[REST] = group_of("rest", rest, colour / 20, 1, 0, false);
    out[OPACITY] = group_of("opacity", opacity, 0.05, 1, 0, false);
    out[SCALE] = group_of("scale", scale, 0.005, 1, 0, false);
    out[ROTATION] = group_of("rotation", rotation, 0.001, 1, 0, false);
    out[SKIN] = network("skin", skin, small ? SMALL_RATE : 1e-4, s);
    out[TRUNK] = network("trunk", trunk, small ? SMALL_RATE : 1e-5, s);
    out[HASH] = network("hash", hash, 1e-2, s);
    out[HAND_COLOUR] = network("hand_colour", hand, 0.5e-3, s);
    out[OBJECT_COLOUR] = network("object_colour", object, 1e-3, s);
    out[POSES] = network("gpm", poses, small ? SMALL_POSE_RATE : 1e-5, s);
    out[VIT] = network("vit", backbone, 3e-4, s);
    out[FEATURE] = group_of("feature", feature, 1e-3, 1, 0, false);
    out[FRAME_CODE] = network("frame_code", code, 1e-3, s);
    out[FRAME_CODE].weight_decay = 0.05;
    out[AVATAR] = network("avatar", others, 1e-3, s);
    for (int i = 0; i < N; i++)
        out[i].clip_alone = m->config.clip_groups && out[i].clip_norm > 0;
    *n = N;
    return out;
}

int hogs_pose_group(const hogs *m, lt_optim_group *out)
{
    static const char *const poses[] = { "gpm.", NULL };

    *out = group_of("gpm", poses, m->config.small ? SMALL_POSE_RATE : 0.5e-4, 1, 0, false);
    return POSES;
}

uint64_t hogs_stage_groups(hogs_stage stage)
{
    const uint64_t all = (UINT64_C(1) << N) - 1;

    if (stage == HOGS_SKIN)
        return UINT64_C(1) << SKIN;
    if (stage == HOGS_POSES)
        return UINT64_C(1) << POSES;
    return stage == HOGS_JOINT ? all : all & ~(UINT64_C(1) << POSES);
}
