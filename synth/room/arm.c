/* SPDX-License-Identifier: Apache-2.0 */
/* The forearm: from the hand's open wrist to the edge of the picture, bare and sleeved. */
#include "synth/render/small.h"
#include "synth/room/paint.h"
#include "synth/room/pattern.h"
#include "synth/room/primitive.h"

#include <string.h>

enum {
    PARTS = 3,                                  /* points per edge of the loop */
    AROUND = SYNTH_WRIST_LOOP * PARTS,
    FOLDS = 96,                                 /* rings of the sleeve */
    FAR = 4,                                    /* times as few rings where the arm is far */
};

static const float BLEND = 0.05f;               /* metres over which the loop becomes an ellipse */
static const float RING = 0.008f;               /* between rings of the skin */
static const float TUCK = 0.03f;                /* skin under the sleeve */

static float ring_of(const synth_arm_spec *spec)
{
    return spec->far ? FAR * RING : RING;
}

static int folds_of(const synth_arm_spec *spec)
{
    return spec->far ? FOLDS / FAR : FOLDS;
}

/* The arm's own frame: centre line from c along d, wide axis x, thin axis y = d cross x. */
typedef struct {
    float c[3], d[3], x[3], y[3];
    float start[3];                             /* the wrist's own direction: the line bends into d */
    float wide, thin;                           /* semi-axes of the loop */
    float side;                                 /* -1: the loop runs clockwise about d */
    float phase;                                /* angle of the loop's first vertex */
} arm_frame;

/* The vector area of the loop: its direction is the plane's normal. */
static void loop_area(const float (*loop)[3], const float c[3], float out[3])
{
    memset(out, 0, 3 * sizeof(*out));
    for (int i = 0; i < SYNTH_WRIST_LOOP; i++) {
        const float *p = loop[i], *q = loop[(i + 1) % SYNTH_WRIST_LOOP];
        const float a[3] = { p[0] - c[0], p[1] - c[1], p[2] - c[2] };
        const float b[3] = { q[0] - c[0], q[1] - c[1], q[2] - c[2] };
        float n[3];

        cross3(a, b, n);
        for (int k = 0; k < 3; k++)
            out[k] += n[k] / 2;
    }
}

/* The direction across d in which the loop is widest: its points' second moment, in closed form. */
static void find_axes(arm_frame *f, const float (*loop)[3])
{
    float u[3] = { fabsf(f->start[0]) < 0.9f, fabsf(f->start[0]) >= 0.9f, 0 }, v[3];
    float uu = 0, uv = 0, vv = 0, angle;

    cross3(f->start, u, v);
    normalise3(v);
    cross3(v, f->start, u);
    for (int i = 0; i < SYNTH_WRIST_LOOP; i++) {
        const float p[3] = { loop[i][0] - f->c[0], loop[i][1] - f->c[1], loop[i][2] - f->c[2] };
        const float a = dot3(p, u), b = dot3(p, v);

        uu += a * a / SYNTH_WRIST_LOOP;
        uv += a * b / SYNTH_WRIST_LOOP;
        vv += b * b / SYNTH_WRIST_LOOP;
    }
    angle = 0.5f * atan2f(2 * uv, uu - vv);
    for (int k = 0; k < 3; k++)
        f->x[k] = cosf(angle) * u[k] + sinf(angle) * v[k];
    cross3(f->start, f->x, f->y);
    f->wide = sqrtf(most(uu + vv + hypotf(uu - vv, 2 * uv), 0));
    f->thin = sqrtf(most(uu + vv - hypotf(uu - vv, 2 * uv), 0));
}

static lt_status find_frame(arm_frame *f, const synth_arm_spec *spec)
{
    float area[3], first[3];

    memset(f, 0, sizeof(*f));
    for (int i = 0; i < SYNTH_WRIST_LOOP; i++)
        for (int k = 0; k < 3; k++)
            f->c[k] += spec->loop[i][k] / SYNTH_WRIST_LOOP;
    for (int k = 0; k < 3; k++)
        f->d[k] = (float)spec->elbow[k];
    loop_area(spec->loop, f->c, area);
    f->side = dot3(area, f->d) < 0 ? -1 : 1;
    for (int k = 0; k < 3; k++)
        f->start[k] = f->side * area[k];
    if (!(normalise3(f->d) > 0) || !(normalise3(f->start) > 1e-8f) ||
        !isfinite(f->c[0] + f->c[1] + f->c[2]))
        return lt_error(LT_EINVAL, "synth_arm_new: the wrist's loop or the elbow's direction has no "
                        "size");
    find_axes(f, spec->loop);
    for (int k = 0; k < 3; k++)
        first[k] = spec->loop[0][k] - f->c[k];
    f->phase = atan2f(dot3(first, f->y), dot3(first, f->x));
    return LT_OK;
}

/* The ring at distance s: its centre on a line that bends from start into d within 12 cm, and its two
 * axes, which turn along. */
static void ring_frame(const arm_frame *f, float s, float center[3], float x[3], float y[3])
{
    const float bend = 0.12f, t = least(s / bend, 1);
    float along[3];

    for (int k = 0; k < 3; k++) {
        const float curved = bend * (t * f->start[k] + t * t / 2 * (f->d[k] - f->start[k]));

        center[k] = f->c[k] + curved + most(s - bend, 0) * f->d[k];
        along[k] = f->start[k] + t * (f->d[k] - f->start[k]);
    }
    normalise3(along);
    cross3(along, f->x, y);
    normalise3(y);
    cross3(y, along, x);
}

/* A forearm's semi-axes at distance s from the wrist: flat at the wrist, thick and round below the
 * elbow at about 20 cm. */
static void section(const arm_frame *f, float s, float *wide, float *thin)
{
    const float swell = smoothly(0.02f, 0.2f, s) - 0.25f * smoothly(0.2f, 0.3f, s);

    *wide = f->wide * (1 + 0.42f * swell);
    *thin = f->thin + smoothly(0, 0.1f, s) * (*wide * (0.78f + 0.1f * swell) - f->thin);
}

/* Point i around the ring at s of a smooth arm, grow metres outside the skin. */
static void arm_point(const arm_frame *f, float s, int i, float grow, float out[3])
{
    const float angle = f->phase + f->side * (float)(2 * M_PI * (i % AROUND) / AROUND);
    float center[3], x[3], y[3], wide, thin;

    ring_frame(f, s, center, x, y);
    section(f, s, &wide, &thin);
    for (int k = 0; k < 3; k++)
        out[k] = center[k] + (wide + grow) * cosf(angle) * x[k] + (thin + grow) * sinf(angle) * y[k];
}

/* A value on the loop at point i: on the straight edge between two of its vertices. */
static void loop_point(const float (*loop)[3], int i, float out[3])
{
    const int k = i % AROUND / PARTS;
    const float *p = loop[k], *q = loop[(k + 1) % SYNTH_WRIST_LOOP];
    const float t = (float)(i % PARTS) / PARTS;

    for (int c = 0; c < 3; c++)
        out[c] = p[c] + t * (q[c] - p[c]);
}

/* The loop's own shape, carried along and fading into the smooth arm. */
static void skin_point(const arm_frame *f, const synth_arm_spec *spec, float s, int i, float out[3])
{
    const float keep = 1 - smoothly(0, BLEND, s);
    float on_loop[3], at_loop[3];

    arm_point(f, s, i, 0, out);
    if (keep == 0)
        return;
    loop_point(spec->loop, i, on_loop);
    arm_point(f, 0, i, 0, at_loop);
    for (int k = 0; k < 3; k++)
        out[k] += keep * (on_loop[k] - at_loop[k]);
    if (s == 0)
        memcpy(out, on_loop, sizeof(on_loop));
}

/* Reverses the faces of a grid that grew clockwise, and its normals. */
static void turn_out(lt_mesh *m)
{
    for (int f = 0; f < m->n_faces; f++) {
        const int32_t a = m->face[f][1];

        m->face[f][1] = m->face[f][2];
        m->face[f][2] = a;
    }
    for (int v = 0; v < m->n_vertices; v++)
        for (int k = 0; k < 3; k++)
            m->normal[v][k] = -m->normal[v][k];
}

/* The hand's own normals at the seam, so that light runs over it without a step. */
static void match_normals(lt_mesh *m, const synth_arm_spec *spec, int rings)
{
    for (int r = 0; r < rings && (float)r * ring_of(spec) < BLEND && spec->loop_normal; r++)
        for (int i = 0; i <= AROUND; i++) {
            const float keep = 1 - smoothly(0, BLEND, (float)r * ring_of(spec));
            float n[3], *to = m->normal[r * (AROUND + 1) + i];

            loop_point(spec->loop_normal, i, n);
            for (int k = 0; k < 3; k++)
                to[k] += keep * (n[k] - to[k]);
            normalise3(to);
        }
}

static void color_skin(lt_mesh *m, const synth_arm_spec *spec, int rings)
{
    const uint32_t seed = (uint32_t)lt_rng_mix(spec->seed, spec->stream);

    for (int r = 0; r < rings; r++)
        for (int i = 0; i <= AROUND; i++) {
            const float s = (float)r * ring_of(spec), keep = spec->loop_color ? 1 - smoothly(0, 0.06f, s) : 0;
            const float mottle = paint_smooth_noise(seed, (float)i / AROUND, s * 2, 4, 8, 3);
            float at_loop[3] = { 0 }, *to = m->color[r * (AROUND + 1) + i];

            if (spec->loop_color)
                loop_point(spec->loop_color, i, at_loop);
            for (int k = 0; k < 3; k++) {
                const float skin = spec->skin[k] * (1 + (0.2f + 0.08f * (float)k) * (mottle - 0.5f));

                to[k] = skin + keep * (at_loop[k] - skin);
            }
        }
}

static lt_status make_skin(lt_arena *arena, const arm_frame *f, const synth_arm_spec *spec,
                           lt_mesh *m)
{
    const double end = fmin(spec->bare + TUCK, spec->length);
    const int rings = 2 + (int)(fmax(end, 0) / ring_of(spec));

    *m = primitive_alloc(arena, rings * (AROUND + 1), 2 * (rings - 1) * AROUND);
    m->color = lt_arena_array(arena, (size_t)m->n_vertices, sizeof(*m->color));
    if (!m->n_vertices || !m->color)
        return lt_error(LT_ENOMEM, "synth_arm_new: no memory for the skin");
    for (int r = 0; r < rings; r++)
        for (int i = 0; i <= AROUND; i++) {
            const int v = r * (AROUND + 1) + i;

            skin_point(f, spec, (float)r * ring_of(spec), i, m->vertex[v]);
            m->uv[v][0] = (float)i / AROUND;
            m->uv[v][1] = (float)r * ring_of(spec) / 0.2f;
        }
    primitive_weave(m, rings, AROUND);
    if (f->side < 0)
        turn_out(m);
    match_normals(m, spec, rings);
    color_skin(m, spec, rings);
    return LT_OK;
}

/* ---- the sleeve ------------------------------------------------------------------------------ */

typedef struct {
    uint32_t seed;
    float loose, folds, cuff;       /* metres off the skin; height of folds; length of the cuff */
} cloth;

/* How far the cloth stands off the skin. Three rings make the hem: inside, edge, outside. Behind the
 * cuff it bunches: folds across the arm, broken up around it. */
static float stand_off(const cloth *c, float s, float turn)
{
    const float free = smoothly(c->cuff, c->cuff + 0.05f, s);
    const float slant = 0.25f * paint_smooth_noise(c->seed + 1, turn, s, 2, 3, 2);
    const float fold = paint_smooth_noise(c->seed, turn, s * 2 + slant, 3, 22, 2);
    const float crease = 1 - fabsf(2 * fold - 1);
    const float sag = paint_smooth_noise(c->seed + 2, turn, s, 2, 4, 2);

    return c->loose + free * (c->folds * crease * crease + c->loose * sag);
}

static void sleeve_ring(int r, const synth_arm_spec *spec, float *s, float *inset)
{
    static const float hem[4] = { 0.012f, 0.001f, 0, 0.0015f };
    static const float in[4] = { 0.0035f, 0.0025f, 0.001f, 0 };
    const float step = ((float)(spec->length - spec->bare) - 0.004f) / (float)(folds_of(spec) - 4);

    *s = (float)spec->bare + (r < 4 ? hem[r] : 0.004f + step * (float)(r - 4));
    *inset = r < 4 ? in[r] : 0;
}

static lt_status make_sleeve(lt_arena *arena, const arm_frame *f, const synth_arm_spec *spec,
                             const cloth *c, lt_mesh *m)
{
    const int folds = folds_of(spec);

    *m = primitive_alloc(arena, folds * (AROUND + 1), 2 * (folds - 1) * AROUND);
    if (!m->n_vertices)
        return lt_error(LT_ENOMEM, "synth_arm_new: no memory for the sleeve");
    for (int r = 0; r < folds; r++)
        for (int i = 0; i <= AROUND; i++) {
            const int v = r * (AROUND + 1) + i;
            const float turn = (float)(i % AROUND) / AROUND;
            float s, inset;

            sleeve_ring(r, spec, &s, &inset);
            arm_point(f, s, i, stand_off(c, s - (float)spec->bare, turn) - inset, m->vertex[v]);
            m->uv[v][0] = 2 * (float)i / AROUND;
            m->uv[v][1] = s / 0.12f;
        }
    primitive_weave(m, folds, AROUND);
    if (f->side < 0)
        turn_out(m);
    return LT_OK;
}

static synth_texture *choose_cloth(lt_arena *arena, lt_rng *r)
{
    const uint32_t kind = lt_rng_below(r, 6);
    const bool dark = lt_rng_below(r, 2), grey = kind >= 4;
    float rgb[3];

    if (kind == 0)
        return pattern_stripes(arena, r);
    if (kind == 1)
        return pattern_checks(arena, r);
    pattern_draw_color(r, grey ? 0 : 0.3, grey ? 0.15 : 0.85, dark ? 0.08 : 0.35, dark ? 0.35 : 0.95, rgb);
    return pattern_weave(arena, r, rgb);
}

static cloth draw_cloth(lt_rng *r)
{
    cloth c = { .seed = lt_rng_u32(r) };

    c.loose = (float)lt_rng_range(r, 0.004, 0.008);
    c.folds = (float)lt_rng_range(r, 0.003, 0.009);
    c.cuff = (float)lt_rng_range(r, 0, 0.06);
    return c;
}

static lt_rng arm_rng(uint64_t seed, uint64_t stream)
{
    return lt_rng_make(seed, lt_rng_mix(stream, 0xa53));
}

synth_texture *synth_arm_cloth(lt_arena *arena, uint64_t seed, uint64_t stream)
{
    lt_rng r = arm_rng(seed, stream);

    draw_cloth(&r);                             /* what is drawn after the folds */
    return choose_cloth(arena, &r);
}

lt_status synth_arm_new(lt_arena *arena, const synth_arm_spec *spec, synth_arm *out)
{
    lt_rng r = arm_rng(spec->seed, spec->stream);
    const cloth c = draw_cloth(&r);
    synth_arm arm = {
        .skin_material = { .albedo = { 1, 1, 1 }, .specular = 0.028f, .shininess = 12,
                           .translucency = 1, .grain = 1 },
        .sleeve_material = { .albedo = { 1, 1, 1 }, .specular = 0.01f, .shininess = 6 },
    };
    arm_frame f;
    lt_status st;

    if (!isfinite(spec->bare) || !(spec->length > 0 && spec->length < 3))
        return lt_error(LT_EINVAL, "synth_arm_new: length is %g m, want 0 to 3", spec->length);
    st = find_frame(&f, spec);
    if (!st)
        st = make_skin(arena, &f, spec, &arm.skin);
    if (!st && spec->bare < spec->length - 0.05) {
        arm.sleeve_material.texture = spec->cloth;
        st = make_sleeve(arena, &f, spec, &c, &arm.sleeve);
    }
    if (!st)
        *out = arm;
    return st;
}
