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
static const float creep[3] = { 0.28f, 0.11f, 0.07f };

typedef struct {
    const synth_material *material;
    float p[3], n[3];               /* n towards the side that is seen */
    float view[3];                  /* towards the eye */
    float albedo[3];
} surface;

static void turn(const double R[9], const float x[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = (float)(R[3 * i] * x[0] + R[3 * i + 1] * x[1] + R[3 * i + 2] * x[2]);
}

static void move_instance(shade_scene *s, const synth_instance *in, size_t first)
{
    for (int v = 0; v < in->mesh->n_vertices; v++) {
        float *p = s->position[first + (size_t)v], *n = s->normal[first + (size_t)v];

        turn(in->R_world_obj, in->mesh->vertex[v], p);
        for (int i = 0; i < 3; i++)
            p[i] += (float)in->t_world_obj[i];
        memset(n, 0, 3 * sizeof(*n));
        if (in->mesh->normal)
            turn(in->R_world_obj, in->mesh->normal[v], n);
    }
}

bool shade_prepare(shade_scene *s, const synth_scene *scene, const shadow_map *shadow)
{
    const synth_camera *cam = &scene->camera;
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
    for (int i = 0; i < 3; i++)
        s->eye[i] = -(float)(cam->R_cam_world[i] * cam->t_cam_world[0] +
                             cam->R_cam_world[3 + i] * cam->t_cam_world[1] +
                             cam->R_cam_world[6 + i] * cam->t_cam_world[2]);
    for (int l = 0; l < scene->n_lights; l++) {
        s->distance2[l] = 0;
        for (int i = 0; i < 3; i++) {
            const float d = (float)(scene->light[l].position[i] - scene->focus[i]);

            s->distance2[l] += d * d;
        }
    }
    return true;
}

void shade_fini(shade_scene *s)
{
    lt_release(s->position);
    lt_release(s->normal);
    lt_release(s->first);
}

/* b: barycentric coordinates, adding to 1 */
static void blend3(const float *v0, const float *v1, const float *v2, const float b[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = b[0] * v0[i] + b[1] * v1[i] + b[2] * v2[i];
}

static void find_normal(const shade_scene *s, const raster_triangle *t, const size_t v[3],
                         const float b[3], surface *out)
{
    const float *p0 = s->position[v[0]], *p1 = s->position[v[1]], *p2 = s->position[v[2]];
    const float side = t->back ? -1 : 1;
    float a[3], c[3];

    for (int i = 0; i < 3; i++) {
        a[i] = p1[i] - p0[i];
        c[i] = p2[i] - p0[i];
    }
    blend3(s->normal[v[0]], s->normal[v[1]], s->normal[v[2]], b, out->n);
    if (dot3(out->n, out->n) == 0)
        cross3(a, c, out->n);
    for (int i = 0; i < 3; i++)
        out->n[i] *= side;
    normalise3(out->n);
}

/* uv = sum e_i uv_i / sum e_i, so its slope follows from the slopes of both sums. */
static void sample_texture(const synth_texture *texture, const raster_triangle *t, float (*mesh_uv)[2],
                           const int32_t *corner, const float b[3], float z, float step, float rgb[3])
{
    float uv[2] = { 0, 0 }, slope[2][2] = { { 0 } };

    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 2; k++)
            uv[k] += b[i] * mesh_uv[corner[i]][k];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 2; k++)
            for (int d = 0; d < 2; d++)
                slope[d][k] += t->e[i][d] * (mesh_uv[corner[i]][k] - uv[k]) * z * step;
    texture_sample(texture, uv, slope[0], slope[1], rgb);
}

static void find_albedo(const synth_instance *in, const raster_triangle *t, const float b[3], float z,
                        float step, surface *out)
{
    const lt_mesh *m = in->mesh;
    const int32_t *v = m->face[t->face];
    float tint[3] = { 1, 1, 1 }, texel[3] = { 1, 1, 1 };

    if (m->color)
        blend3(m->color[v[0]], m->color[v[1]], m->color[v[2]], b, tint);
    if (in->material.texture && m->uv)
        sample_texture(in->material.texture, t, m->uv, v, b, z, step, texel);
    for (int i = 0; i < 3; i++)
        out->albedo[i] = in->material.albedo[i] * tint[i] * texel[i];
}

static void add_grain(const synth_instance *in, const int32_t v[3], const float b[3], float pixel,
                      surface *out)
{
    const float (*rest)[3] = in->rest ? in->rest : (const float (*)[3])in->mesh->vertex;
    float q[3];

    blend3(rest[v[0]], rest[v[1]], rest[v[2]], b, q);
    grain_apply(q, in->material.grain, pixel, out->albedo, out->n);
}

static surface find_surface(const shade_scene *s, const raster_triangle *t, float x, float y, float step)
{
    const synth_instance *in = &s->scene->instance[t->instance];
    const int32_t *v = in->mesh->face[t->face];
    const size_t first = s->first[t->instance];
    const size_t corner[3] = { first + (size_t)v[0], first + (size_t)v[1], first + (size_t)v[2] };
    surface out = { .material = &in->material };
    float b[3];
    const float z = 1 / raster_corner(t, x, y, b);

    for (int i = 0; i < 3; i++)
        b[i] *= z;
    blend3(s->position[corner[0]], s->position[corner[1]], s->position[corner[2]], b, out.p);
    find_normal(s, t, corner, b, &out);
    find_albedo(in, t, b, z, step, &out);
    if (in->material.grain > 0)
        add_grain(in, v, b, z / (float)s->scene->camera.fx, &out);
    for (int i = 0; i < 3; i++)
        out.view[i] = s->eye[i] - out.p[i];
    normalise3(out.view);
    return out;
}

/* Schlick's Fresnel term; rough surfaces shine less at the edge. */
static float fresnel(const synth_material *m, float cosine)
{
    const float k = 1 - within(cosine, 0, 1), k2 = k * k;
    const float edge = least(m->shininess / 60, 1);

    return m->specular + (1 - m->specular) * edge * k2 * k2 * k;
}

/* What the surroundings send from direction d: sky above, ground below, a soft horizon. */
static void surroundings(const synth_scene *scene, const float d[3], float softness, float out[3])
{
    const float h = within(0.5f + 0.5f * dot3(d, scene->up) / softness, 0, 1);

    for (int c = 0; c < 3; c++)
        out[c] = scene->ground[c] + h * (scene->sky[c] - scene->ground[c]);
}

static float tinted(const surface *s, int channel)
{
    return 1 + s->material->metal * (s->albedo[channel] - 1);
}

static void add_ambient(const synth_scene *scene, const surface *s, shade_light *out)
{
    const float nv = dot3(s->n, s->view), f = s->material->specular > 0 ? fresnel(s->material, nv) : 0;
    float mirror[3], around[3], mirrored[3];

    for (int i = 0; i < 3; i++)
        mirror[i] = 2 * nv * s->n[i] - s->view[i];
    surroundings(scene, s->n, 1, around);
    surroundings(scene, mirror, 0.5f, mirrored);
    for (int c = 0; c < 3; c++)
        out->ambient[c] = s->albedo[c] * (1 - s->material->metal) * around[c] +
                          1.6f * f * tinted(s, c) * mirrored[c];
}

/* Blinn's lobe, scaled so that it sends out no more than it receives. */
static float highlight(const surface *s, const float l[3])
{
    const float n = s->material->shininess;
    float h[3], nh;

    for (int i = 0; i < 3; i++)
        h[i] = l[i] + s->view[i];
    normalise3(h);
    nh = dot3(s->n, h);
    if (s->material->specular <= 0 || n * (1 - nh) > 8)
        return 0;
    return (n + 8) / 8 * powf(nh, n) * fresnel(s->material, dot3(h, l));
}

/* Lambert's cosine; with translucency the light wraps around the edge of day. */
static float diffuse_cosine(const surface *s, float nl, int channel)
{
    const float w = s->material->translucency * creep[channel];
    const float k = most((nl + w) / (1 + w), 0);

    return w > 0 ? k * (0.75f + 0.25f * k) : k;
}

/* Towards the lamp, and how much of its light at the focus arrives here. */
static float find_lamp(const shade_scene *sc, int index, const surface *s, float l[3])
{
    float distance;

    for (int i = 0; i < 3; i++)
        l[i] = (float)sc->scene->light[index].position[i] - s->p[i];
    distance = normalise3(l);
    return sc->distance2[index] / most(distance * distance, 1e-4f);
}

static void add_light(const shade_scene *sc, int index, const surface *s, float spin, shade_shadow *shadow,
                      shade_light *out)
{
    float l[3], *lit = &shadow->lit[index];
    const float fall = find_lamp(sc, index, s, l), nl = dot3(s->n, l);
    float shine;

    if (nl < -creep[0] * s->material->translucency)
        return;
    if (*lit < 0)
        *lit = shadow_at(&sc->shadow[index], s->p, s->n, spin);
    if (*lit == 0)
        return;
    shine = nl > 0 ? nl * highlight(s, l) * *lit : 0;
    for (int c = 0; c < 3; c++) {
        const float glow = s->material->translucency * creep[c] * *lit * (1 - *lit);
        const float diffuse = s->albedo[c] * (1 - s->material->metal) * diffuse_cosine(s, nl, c);

        out->direct[c] += fall * sc->scene->light[index].color[c] *
                          (diffuse * (*lit + glow) + shine * tinted(s, c));
    }
}

shade_light shade(const shade_scene *sc, const raster_triangle *t, float x, float y, float step,
                  float spin, shade_shadow *shadow)
{
    const surface s = find_surface(sc, t, x, y, step);
    shade_light out = { { 0 }, { 0 } };

    if (shadow->instance != t->instance)
        *shadow = (shade_shadow){ t->instance, { -1, -1, -1, -1 } };
    add_ambient(sc->scene, &s, &out);
    for (int i = 0; i < sc->scene->n_lights; i++)
        add_light(sc, i, &s, spin, shadow, &out);
    return out;
}
