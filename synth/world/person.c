/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/world/person.h"

#include "libtensor/geometry/mat3.h"
#include "synth/room/pattern.h"
#include "synth/room/primitive.h"

#include <math.h>
#include <string.h>

enum { BODY = 0x424f4459, CLOTHES = 0x434c4f54, AROUND = 24, LOFT = 24, BALL = 12 };

/* Shares of the stature. */
static const double HIP_HEIGHT = 0.53, SEAT_HEIGHT = 0.31, TRUNK = 0.288, THIGH = 0.245, SHANK = 0.246;
static const double SHOULDERS = 0.245, HIPS = 0.1, UPPER_ARM = 0.186, FOREARM = 0.146, HEAD = 0.075;

/* ---- who ---- */

static void linear(float rgb[3])
{
    for (int k = 0; k < 3; k++)
        rgb[k] = powf(rgb[k], 2.2f);
}

static void draw_hair(lt_rng *r, float rgb[3])
{
    const double hue = lt_rng_range(r, 0.03, 0.11), saturation = lt_rng_range(r, 0.1, 0.6);
    const double dark = lt_rng_uniform(r);

    pattern_hsv(hue, saturation, 0.06 + 0.7 * dark * dark, rgb);
    linear(rgb);
}

lt_status synth_person_draw(lt_arena *arena, const lt_hand_model *hand, uint64_t seed, int body, int clothes,
                            synth_person *out)
{
    lt_rng b = lt_rng_make(seed, lt_rng_mix(BODY, (uint64_t)body));
    lt_rng c = lt_rng_make(seed, lt_rng_mix(CLOTHES, (uint64_t)clothes));
    synth_person p = { .seed = seed, .stream = lt_rng_mix(CLOTHES, (uint64_t)clothes) };
    float rgb[3];

    synth_subject_draw(hand, seed, body, &p.subject);
    p.stature = fmax(1.5, fmin(1.95, 1.70 + 0.09 * lt_rng_normal(&b)));
    p.girth = fmax(0.85, fmin(1.3, 1.03 + 0.1 * lt_rng_normal(&b)));
    draw_hair(&b, p.hair);
    p.hair_length = lt_rng_range(&b, 1.2, 2.3);
    p.subject.bare = lt_rng_uniform(&c) < 0.35 ? 1 : lt_rng_range(&c, 0.01, 0.12);
    p.shirt = synth_arm_cloth(arena, seed, p.stream);
    pattern_draw_color(&c, 0, 0.5, 0.08, 0.6, rgb);
    p.trousers = pattern_weave(arena, &c, rgb);
    pattern_draw_color(&c, 0, 0.5, 0.05, 0.8, p.shoes);
    linear(p.shoes);
    if (!p.shirt || !p.trousers || !synth_texture_paint(p.shirt) || !synth_texture_paint(p.trousers))
        return lt_error(LT_ENOMEM, "synth: no memory for a person");
    *out = p;
    return LT_OK;
}

/* ---- where his joints are ---- */

typedef struct {
    double pelvis[3], neck[3], up[3], forward[3], left[3];      /* up, forward, left of the leaned trunk */
    double flat[3];                             /* forward along the floor */
} frame;

static void along(const double from[3], double s, const double dir[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = from[k] + s * dir[k];
}

static frame frame_of(const synth_person *p, const synth_stance *s)
{
    const double c = cos(s->facing), d = sin(s->facing), cl = cos(s->lean), sl = sin(s->lean);
    frame f = { .flat = { c, d, 0 }, .left = { -d, c, 0 }, .up = { sl * c, sl * d, cl },
                .forward = { cl * c, cl * d, -sl } };

    memcpy(f.pelvis, s->at, sizeof(f.pelvis));
    f.pelvis[2] += p->stature * (s->sits ? SEAT_HEIGHT : HIP_HEIGHT);
    along(f.pelvis, TRUNK * p->stature, f.up, f.neck);
    return f;
}

void synth_person_reach(const synth_person *p, const synth_stance *s, synth_reach *out)
{
    const frame f = frame_of(p, s);
    double middle[3];

    along(f.neck, -0.03 * p->stature, f.up, middle);
    for (int a = 0; a < 2; a++)
        along(middle, (a ? -0.5 : 0.5) * SHOULDERS * p->stature, f.left, out->shoulder[a]);
    out->upper = UPPER_ARM * p->stature;
    out->fore = FOREARM * p->stature;
    memcpy(out->forward, f.flat, sizeof(out->forward));
    memcpy(out->left, f.left, sizeof(out->left));
}

void synth_reach_elbow(const synth_reach *r, int arm, double swivel, double wrist[3], double elbow[3])
{
    const double *s = r->shoulder[arm], most = 0.97 * (r->upper + r->fore), least = 0.35 * r->upper;
    double d[3], down[3], out[3], n, cosine, foot, off;

    lt_vec3_sub(wrist, s, d);
    n = lt_vec3_unit(d);
    n = fmax(least, fmin(most, n));
    along(s, n, d, wrist);
    cosine = (r->upper * r->upper + n * n - r->fore * r->fore) / (2 * r->upper * n);
    cosine = fmax(-1, fmin(1, cosine));
    foot = r->upper * cosine;
    off = r->upper * sqrt(1 - cosine * cosine);
    for (int k = 0; k < 3; k++)                 /* down, away from the trunk and a little back */
        down[k] = -cos(swivel) * (k == 2) + sin(swivel) * (arm ? -1 : 1) * r->left[k] - 0.3 * r->forward[k];
    along(down, -lt_vec3_dot(down, d), d, out);
    lt_vec3_unit(out);
    for (int k = 0; k < 3; k++)
        elbow[k] = s[k] + foot * d[k] + off * out[k];
}

/* ---- meshes ---- */

typedef struct {
    lt_arena *arena;
    const synth_person *p;
    frame f;
    synth_world *world;
    int thing;
    lt_status status;
} builder;

static void put(builder *b, lt_mesh mesh, const synth_material *material)
{
    synth_instance in = { .R_world_obj = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, .material = *material, .moving = true };
    lt_mesh *kept = lt_arena_alloc(b->arena, sizeof(*kept));

    if (!kept || !mesh.n_vertices) {
        b->status = lt_error(LT_ENOMEM, "synth: no memory for a person");
        return;
    }
    *kept = mesh;
    in.mesh = kept;
    synth_world_place(b->world, b->thing, &in);
}

static synth_material cloth(synth_texture *texture)
{
    return (synth_material){ .albedo = { 1, 1, 1 }, .specular = 0.01f, .shininess = 6, .texture = texture };
}

static synth_material plain(const float rgb[3], float specular, float shininess, float translucency)
{
    return (synth_material){ .albedo = { rgb[0], rgb[1], rgb[2] }, .specular = specular, .shininess = shininess,
                             .translucency = translucency };
}

/* A section of the trunk: its height as a share of the trunk, half its width and depth as shares of the stature. */
typedef struct { double at, wide, deep, forward; } section;

static section between(const section *s, int n, double at)
{
    int i = 0;
    double t;

    while (i + 2 < n && at > s[i + 1].at)
        i++;
    t = (at - s[i].at) / (s[i + 1].at - s[i].at);
    t = t * t * (3 - 2 * t);
    return (section){ at, s[i].wide + t * (s[i + 1].wide - s[i].wide), s[i].deep + t * (s[i + 1].deep - s[i].deep),
                      s[i].forward + t * (s[i + 1].forward - s[i].forward) };
}

/* A trunk through n sections. */
static lt_mesh loft(const builder *b, const section *s, int n, double repeat)
{
    const double stature = b->p->stature, girth = b->p->girth;
    lt_mesh m = primitive_alloc(b->arena, LOFT * (AROUND + 1), 2 * (LOFT - 1) * AROUND);

    for (int r = 0; r < LOFT && m.n_vertices; r++) {
        const section q = between(s, n, s[0].at + (s[n - 1].at - s[0].at) * r / (LOFT - 1));
        for (int i = 0; i <= AROUND; i++) {
            const double a = 2 * M_PI * (i % AROUND) / AROUND;
            const double side = girth * q.wide * cos(a), front = girth * q.deep * sin(a) + q.forward;
            const int v = r * (AROUND + 1) + i;
            for (int k = 0; k < 3; k++)
                m.vertex[v][k] = (float)(b->f.pelvis[k] + stature * (q.at * TRUNK * b->f.up[k] - side * b->f.left[k] +
                                                                     front * b->f.forward[k]));
            m.uv[v][0] = (float)(repeat * 4 * i / AROUND);
            m.uv[v][1] = (float)(repeat * 2 * (q.at + 1));
        }
    }
    if (m.n_vertices)
        primitive_weave(&m, LOFT, AROUND);
    return m;
}

/* A closed limb through n points; the last ring and the first come to a point. */
static lt_mesh limb(const builder *b, double (*point)[3], const double *radius, int n)
{
    enum { STEPS = 6, MOST = 4 };
    float path[(MOST - 1) * STEPS + 3][3], thick[(MOST - 1) * STEPS + 3];
    float side[3];
    int rings = 0;
    lt_mesh m;

    for (int k = 0; k < 3; k++)
        side[k] = (float)b->f.left[k];
    for (int i = 0; i + 1 < n; i++)
        for (int j = 0; j < STEPS + (i + 2 == n); j++, rings++) {
            const double t = (double)j / STEPS;
            thick[rings + 1] = (float)(radius[i] + t * (radius[i + 1] - radius[i]));
            for (int k = 0; k < 3; k++)
                path[rings + 1][k] = (float)(point[i][k] + t * (point[i + 1][k] - point[i][k]));
        }
    for (int end = 0; end < 2; end++) {
        const int at = end ? rings + 1 : 0, next = end ? rings : 1, then = end ? rings - 1 : 2;
        const float length = (float)lt_vec3_distance(point[end ? n - 2 : 0], point[end ? n - 1 : 1]);
        for (int k = 0; k < 3; k++)
            path[at][k] = path[next][k] +
                0.6f * thick[next] * (path[next][k] - path[then][k]) * STEPS / fmaxf(length, 1e-3f);
        thick[at] = 0.15f * thick[next];
    }
    m = primitive_tube(b->arena, (const float (*)[3])path, thick, rings + 2, 1, side, 16);
    for (int v = 0; v < m.n_vertices; v++)
        m.uv[v][1] *= 2;
    return m;
}

/* An egg about c with half axes along left, forward and up of the head, from the crown down to the angle `to`. */
static lt_mesh egg(const builder *b, const double R[9], const double c[3], const double axis[3], double to)
{
    lt_mesh m = primitive_alloc(b->arena, BALL * (AROUND + 1), 2 * (BALL - 1) * AROUND);

    for (int r = 0; r < BALL && m.n_vertices; r++) {
        const double down = to * (BALL - 1 - r) / (BALL - 1), s = sin(down), z = cos(down);
        const double chin = z < 0 ? 1 + 0.25 * z : 1;
        for (int i = 0; i <= AROUND; i++) {
            const double a = 2 * M_PI * (i % AROUND) / AROUND;
            const double local[3] = { -axis[0] * chin * s * cos(a), axis[1] * chin * s * sin(a), axis[2] * z };
            for (int k = 0; k < 3; k++)
                m.vertex[r * (AROUND + 1) + i][k] = (float)(c[k] + local[0] * R[k] + local[1] * R[3 + k] +
                                                            local[2] * R[6 + k]);
        }
    }
    if (m.n_vertices)
        primitive_weave(&m, BALL, AROUND);
    return m;
}

/* Rows left, forward, up of the head. */
static void turn_head(const frame *f, const synth_stance *s, double R[9])
{
    const double cl = cos(s->look), sl = sin(s->look), cn = cos(s->nod), sn = sin(s->nod);

    for (int k = 0; k < 3; k++) {
        const double ahead = cl * f->flat[k] + sl * f->left[k], up = k == 2;
        R[k] = cl * f->left[k] - sl * f->flat[k];
        R[3 + k] = cn * ahead - sn * up;
        R[6 + k] = cn * up + sn * ahead;
    }
}

/* Of the head: a spot at shares of the stature left, forward, up of its middle. */
static void spot(const double R[9], const double middle[3], double size, double left, double ahead, double up,
                 double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = middle[k] + size * (left * R[k] + ahead * R[3 + k] + up * R[6 + k]);
}

static void build_head(builder *b, const synth_stance *s)
{
    static const float white[3] = { 0.75f, 0.74f, 0.72f }, dark[3] = { 0.03f, 0.02f, 0.02f };
    const double size = b->p->stature;
    const synth_material skin = plain(b->p->subject.skin, 0.028f, 12, 1), hair = plain(b->p->hair, 0.03f, 25, 0);
    const synth_material eye = plain(white, 0.05f, 60, 0), pupil = plain(dark, 0.05f, 60, 0);
    float lip[3] = { 0.8f * b->p->subject.skin[0], 0.45f * b->p->subject.skin[1], 0.45f * b->p->subject.skin[2] };
    const synth_material mouth = plain(lip, 0.03f, 20, 0);
    double R[9], neck[2][3], middle[3], at[3];

    turn_head(&b->f, s, R);
    along(b->f.neck, -0.02 * size, b->f.up, neck[0]);
    along(b->f.neck, 0.05 * size, b->f.up, neck[1]);
    spot(R, neck[1], size, 0, 0.012, 0.05, middle);
    put(b, limb(b, neck, (const double[]){ 0.037 * size, 0.033 * size }, 2), &skin);
    put(b, egg(b, R, middle, (const double[]){ 0.045 * size, 0.055 * size, HEAD * size }, M_PI), &skin);
    spot(R, middle, size, 0, -0.008, 0.008, at);
    put(b, egg(b, R, at, (const double[]){ 0.049 * size, 0.056 * size, 0.074 * size }, b->p->hair_length), &hair);
    spot(R, middle, size, 0, 0.056, -0.012, at);
    put(b, egg(b, R, at, (const double[]){ 0.008 * size, 0.011 * size, 0.018 * size }, M_PI), &skin);
    spot(R, middle, size, 0, 0.0475, -0.036, at);
    put(b, egg(b, R, at, (const double[]){ 0.014 * size, 0.005 * size, 0.004 * size }, M_PI), &mouth);
    for (int i = -1; i <= 1; i += 2) {
        spot(R, middle, size, 0.018 * i, 0.0455, 0.006, at);
        put(b, egg(b, R, at, (const double[]){ 0.008 * size, 0.005 * size, 0.005 * size }, M_PI), &eye);
        spot(R, middle, size, 0.018 * i, 0.048, 0.006, at);
        put(b, egg(b, R, at, (const double[]){ 0.004 * size, 0.004 * size, 0.0042 * size }, M_PI), &pupil);
        spot(R, middle, size, 0.018 * i, 0.0465, 0.018, at);
        put(b, egg(b, R, at, (const double[]){ 0.012 * size, 0.004 * size, 0.003 * size }, M_PI), &hair);
        spot(R, middle, size, 0.046 * i, -0.002, 0, at);
        put(b, egg(b, R, at, (const double[]){ 0.006 * size, 0.012 * size, 0.019 * size }, M_PI), &skin);
    }
}

static void build_trunk(builder *b)
{
    static const section shirt[] = {
        { -0.16, 0.096, 0.07, 0 }, { 0.05, 0.098, 0.069, 0 }, { 0.35, 0.084, 0.06, 0 }, { 0.68, 0.1, 0.068, 0.004 },
        { 0.88, 0.112, 0.058, 0 }, { 0.97, 0.095, 0.046, 0 }, { 1.02, 0.055, 0.038, 0 }, { 1.06, 0.034, 0.033, 0 },
    };
    static const section trousers[] = {
        { -0.34, 0.03, 0.03, 0 }, { -0.25, 0.08, 0.055, 0 }, { -0.1, 0.094, 0.068, 0 }, { 0.05, 0.094, 0.066, 0 },
    };
    const synth_material above = cloth(b->p->shirt), below = cloth(b->p->trousers);

    put(b, loft(b, shirt, LT_COUNT(shirt), 1), &above);
    put(b, loft(b, trousers, LT_COUNT(trousers), 1), &below);
}

static void build_leg(builder *b, const synth_stance *s, int side)
{
    const double size = b->p->stature, sign = side ? -1 : 1, swing = s->sits ? M_PI / 2 - 0.08 : s->stride[side];
    const double shin = s->sits ? 0.12 : (swing < 0 ? 1.8 : 0.7) * swing;      /* a leg behind him is bent */
    const double girth = b->p->girth * size;
    const synth_material below = cloth(b->p->trousers), shoe = plain(b->p->shoes, 0.04f, 25, 0);
    double leg[3][3], foot[2][3];

    along(b->f.pelvis, 0.5 * HIPS * size * sign, b->f.left, leg[0]);
    leg[0][2] -= 0.01 * size;
    for (int k = 0; k < 3; k++) {
        leg[1][k] = leg[0][k] + THIGH * size * (sin(swing) * b->f.flat[k] - cos(swing) * (k == 2));
        leg[2][k] = leg[1][k] + SHANK * size * (sin(shin) * b->f.flat[k] - cos(shin) * (k == 2));
        foot[0][k] = leg[2][k] - 0.015 * size * b->f.flat[k] - 0.018 * size * (k == 2);
        foot[1][k] = foot[0][k] + 0.105 * size * b->f.flat[k] - 0.008 * size * (k == 2);
    }
    put(b, limb(b, leg, (const double[]){ 0.05 * girth, 0.036 * girth, 0.028 * girth }, 3), &below);
    put(b, limb(b, foot, (const double[]){ 0.026 * size, 0.02 * size }, 2), &shoe);
}

static void build_arm(builder *b, const double shoulder[3], const double elbow[3])
{
    const double girth = b->p->girth * b->p->stature;
    const synth_material sleeve = cloth(b->p->shirt);
    double arm[2][3];

    memcpy(arm[0], shoulder, sizeof(arm[0]));
    memcpy(arm[1], elbow, sizeof(arm[1]));
    put(b, limb(b, arm, (const double[]){ 0.034 * girth, 0.0275 * girth }, 2), &sleeve);
}

lt_status synth_person_place(lt_arena *arena, const synth_person *p, const synth_stance *s, double elbow[2][3],
                             int identity, synth_world *w, int *thing)
{
    builder b = { .arena = arena, .p = p, .f = frame_of(p, s), .world = w };
    synth_reach reach;

    *thing = b.thing = synth_world_thing(w, &(synth_thing){ .kind = SYNTH_PERSON_THING, .owner = -1,
                                                            .identity = identity });
    if (b.thing < 0)
        return LT_OK;
    synth_person_reach(p, s, &reach);
    build_trunk(&b);
    build_head(&b, s);
    for (int side = 0; side < 2; side++) {
        build_leg(&b, s, side);
        build_arm(&b, reach.shoulder[side], elbow[side]);
    }
    return b.status;
}
