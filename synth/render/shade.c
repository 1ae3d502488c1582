/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lambert and Blinn under lamps, a hemisphere of ambient light, and its mirror image by Schlick's
 * Fresnel term. Skin lets light creep past the edge of a shadow, red farther than blue.
 */
#include "synth/render/grain.h"
#include "synth/render/shade.h"
#include "synth/render/small.h"
#include "synth/render/texture.h"

#include <string.h>

/* How far light creeps through skin, as a share of the half turn from lit to unlit. */
static const v4 creep = { 0.28f, 0.11f, 0.07f, 0 };

/* A place on a triangle. */
typedef struct {
    const synth_instance *in;
    const raster_triangle *t;
    const int32_t *v;               /* the triangle's corners in the mesh */
    v4 b;                           /* barycentric coordinates */
    float z;
} place;

typedef struct {
    const synth_material *material;
    v4 p, n;                        /* n towards the side that is seen */
    v4 view;                        /* towards the eye */
} surface;

/* Light on a surface, whatever its colour: what it scatters, and what it mirrors to the eye. */
typedef struct {
    struct { v4 scattered, mirrored; } ambient, direct;
} light;

/* ---- the scene in single precision ----------------------------------------------------------- */

static v4 turn(const double R[9], const float x[3])
{
    v4 out = v4_all(0);

    for (int i = 0; i < 3; i++)
        out[i] = (float)(R[3 * i] * x[0] + R[3 * i + 1] * x[1] + R[3 * i + 2] * x[2]);
    return out;
}

static v4 single(const double x[3])
{
    return (v4){ (float)x[0], (float)x[1], (float)x[2], 0 };
}

static void move_instance(shade_scene *s, const synth_instance *in, size_t first)
{
    const v4 t = single(in->t_world_obj);

    for (int v = 0; v < in->mesh->n_vertices; v++) {
        s->position[first + (size_t)v] = turn(in->R_world_obj, in->mesh->vertex[v]) + t;
        s->normal[first + (size_t)v] = in->mesh->normal ? turn(in->R_world_obj, in->mesh->normal[v])
                                                        : v4_all(0);
    }
}

static void move_lights(shade_scene *s)
{
    const synth_scene *scene = s->scene;
    const synth_camera *cam = &scene->camera;

    s->up = v4_of3(scene->up);
    s->sky = v4_of3(scene->sky);
    s->ground = v4_of3(scene->ground);
    for (int i = 0; i < 3; i++)
        s->eye[i] = -(float)(cam->R_cam_world[i] * cam->t_cam_world[0] +
                             cam->R_cam_world[3 + i] * cam->t_cam_world[1] +
                             cam->R_cam_world[6 + i] * cam->t_cam_world[2]);
    for (int l = 0; l < scene->n_lights; l++) {
        const v4 d = single(scene->light[l].position) - single(scene->focus);

        s->lamp[l] = single(scene->light[l].position);
        s->color[l] = v4_of3(scene->light[l].color);
        s->distance2[l] = v4_dot3(d, d);
    }
}

bool shade_prepare(shade_scene *s, const synth_scene *scene, const shadow_map *shadow)
{
    size_t n = 0;

    if (!raster_grow(&s->first, &s->first_capacity, (size_t)scene->n_instances, sizeof(*s->first)))
        return false;
    for (int i = 0; i < scene->n_instances; i++) {
        s->first[i] = n;
        n += (size_t)scene->instance[i].mesh->n_vertices;
    }
    if (!raster_grow(&s->position, &s->positions_capacity, n, sizeof(*s->position)) ||
        !raster_grow(&s->normal, &s->normals_capacity, n, sizeof(*s->normal)))
        return false;
    for (int i = 0; i < scene->n_instances; i++)
        move_instance(s, &scene->instance[i], s->first[i]);
    s->scene = scene;
    s->shadow = shadow;
    move_lights(s);
    return true;
}

void shade_fini(shade_scene *s)
{
    lt_release(s->position);
    lt_release(s->normal);
    lt_release(s->first);
}

/* ---- the surface ----------------------------------------------------------------------------- */

/* b: barycentric coordinates, adding to 1 */
static v4 blend(v4 v0, v4 v1, v4 v2, v4 b)
{
    return v4_all(b[0]) * v0 + v4_all(b[1]) * v1 + v4_all(b[2]) * v2;
}

static v4 blend3(const float (*v)[3], const int32_t corner[3], v4 b)
{
    return blend(v4_of3(v[corner[0]]), v4_of3(v[corner[1]]), v4_of3(v[corner[2]]), b);
}

/* Across the face, when the mesh has no normals. */
static v4 face_normal(const v4 *p0, const v4 *p1, const v4 *p2)
{
    float a[3], c[3], n[3];

    v4_to3(*p1 - *p0, a);
    v4_to3(*p2 - *p0, c);
    cross3(a, c, n);
    return v4_of3(n);
}

static v4 find_normal(const shade_scene *s, const raster_triangle *t, size_t first, const int32_t v[3], v4 b)
{
    const v4 *p = s->position + first, *n = s->normal + first;
    v4 out = blend(n[v[0]], n[v[1]], n[v[2]], b);

    if (v4_dot3(out, out) == 0)
        out = face_normal(&p[v[0]], &p[v[1]], &p[v[2]]);
    if (t->back)
        out = -out;
    v4_normalise3(&out);
    return out;
}

static v4 uv_of(const float uv[2])
{
    return (v4){ uv[0], uv[1], 0, 0 };
}

static place find_place(const shade_scene *s, const raster_triangle *t, float x, float y)
{
    const synth_instance *in = &s->scene->instance[t->instance];
    place out = { .in = in, .t = t, .v = in->mesh->face[t->face] };

    out.z = 1 / raster_corner(t, x, y, &out.b);
    out.b *= v4_all(out.z);
    return out;
}

static bool has_texture(const place *at)
{
    return at->in->material.texture && at->in->mesh->uv;
}

/* uv at the triangle's corners */
static void corner_uv(const place *at, v4 uv[3])
{
    for (int i = 0; i < 3; i++)
        uv[i] = uv_of(at->in->mesh->uv[at->v[i]]);
}

/* uv = sum e_i uv_i / sum e_i, so its slope follows from the slopes of both sums. */
static texture_footprint find_footprint(const place *at, float step)
{
    const v4 per_pixel = v4_all(at->z * step), *e = at->t->e;
    v4 a[3], uv;

    if (!has_texture(at))
        return (texture_footprint){ 0 };
    corner_uv(at, a);
    uv = blend(a[0], a[1], a[2], at->b);
    return texture_cover(at->in->material.texture, blend(a[0] - uv, a[1] - uv, a[2] - uv, e[0] * per_pixel),
                         blend(a[0] - uv, a[1] - uv, a[2] - uv, e[1] * per_pixel));
}

static v4 find_albedo(const place *at, const texture_footprint *footprint)
{
    const lt_mesh *m = at->in->mesh;
    v4 out = v4_of3(at->in->material.albedo), a[3];

    if (m->color)
        out *= blend3((const float (*)[3])m->color, at->v, at->b);
    if (!has_texture(at))
        return out;
    corner_uv(at, a);
    return out * texture_sample(at->in->material.texture, blend(a[0], a[1], a[2], at->b), footprint);
}

static void add_grain(const shade_scene *s, const place *at, v4 *albedo, v4 *normal)
{
    const synth_instance *in = at->in;
    const float (*rest)[3] = in->rest ? in->rest : (const float (*)[3])in->mesh->vertex;
    float q[3], color[3], n[3];

    v4_to3(blend3(rest, at->v, at->b), q);
    v4_to3(*albedo, color);
    v4_to3(*normal, n);
    grain_apply(q, in->material.grain, at->z / (float)s->scene->camera.fx, color, n);
    *albedo = v4_of3(color);
    *normal = v4_of3(n);
}

static surface find_surface(const shade_scene *s, const place *at)
{
    const size_t first = s->first[at->t->instance];
    const v4 *p = s->position + first;
    surface out = { .material = &at->in->material };

    out.p = blend(p[at->v[0]], p[at->v[1]], p[at->v[2]], at->b);
    out.n = find_normal(s, at->t, first, at->v, at->b);
    out.view = s->eye - out.p;
    v4_normalise3(&out.view);
    return out;
}

/* ---- light ----------------------------------------------------------------------------------- */

/* Schlick's Fresnel term; rough surfaces shine less at the edge. */
static float fresnel(const synth_material *m, float cosine)
{
    const float k = 1 - within(cosine, 0, 1), k2 = k * k;
    const float edge = least(m->shininess / 60, 1);

    return m->specular + (1 - m->specular) * edge * k2 * k2 * k;
}

/* What the surroundings send from direction d: sky above, ground below, a soft horizon. */
static v4 surroundings(const shade_scene *s, v4 d, float softness)
{
    const float h = within(0.5f + 0.5f * v4_dot3(d, s->up) / softness, 0, 1);

    return s->ground + v4_all(h) * (s->sky - s->ground);
}

static void add_ambient(const shade_scene *sc, const surface *s, light *out)
{
    const synth_material *m = s->material;
    const float nv = v4_dot3(s->n, s->view);

    out->ambient.scattered = surroundings(sc, s->n, 1);
    if (m->specular > 0)
        out->ambient.mirrored = v4_all(1.6f * fresnel(m, nv)) *
                                surroundings(sc, v4_all(2 * nv) * s->n - s->view, 0.5f);
}

/* Blinn's lobe, scaled so that it sends out no more than it receives. */
static float highlight(const surface *s, v4 l)
{
    const float n = s->material->shininess;
    v4 h = l + s->view;
    float nh;

    v4_normalise3(&h);
    nh = v4_dot3(s->n, h);
    if (s->material->specular <= 0 || n * (1 - nh) > 8)
        return 0;
    return (n + 8) / 8 * powf(nh, n) * fresnel(s->material, v4_dot3(h, l));
}

/* Lambert's cosine for each channel; with translucency the light wraps around the edge of day, and glows
 * where shadow begins. */
static v4 diffuse_cosine(const surface *s, float nl, float lit)
{
    const v4 w = v4_all(s->material->translucency) * creep;
    const v4 k = v4_positive((v4_all(nl) + w) / (v4_all(1) + w));

    if (s->material->translucency <= 0)
        return v4_all(most(nl, 0) * lit);
    return k * (v4_all(0.75f) + v4_all(0.25f) * k) * (v4_all(lit) + w * v4_all(lit * (1 - lit)));
}

static void add_direct(const shade_scene *sc, int index, const surface *s, float spin, shade_shadow *shadow,
                       light *out)
{
    float *lit = &shadow->lit[index], nl, distance;
    v4 l = sc->lamp[index] - s->p, color;

    distance = v4_normalise3(&l);
    nl = v4_dot3(s->n, l);
    if (nl < -creep[0] * s->material->translucency)
        return;
    if (*lit < 0)
        *lit = shadow_at(&sc->shadow[index], s->p, s->n, spin);
    if (*lit == 0)
        return;
    color = v4_all(sc->distance2[index] / most(distance * distance, 1e-4f)) * sc->color[index];
    out->direct.scattered += color * diffuse_cosine(s, nl, *lit);
    if (nl > 0)
        out->direct.mirrored += color * v4_all(nl * highlight(s, l) * *lit);
}

static light find_light(const shade_scene *sc, const surface *s, float spin, shade_shadow *shadow)
{
    light out = { 0 };

    add_ambient(sc, s, &out);
    for (int i = 0; i < sc->scene->n_lights; i++)
        add_direct(sc, i, s, spin, shadow, &out);
    return out;
}

/* What is mirrored is white, or has the albedo's colour for metal, which scatters nothing. */
static shade_sent send(const synth_material *m, v4 albedo, const light *l)
{
    const v4 scatter = albedo * v4_all(1 - m->metal), tint = v4_all(1) + v4_all(m->metal) * (albedo - v4_all(1));

    return (shade_sent){ scatter * l->ambient.scattered + tint * l->ambient.mirrored,
                         scatter * l->direct.scattered + tint * l->direct.mirrored };
}

static shade_shadow no_shadow(const raster_triangle *t)
{
    return (shade_shadow){ t->instance, { -1, -1, -1, -1 } };
}

shade_sent shade(const shade_scene *sc, const raster_triangle *t, float x, float y, float step,
                 float spin, shade_shadow *shadow)
{
    const place at = find_place(sc, t, x, y);
    const synth_material *m = &at.in->material;
    const texture_footprint footprint = find_footprint(&at, step);
    surface s = find_surface(sc, &at);
    v4 albedo = find_albedo(&at, &footprint);
    light l;

    if (m->grain > 0)
        add_grain(sc, &at, &albedo, &s.n);
    if (shadow->instance != t->instance)
        *shadow = no_shadow(t);
    l = find_light(sc, &s, spin, shadow);
    return send(m, albedo, &l);
}

static bool in_penumbra(const shade_scene *sc, const shade_shadow *shadow)
{
    for (int i = 0; i < sc->scene->n_lights; i++)
        if (shadow->lit[i] > 0 && shadow->lit[i] < 1)
            return true;
    return false;
}

bool shade_square(const shade_scene *sc, const raster_triangle *t, float x, float y, float step, float spin,
                  shade_sent out[4])
{
    const place middle = find_place(sc, t, x + step / 2, y + step / 2);
    const synth_material *m = &middle.in->material;
    shade_shadow shadow = no_shadow(t);
    texture_footprint footprint;
    surface s;
    light l;

    if (m->grain > 0)
        return false;
    s = find_surface(sc, &middle);
    l = find_light(sc, &s, spin, &shadow);
    if (in_penumbra(sc, &shadow))
        return false;
    footprint = find_footprint(&middle, step);
    for (int k = 0; k < 4; k++) {
        const place at = find_place(sc, t, x + step * (float)(k % 2), y + step * (float)(k / 2));

        out[k] = send(m, find_albedo(&at, &footprint), &l);
    }
    return true;
}
