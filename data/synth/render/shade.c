/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lambert and Blinn under lamps, a hemisphere of ambient light, and its mirror image by Schlick's
 * Fresnel term. Skin lets light creep past the edge of a shadow, red farther than blue.
 */
#include "data/synth/render/shade.h"
#include "data/synth/render/grain.h"
#include "data/synth/render/small.h"
#include "data/synth/render/texture.h"

#include <string.h>

/* How far light creeps through skin, as a share of the half turn from lit to unlit. */
static const v4 creep = { 0.28f, 0.11f, 0.07f, 0 };

typedef struct {
    const synth_material *material;
    v4 p, n;                        /* n towards the side that is seen */
    v4 view;                        /* towards the eye */
    v4 albedo;
    v4 tint;                        /* of what is mirrored: white, or the albedo for metal */
} surface;

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

/* uv = sum e_i uv_i / sum e_i, so its slope follows from the slopes of both sums. */
static v4 sample_texture(const synth_texture *texture, const raster_triangle *t, float (*mesh_uv)[2],
                         const int32_t *corner, v4 b, float z, float step)
{
    const v4 a[3] = { uv_of(mesh_uv[corner[0]]), uv_of(mesh_uv[corner[1]]), uv_of(mesh_uv[corner[2]]) };
    const v4 uv = blend(a[0], a[1], a[2], b), per_pixel = v4_all(z * step);
    const v4 dx = blend(a[0] - uv, a[1] - uv, a[2] - uv, t->e[0] * per_pixel);
    const v4 dy = blend(a[0] - uv, a[1] - uv, a[2] - uv, t->e[1] * per_pixel);

    return texture_sample(texture, uv, dx, dy);
}

static v4 find_albedo(const synth_instance *in, const raster_triangle *t, v4 b, float z, float step)
{
    const lt_mesh *m = in->mesh;
    const int32_t *v = m->face[t->face];
    v4 out = v4_of3(in->material.albedo);

    if (m->color)
        out *= blend3((const float (*)[3])m->color, v, b);
    if (in->material.texture && m->uv)
        out *= sample_texture(in->material.texture, t, m->uv, v, b, z, step);
    return out;
}

static void add_grain(const synth_instance *in, const int32_t v[3], v4 b, float pixel,
                      surface *out)
{
    const float (*rest)[3] = in->rest ? in->rest : (const float (*)[3])in->mesh->vertex;
    float q[3], albedo[3], n[3];

    v4_to3(blend3(rest, v, b), q);
    v4_to3(out->albedo, albedo);
    v4_to3(out->n, n);
    grain_apply(q, in->material.grain, pixel, albedo, n);
    out->albedo = v4_of3(albedo);
    out->n = v4_of3(n);
}

static surface find_surface(const shade_scene *s, const raster_triangle *t, float x, float y, float step)
{
    const synth_instance *in = &s->scene->instance[t->instance];
    const int32_t *v = in->mesh->face[t->face];
    const size_t first = s->first[t->instance];
    const v4 *p = s->position + first;
    surface out = { .material = &in->material };
    v4 b;
    const float z = 1 / raster_corner(t, x, y, &b);

    b *= v4_all(z);
    out.p = blend(p[v[0]], p[v[1]], p[v[2]], b);
    out.n = find_normal(s, t, first, v, b);
    out.albedo = find_albedo(in, t, b, z, step);
    if (in->material.grain > 0)
        add_grain(in, v, b, z / (float)s->scene->camera.fx, &out);
    out.view = s->eye - out.p;
    v4_normalise3(&out.view);
    out.tint = v4_all(1) + v4_all(in->material.metal) * (out.albedo - v4_all(1));
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

static v4 find_ambient(const shade_scene *sc, const surface *s)
{
    const synth_material *m = s->material;
    const float nv = v4_dot3(s->n, s->view);
    const v4 diffuse = s->albedo * v4_all(1 - m->metal) * surroundings(sc, s->n, 1);

    if (m->specular <= 0)
        return diffuse;
    return diffuse + v4_all(1.6f * fresnel(m, nv)) * s->tint *
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

static v4 find_direct(const shade_scene *sc, int index, const surface *s, float spin, shade_shadow *shadow)
{
    float *lit = &shadow->lit[index], shine, nl, distance, fall;
    v4 l = sc->lamp[index] - s->p;

    distance = v4_normalise3(&l);
    fall = sc->distance2[index] / most(distance * distance, 1e-4f);
    nl = v4_dot3(s->n, l);
    if (nl < -creep[0] * s->material->translucency)
        return v4_all(0);
    if (*lit < 0)
        *lit = shadow_at(&sc->shadow[index], s->p, s->n, spin);
    if (*lit == 0)
        return v4_all(0);
    shine = nl > 0 ? nl * highlight(s, l) * *lit : 0;
    return v4_all(fall) * sc->color[index] *
           (s->albedo * v4_all(1 - s->material->metal) * diffuse_cosine(s, nl, *lit) + v4_all(shine) * s->tint);
}

shade_light shade(const shade_scene *sc, const raster_triangle *t, float x, float y, float step,
                  float spin, shade_shadow *shadow)
{
    const surface s = find_surface(sc, t, x, y, step);
    shade_light out = { find_ambient(sc, &s), v4_all(0) };

    if (shadow->instance != t->instance)
        *shadow = (shade_shadow){ t->instance, { -1, -1, -1, -1 } };
    for (int i = 0; i < sc->scene->n_lights; i++)
        out.direct += find_direct(sc, i, &s, spin, shadow);
    return out;
}
