/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/track/noise.h"

#include <math.h>

static const double MISSED = 0.08, FALSE_BOXES = 0.03, CORNER = 0.03, SEEN = 0.1;

/* A coordinate that is off by a share of a side. */
static double off(lt_rng *r, double x, double side, track_noise *noise)
{
    const double by = CORNER * lt_rng_normal(r);

    noise->corners += by * by;
    noise->n_corners++;
    return x + by * side;
}

static synth_mot_detection true_box(lt_rng *r, const synth_mot_truth *t, track_noise *noise)
{
    const double w = t->box.x1 - t->box.x0, h = t->box.y1 - t->box.y0;
    synth_mot_detection d = { .score = 0.2 + 0.75 * t->visible };

    d.x0 = off(r, t->box.x0, w, noise);
    d.y0 = off(r, t->box.y0, h, noise);
    d.x1 = fmax(d.x0 + 1, off(r, t->box.x1, w, noise));
    d.y1 = fmax(d.y0 + 1, off(r, t->box.y1, h, noise));
    d.score = fmin(0.99, fmax(0.05, d.score + 0.07 * lt_rng_normal(r)));
    return d;
}

/* As large as a thing that is there, somewhere else. */
static synth_mot_detection false_box(lt_rng *r, const synth_mot_truth *like, int width, int height)
{
    const double scale = lt_rng_range(r, 0.6, 1.4), u = lt_rng_uniform(r), v = lt_rng_uniform(r);
    const double w = scale * (like->box.x1 - like->box.x0), h = scale * (like->box.y1 - like->box.y0);
    const double x = u * fmax(0, width - w), y = v * fmax(0, height - h);

    return (synth_mot_detection){ x, y, x + w, y + h, lt_rng_range(r, 0.1, 0.7) };
}

static void insert(synth_mot_detection *out, int n, const synth_mot_detection *d)
{
    for (; n > 0 && out[n - 1].score < d->score; n--)
        out[n] = out[n - 1];
    out[n] = *d;
}

int track_detect(lt_rng *r, const synth_mot_truth *truth, int n, int width, int height, synth_mot_detection *out,
                 track_noise *noise)
{
    int found = 0;

    for (int i = 0; i < n; i++) {
        const bool missed = lt_rng_uniform(r) < MISSED, another = lt_rng_uniform(r) < FALSE_BOXES;

        if (truth[i].visible < SEEN)
            continue;
        noise->boxes++;
        noise->missed += missed;
        if (!missed) {
            const synth_mot_detection d = true_box(r, &truth[i], noise);
            insert(out, found++, &d);
        }
        if (another) {
            const synth_mot_detection d = false_box(r, &truth[i], width, height);
            insert(out, found++, &d);
            noise->false_boxes++;
        }
    }
    return found;
}
