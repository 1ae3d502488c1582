/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/take/prop.h"

#include "assets/ycb/objects.h"

static lt_status no_memory(const char *name)
{
    return lt_error(LT_ENOMEM, "synth: no memory for %s", name);
}

lt_status synth_prop_new_bare(lt_arena *arena, int id, synth_prop *out)
{
    const ycb_object *o = synth_object_find(id);
    synth_prop p = { .id = id, .name = o->name };
    lt_status st = synth_object_new(arena, id, &p.mesh);

    if (!st)
        st = synth_object_texture(arena, id, &p.rgb);
    if (!st)
        st = lt_box_from_points(p.mesh.n_vertices, &p.mesh.vertex[0][0], &p.box);
    if (!st)
        st = lt_mesh_index_new(arena, &p.mesh, &p.index);
    if (!st)
        st = synth_sdf_new(arena, &p.mesh, &p.sdf);
    if (st)
        return st;
    p.texture = synth_texture_new(arena, &p.rgb[0][0], SYNTH_TEXTURE, SYNTH_TEXTURE);
    *out = p;
    return p.texture ? LT_OK : no_memory(o->name);
}

lt_status synth_prop_new(lt_arena *arena, int id, bool alias, synth_prop *out)
{
    const char *name = synth_object_find(id)->name;
    float (*points)[3];
    lt_status st = synth_prop_new_bare(arena, id, out);

    if (!st)
        st = synth_object_points(arena, &out->mesh, &points);
    if (!st)
        st = lt_box_from_points(SYNTH_POINTS, &points[0][0], &out->box);
    if (st)
        return st;
    out->points = (const float (*)[3])points;
    out->name = lt_arena_printf(arena, "%s%s", alias ? "" : "syn_", name);
    return out->name ? LT_OK : no_memory(name);
}

/* Vertices in the mirror, and faces that still look outwards. */
static lt_status mirror_mesh(lt_arena *arena, const lt_mesh *mesh, lt_mesh *out)
{
    const size_t n = (size_t)mesh->n_vertices;

    *out = *mesh;
    out->vertex = lt_arena_array(arena, n, sizeof(*out->vertex));
    out->face = lt_arena_array(arena, (size_t)mesh->n_faces, sizeof(*out->face));
    out->normal = mesh->normal ? lt_arena_array(arena, n, sizeof(*out->normal)) : NULL;
    if (!out->vertex || !out->face || (mesh->normal && !out->normal))
        return lt_error(LT_ENOMEM, "synth: no memory for a mesh");
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++) {
            out->vertex[i][k] = k ? mesh->vertex[i][k] : -mesh->vertex[i][k];
            if (mesh->normal)
                out->normal[i][k] = k ? mesh->normal[i][k] : -mesh->normal[i][k];
        }
    for (int i = 0; i < mesh->n_faces; i++) {
        out->face[i][0] = mesh->face[i][0];
        out->face[i][1] = mesh->face[i][2];
        out->face[i][2] = mesh->face[i][1];
    }
    return LT_OK;
}

static lt_status mirror_points(lt_arena *arena, const synth_prop *p, synth_prop *m)
{
    float (*points)[3] = lt_arena_array(arena, SYNTH_POINTS, sizeof(*points));

    if (!points)
        return no_memory(p->name);
    for (int i = 0; i < SYNTH_POINTS; i++)
        for (int k = 0; k < 3; k++)
            points[i][k] = k ? p->points[i][k] : -p->points[i][k];
    m->points = (const float (*)[3])points;
    return lt_box_from_points(SYNTH_POINTS, &points[0][0], &m->box);
}

lt_status synth_prop_mirror(lt_arena *arena, const synth_prop *p, synth_prop *out)
{
    synth_prop m = *p;
    lt_status st = mirror_mesh(arena, &p->mesh, &m.mesh);

    if (!st)
        st = p->points ? mirror_points(arena, p, &m)
                       : lt_box_from_points(m.mesh.n_vertices, &m.mesh.vertex[0][0], &m.box);
    if (!st)
        st = lt_mesh_index_new(arena, &m.mesh, &m.index);
    if (!st)
        st = p->points ? synth_sdf_new(arena, &m.mesh, &m.sdf) : synth_sdf_mirror(arena, &p->sdf, &m.sdf);
    if (st)
        return st;
    m.mirrored = !p->mirrored;
    *out = m;
    return LT_OK;
}
