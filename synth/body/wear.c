/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A posed body as meshes: skin, eyes, and what is worn. A piece's mesh is the skin's, moved out by what the piece says
 * and cut where it ends.
 */
#include "synth/body/clothes.h"

#include <math.h>
#include <string.h>

enum { V = BODY_VERTICES, F = BODY_FACES };

typedef struct {
    lt_arena *arena;
    const synth_body *body;
    const synth_appearance *look;
    const double (*vertices)[3];
    float (*normal)[3];
    rest_place *at;                             /* (V) */
    bool *bare;                                 /* (V) of a hand or an eye: nothing is worn there */
    float (*moved)[3], (*moved_normal)[3];
    double *there;                              /* (V) of the piece that is being cut */
    bool *hidden;                               /* (F) under a piece, a hand's breadth from its hems */
} wearing;

/* A corner of what is cut. */
typedef struct { double p[3], n[3], rest[3], there; } corner;

static void mesh_normals(const int32_t (*face)[3], const float (*p)[3], float (*normal)[3])
{
    memset(normal, 0, V * sizeof(*normal));
    for (int f = 0; f < F; f++) {
        const float *a = p[face[f][0]], *b = p[face[f][1]], *c = p[face[f][2]];
        const float u[3] = { b[0] - a[0], b[1] - a[1], b[2] - a[2] }, w[3] = { c[0] - a[0], c[1] - a[1], c[2] - a[2] };
        const float n[3] = { u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0] };

        for (int k = 0; k < 3; k++)
            for (int c2 = 0; c2 < 3; c2++)
                normal[face[f][k]][c2] += n[c2];
    }
    for (int v = 0; v < V; v++) {
        const float n = sqrtf(normal[v][0] * normal[v][0] + normal[v][1] * normal[v][1] + normal[v][2] * normal[v][2]);

        for (int k = 0; k < 3; k++)
            normal[v][k] /= fmaxf(n, 1e-12f);
    }
}

static bool get_arrays(wearing *w)
{
    w->normal = lt_arena_array(w->arena, V, sizeof(*w->normal));
    w->moved = lt_arena_array(w->arena, V, sizeof(*w->moved));
    w->moved_normal = lt_arena_array(w->arena, V, sizeof(*w->moved_normal));
    w->at = lt_arena_array(w->arena, V, sizeof(*w->at));
    w->bare = lt_arena_array(w->arena, V, sizeof(*w->bare));
    w->there = lt_arena_array(w->arena, V, sizeof(*w->there));
    w->hidden = lt_arena_array(w->arena, F, sizeof(*w->hidden));
    return w->normal && w->moved && w->moved_normal && w->at && w->bare && w->there && w->hidden;
}

static void prepare(wearing *w)
{
    const body_model *m = w->body->model;

    for (int v = 0; v < V; v++) {
        const float *w_eye = m->weights + (size_t)v * BODY_JOINTS + BODY_EYE;
        const double rest[3] = { m->v_template[v][0], m->v_template[v][1], m->v_template[v][2] };

        w->at[v] = rest_place_of(rest);
        w->bare[v] = w_eye[0] == 1 || w_eye[1] == 1;
        for (int k = 0; k < 3; k++)
            w->moved[v][k] = (float)w->vertices[v][k];
    }
    for (int side = 0; side < 2; side++)
        for (int i = 0; i < LT_HAND_VERTICES; i++)
            w->bare[w->body->hand[side][i]] = true;
    mesh_normals(m->faces, (const float (*)[3])w->moved, w->normal);
}

/* The skin moved out by a piece, with its own normals. */
static void move_out(wearing *w, const clothes_piece *c)
{
    for (int v = 0; v < V; v++) {
        w->there[v] = w->bare[v] ? -1 : c->there(w->look, w->at[v]);
        for (int k = 0; k < 3; k++)
            w->moved[v][k] = (float)w->vertices[v][k];
        if (w->there[v] > -0.05) {
            const float off = (float)c->off(w->look, w->at[v]);

            for (int k = 0; k < 3; k++)
                w->moved[v][k] += off * w->normal[v][k];
        }
    }
    mesh_normals(w->body->model->faces, (const float (*)[3])w->moved, w->moved_normal);
}

/* The point of a face with these shares of its corners. */
static corner corner_at(const wearing *w, const clothes_piece *c, const int32_t f[3], const double share[3])
{
    corner q = { .there = 0 };

    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            q.p[k] += share[i] * w->moved[f[i]][k];
            q.n[k] += share[i] * w->moved_normal[f[i]][k];
            q.rest[k] += share[i] * w->body->model->v_template[f[i]][k];
        }
        q.there += share[i] * w->there[f[i]];
    }
    if (c->split > 1)
        q.there = c->there(w->look, rest_place_of(q.rest));
    return q;
}

static void add_corner(lt_mesh *m, const corner *q)
{
    const int v = m->n_vertices++;
    const bool arm = fabs(q->rest[0]) > CLOTHES_ARM;

    for (int k = 0; k < 3; k++) {
        m->vertex[v][k] = (float)q->p[k];
        m->normal[v][k] = (float)q->n[k];
    }
    m->uv[v][0] = (float)(4 * (arm ? q->rest[1] + 0.4 * q->rest[2] : q->rest[0] + 0.4 * q->rest[2]));
    m->uv[v][1] = (float)(4 * (arm ? q->rest[0] : q->rest[1]));
}

static corner between(const corner *a, const corner *b)
{
    const double t = a->there / (a->there - b->there);
    corner q = { .there = 0 };

    for (int k = 0; k < 3; k++) {
        q.p[k] = a->p[k] + t * (b->p[k] - a->p[k]);
        q.n[k] = a->n[k] + t * (b->n[k] - a->n[k]);
        q.rest[k] = a->rest[k] + t * (b->rest[k] - a->rest[k]);
    }
    return q;
}

/* What of a triangle is there: nothing, a triangle or two. */
static void cut(lt_mesh *m, const corner q[3])
{
    corner kept[4];
    int n = 0;

    for (int k = 0; k < 3; k++) {
        const corner *a = &q[k], *b = &q[(k + 1) % 3];

        if (a->there > 0)
            kept[n++] = *a;
        if ((a->there > 0) != (b->there > 0))
            kept[n++] = between(a, b);
    }
    for (int k = 2; k < n; k++) {
        const int v = m->n_vertices;

        add_corner(m, &kept[0]);
        add_corner(m, &kept[k - 1]);
        add_corner(m, &kept[k]);
        memcpy(m->face[m->n_faces++], (int32_t[]){ v, v + 1, v + 2 }, sizeof(int32_t[3]));
    }
}

static void cut_face(const wearing *w, const clothes_piece *c, const int32_t f[3], lt_mesh *m)
{
    const int n = c->split;

    for (int i = 0; i < n; i++)
        for (int j = 0; j < 2 * i + 1; j++) {   /* row i of the small triangles: those that point up, and down */
            const int up = j % 2 == 0, k = j / 2;
            const int at[3][2] = { { up ? i : i, up ? k : k + 1 }, { i + 1, up ? k : k + 1 },
                                   { up ? i + 1 : i, up ? k + 1 : k } };
            corner q[3];

            for (int e = 0; e < 3; e++) {
                const double a = 1 - (double)at[e][0] / n, b = (double)(at[e][0] - at[e][1]) / n;
                q[e] = corner_at(w, c, f, (double[]){ a, b, 1 - a - b });
            }
            cut(m, q);
        }
}

static bool may_be_there(const wearing *w, const clothes_piece *c, const int32_t f[3])
{
    const double margin = c->split > 1 ? -0.02 : 0;
    bool bare = false, near = false;

    for (int k = 0; k < 3; k++) {
        bare |= w->bare[f[k]];
        near |= w->there[f[k]] > margin;
    }
    return near && !(bare && c->split > 1);
}

static lt_status add_piece(wearing *w, int i, synth_instance *out)
{
    const clothes_piece *c = &clothes_pieces[i];
    const int32_t (*face)[3] = w->body->model->faces;
    lt_mesh *m = lt_arena_alloc(w->arena, sizeof(*m));
    size_t faces = 0;

    move_out(w, c);
    for (int f = 0; f < F; f++)
        faces += may_be_there(w, c, face[f]) ? 2 * (size_t)(c->split * c->split) : 0;
    if (m) {
        m->vertex = lt_arena_array(w->arena, 3 * faces + 1, sizeof(*m->vertex));
        m->normal = lt_arena_array(w->arena, 3 * faces + 1, sizeof(*m->normal));
        m->uv = lt_arena_array(w->arena, 3 * faces + 1, sizeof(*m->uv));
        m->face = lt_arena_array(w->arena, faces + 1, sizeof(*m->face));
    }
    if (!m || !m->vertex || !m->normal || !m->uv || !m->face)
        return lt_error(LT_ENOMEM, "synth: no memory for clothes");
    for (int f = 0; f < F; f++) {
        const int32_t *v = face[f];

        if (may_be_there(w, c, v))
            cut_face(w, c, v, m);
        w->hidden[f] |= c->hides && w->there[v[0]] > 0.03 && w->there[v[1]] > 0.03 && w->there[v[2]] > 0.03;
    }
    out->mesh = m;
    out->material = clothes_material(w->look, i);
    return LT_OK;
}

/* ---- skin ---------------------------------------------------------------------------------------------- */

static void color_all(const wearing *w, float (*color)[3])
{
    const body_model *m = w->body->model;

    for (int v = 0; v < V; v++) {
        const float *eye = m->weights + (size_t)v * BODY_JOINTS + BODY_EYE;

        if (eye[0] == 1 || eye[1] == 1) {
            const double off[3] = { w->at[v].aside - 0.032, w->at[v].up - 1.5912, w->at[v].z - 0.0835 };
            clothes_eye(w->look, off, color[v]);
        } else
            clothes_skin(w->look, w->at[v], color[v]);
    }
    for (int side = 0; side < 2; side++)
        for (int i = 0; i < LT_HAND_VERTICES; i++)
            memcpy(color[w->body->hand[side][i]], w->look->hand[i], sizeof(*color));
}

static lt_status add_skin(wearing *w, synth_instance *out)
{
    const body_model *model = w->body->model;
    lt_mesh *m = lt_arena_alloc(w->arena, sizeof(*m));

    if (m) {
        m->vertex = lt_arena_array(w->arena, V, sizeof(*m->vertex));
        m->color = lt_arena_array(w->arena, V, sizeof(*m->color));
        m->face = lt_arena_array(w->arena, F, sizeof(*m->face));
    }
    if (!m || !m->vertex || !m->color || !m->face)
        return lt_error(LT_ENOMEM, "synth: no memory for a person's skin");
    m->n_vertices = V;
    m->normal = w->normal;
    for (int v = 0; v < V; v++)
        for (int k = 0; k < 3; k++)
            m->vertex[v][k] = (float)w->vertices[v][k];
    for (int f = 0; f < F; f++)
        if (!w->hidden[f])
            memcpy(m->face[m->n_faces++], model->faces[f], sizeof(*m->face));
    color_all(w, m->color);
    out->mesh = m;
    out->rest = (const float (*)[3])model->v_template;
    out->material = (synth_material){ .albedo = { 1, 1, 1 }, .specular = 0.028f, .shininess = 12, .translucency = 1 };
    return LT_OK;
}

lt_status synth_appearance_wear(lt_arena *arena, const synth_body *body, const synth_appearance *look,
                                const double (*vertices)[3], synth_instance out[SYNTH_WORN], int *n)
{
    wearing w = { .arena = arena, .body = body, .look = look, .vertices = vertices };
    const synth_instance one = { .R_world_obj = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, .moving = true };
    lt_status st = get_arrays(&w) ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for a person");

    if (st)
        return st;
    prepare(&w);
    *n = 0;
    for (int i = 0; !st && i < CLOTHES_PIECES; i++) {
        out[*n] = one;
        st = add_piece(&w, i, &out[*n]);
        *n += out[*n].mesh && out[*n].mesh->n_faces > 0;
    }
    out[*n] = one;
    return st ? st : add_skin(&w, &out[(*n)++]);
}
