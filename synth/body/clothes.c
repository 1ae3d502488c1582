/* SPDX-License-Identifier: Apache-2.0 */
/* Shirt, trousers, shoes, hair, brows and lips as parts of the body at rest; colours of skin and eyes. */
#include "synth/body/clothes.h"

#include "synth/room/paint.h"

#include <math.h>
#include <string.h>

/* ---- the pieces ---------------------------------------------------------------------------------------- */

/* Creases across the limbs and down the trunk, in 0..1. */
static double crease(const synth_appearance *a, rest_place p)
{
    const float u = (float)(0.5 + p.aside), v = (float)(p.up + 0.3 * p.z);
    const double fold = paint_smooth_noise(a->folds, u, v, 9, 9, 2);

    return 1 - fabs(2 * fold - 1);
}

static double shirt_there(const synth_appearance *a, rest_place p)
{
    const double neck = fmax(hypot(p.x / 1.15, p.z + 0.022) - 0.072, 1.415 - 0.35 * p.z - p.up);

    const double chin = 1.452 - 0.5 * fmax(0, p.z) + fmax(0, p.aside - 0.1);    /* no higher, or the face is in it */

    return fmin(fmin(p.up - a->hem, a->sleeve - p.aside), fmin(neck, chin - p.up));
}

static double shirt_off(const synth_appearance *a, rest_place p)
{
    const double belly = clothes_ramp(1.25, 1.0, p.up) * (p.aside < CLOTHES_ARM);

    return a->loose * (0.55 + 0.9 * belly) + 0.7 * a->loose * crease(a, p) * clothes_ramp(1.43, 1.35, p.up);
}

static double trousers_there(const synth_appearance *a, rest_place p)
{
    return fmin(fmin(1.0 - p.up, p.up - a->cuff), CLOTHES_ARM - p.aside);
}

static double trousers_off(const synth_appearance *a, rest_place p)
{
    const double leg = clothes_ramp(0.85, 0.3, p.up);

    return a->loose * (0.35 + 1.1 * leg) + 0.6 * a->loose * crease(a, p) * clothes_ramp(1, 0.8, p.up);
}

static double shoes_there(const synth_appearance *a, rest_place p)
{
    (void)a;
    return fmin(0.085 + 0.25 * fmax(0, -p.z - 0.03) - p.up, CLOTHES_ARM - p.aside);
}

static double shoes_off(const synth_appearance *a, rest_place p)
{
    (void)a;
    return 0.005 + 0.006 * clothes_ramp(0.02, 0.0, p.up);
}

/* Down to the fringe in front, over the ears at the sides, to the nape behind. */
static double hair_there(const synth_appearance *a, rest_place p)
{
    const double side = fmax(1.6, a->nape), front = clothes_ramp(0.01, 0.05, p.z), back = clothes_ramp(0, -0.045, p.z);
    const double line = side + front * (a->fringe - side) + back * (a->nape - side);

    return a->hair_depth > 0 ? fmin(p.up - line + 0.006 * sin(90 * p.x), 0.15 - p.aside) : -1;
}

static double hair_off(const synth_appearance *a, rest_place p)
{
    const float u = (float)(4 * p.x), v = (float)(4 * p.z);
    const double lock = paint_smooth_noise(a->folds + 1, u, v, 14, 14, 2);

    return 0.004 + a->hair_depth * (0.7 + 0.6 * lock) * clothes_ramp(0, 0.03, hair_there(a, p));
}

static double brows_there(const synth_appearance *a, rest_place p)
{
    const double along = (p.aside - 0.033) / 0.019, arch = 1.6135 - 0.0035 * along * along + 0.001 * along;

    (void)a;
    return p.z > 0.03 ? 0.005 * (1 - hypot(along, (p.up - arch) / 0.0048)) : -1;
}

static double lips_there(const synth_appearance *a, rest_place p)
{
    const double along = p.x / 0.026, high = p.up > 1.5175 ? 0.0085 - 0.002 * exp(-p.x * p.x / 3e-5) : 0.0105;

    (void)a;
    return p.z > 0.06 ? 0.005 * (1 - hypot(along, (p.up - 1.5175) / high)) : -1;
}

/* Where the lips meet. */
static double mouth_there(const synth_appearance *a, rest_place p)
{
    (void)a;
    return p.z > 0.06 ? 0.003 * (1 - hypot(p.x / 0.0245, (p.up - 1.5172) / 0.0012)) : -1;
}

static double thin(const synth_appearance *a, rest_place p) { (void)a, (void)p; return 0.0008; }
static double thinner(const synth_appearance *a, rest_place p) { (void)a, (void)p; return 0.0005; }

enum { SHIRT, TROUSERS, SHOES, HAIR, BROWS, LIPS, MOUTH };

const clothes_piece clothes_pieces[CLOTHES_PIECES] = {
    [SHIRT] = { shirt_there, shirt_off, 1, true }, [TROUSERS] = { trousers_there, trousers_off, 1, true },
    [SHOES] = { shoes_there, shoes_off, 2, true }, [HAIR] = { hair_there, hair_off, 1, false },
    [BROWS] = { brows_there, thin, 5, false }, [LIPS] = { lips_there, thinner, 4, false },
    [MOUTH] = { mouth_there, thin, 8, false },
};

synth_material clothes_material(const synth_appearance *a, int i)
{
    const float *s = a->skin;
    const float lip[3] = { 0.78f * s[0], 0.45f * s[1], 0.45f * s[2] };
    const float line[3] = { 0.3f * s[0], 0.15f * s[1], 0.15f * s[2] };
    const float white[3] = { 1, 1, 1 };
    const float *const color[CLOTHES_PIECES] = { white, white, a->shoes, a->hair, a->hair, lip, line };
    synth_material m = { .specular = i == HAIR ? 0.03f : 0.012f, .shininess = i == HAIR ? 25 : 7 };

    memcpy(m.albedo, color[i], sizeof(m.albedo));
    m.texture = i == SHIRT ? a->shirt : i == TROUSERS ? a->trousers : NULL;
    return m;
}

/* ---- skin ------------------------------------------------------------------------------------------- */

/* Redder cheeks, nose and ears; a little mottled. */
void clothes_skin(const synth_appearance *a, rest_place p, float out[3])
{
    const double cheek = exp(-(pow(p.aside - 0.042, 2) + pow(p.up - 1.556, 2)) / 4e-4) * (p.z > 0.03);
    const double nose = exp(-(p.x * p.x + pow(p.up - 1.555, 2)) / 2e-4) * (p.z > 0.08);
    const double red = fmin(1, 0.6 * cheek + 0.7 * nose + (p.aside > 0.078 && p.up > 1.53 && p.aside < 0.1 ? 0.6 : 0));
    const double mottle = paint_smooth_noise(a->folds + 2, (float)(2 * p.x), (float)(2 * p.up), 12, 12, 3) - 0.5;

    for (int k = 0; k < 3; k++)
        out[k] = (float)(a->skin[k] * (1 + 0.1 * mottle) * (1 - red * (k ? 0.18 : 0)));
}

/* White, with the iris and the pupil where the eye looks. */
void clothes_eye(const synth_appearance *a, const double off[3], float out[3])
{
    const double turn = acos(fmin(1, off[2] / sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2])));
    const double iris = clothes_ramp(0.50, 0.44, turn), pupil = clothes_ramp(0.26, 0.16, turn);
    static const float white[3] = { 0.66f, 0.63f, 0.61f };

    for (int k = 0; k < 3; k++)
        out[k] = (float)((white[k] + iris * (a->iris[k] - white[k])) * (1 - 0.95 * pupil));
}
