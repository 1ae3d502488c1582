/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/actions/clip.h"

#include "synth/actions/program.h"

#include <math.h>
#include <string.h>

enum { STYLE = 0x5354594c, DRAW = 0x44524157, NOISE = 0x4e4f4953, MISSES = 0x4d495353 };

/* At difficulty 1: joints are off by so much in each frame, and wander; and an object is missed in runs of frames */
static const double SHAKE = 0.008, DRIFT = 0.03, KEPT = 0.9, LOST = 0.12, FOUND = 0.15;

typedef struct {
    action_style style;
    action_draw draw;
} making;

static void put(float *to, int points, int k, int i, const double at[3])
{
    for (int c = 0; c < 3; c++)
        to[(c * CLIP_FRAMES + k) * points + i] = (float)at[c];
}

/* Wrist and fingers, corners, centre: data/action/action.h */
static void put_hand_object(clip *out, int k, int side, double joint[ACTION_BODY][3], const hand_frame *h,
                            const double size[3])
{
    double centre[3], corner[3];

    for (int c = 0; c < 3; c++)
        centre[c] = h->wrist[c] + 0.085 * h->R[3 * c] + (0.02 + 0.5 * size[1]) * h->R[3 * c + 2];
    put(out->hand_object, ACTION_HAND_OBJECT, k, 0, h->wrist);
    for (int i = 0; i < 20; i++)
        put(out->hand_object, ACTION_HAND_OBJECT, k, 1 + i, joint[(side == LEFT ? 25 : 45) + i]);
    for (int i = 0; i < 8; i++) {
        for (int c = 0; c < 3; c++)
            corner[c] = centre[c] + 0.5 * ((i & 1 ? size[0] : -size[0]) * h->R[3 * c]
                                           + (i & 2 ? size[1] : -size[1]) * h->R[3 * c + 2]
                                           + (i & 4 ? size[2] : -size[2]) * h->R[3 * c + 1]);
        put(out->hand_object, ACTION_HAND_OBJECT, k, 21 + i, corner);
    }
    put(out->hand_object, ACTION_HAND_OBJECT, k, 29, centre);
    out->valid[k] = 1;
}

static void perform(const making *m, clip *out)
{
    for (int k = 0; k < m->draw.frames; k++) {
        double joint[ACTION_BODY][3];
        hand_frame hand[SIDES];
        body_pose pose;

        action_pose(&m->style, &m->draw, k, &pose);
        body_joints(&pose, m->style.stature, joint, hand);
        for (int i = 0; i < ACTION_BODY; i++)
            put(out->body, ACTION_BODY, k, i, joint[i]);
        if (action_holds(&m->draw, k))
            put_hand_object(out, k, m->draw.arm, joint, &hand[m->draw.arm], m->draw.size);
    }
}

/* White noise and a slow one on each coordinate, from frame to frame */
static void shake(lt_rng *r, double by, float *x, int points, int frames)
{
    double slow = by * DRIFT * lt_rng_normal(r);

    for (int k = 0; k < frames; k++) {
        const double fast = by * SHAKE * lt_rng_normal(r);

        slow = KEPT * slow + sqrt(1 - KEPT * KEPT) * by * DRIFT * lt_rng_normal(r);
        x[k * points] += (float)(fast + slow);
    }
}

static void miss(lt_rng *r, double by, clip *out)
{
    bool lost = false;

    for (int k = 0; k < out->frames; k++) {
        const double u = lt_rng_uniform(r);

        lost = lost ? u >= FOUND : u < by * LOST;
        out->valid[k] = out->valid[k] && !lost;
        for (int c = 0; c < 3 && !out->valid[k]; c++)
            memset(out->hand_object + (c * CLIP_FRAMES + k) * ACTION_HAND_OBJECT, 0,
                   ACTION_HAND_OBJECT * sizeof(float));
    }
}

void clip_make(uint64_t seed, double difficulty, const clip_number *number, clip *out)
{
    const uint64_t subject = (uint64_t)number->subject;
    const uint64_t one = (uint64_t)number->cls << 32 | (uint64_t)number->repetition, stream = lt_rng_mix(subject, one);
    lt_rng style = lt_rng_make(seed, lt_rng_mix(STYLE, subject)), draw = lt_rng_make(seed, lt_rng_mix(DRAW, stream));
    lt_rng noise = lt_rng_make(seed, lt_rng_mix(NOISE, stream)), misses = lt_rng_make(seed, lt_rng_mix(MISSES, stream));
    making m;

    action_style_draw(&style, &m.style);
    action_draw_new(&draw, number->cls, difficulty, &m.style, &m.draw);
    out->frames = m.draw.frames;
    out->onset = (int)ceil(m.draw.begin * m.draw.frames);
    perform(&m, out);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < ACTION_BODY; i++)
            shake(&noise, difficulty, out->body + c * CLIP_FRAMES * ACTION_BODY + i, ACTION_BODY, out->frames);
        for (int i = 0; i < ACTION_HAND_OBJECT; i++)
            shake(&noise, difficulty / 3, out->hand_object + c * CLIP_FRAMES * ACTION_HAND_OBJECT + i,
                  ACTION_HAND_OBJECT, out->frames);
    }
    miss(&misses, difficulty, out);
}
