/* SPDX-License-Identifier: Apache-2.0 */
/* Hand and object as meshes in camera axes, and the files they go to. */
#include "pipeline/internal.h"

#include "libtensor/io/file.h"
#include "libtensor/io/mesh/glb.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/mesh/ply.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

/* The triangles of the hand; those of a left one look outwards after a swap. */
static lt_status hand_faces(lt_arena *arena, const predict_case *s, int32_t (**out)[3])
{
    const lt_hand_model *hand = s->o->hand;
    int32_t (*face)[3] = lt_arena_array(arena, LT_HAND_FACES, sizeof(*face));

    if (!face)
        return lt_error(LT_ENOMEM, "no memory for a hand");
    memcpy(face, hand->faces, sizeof(hand->faces));
    for (int f = 0; f < LT_HAND_FACES && s->v->left; f++) {
        face[f][1] = hand->faces[f][2];
        face[f][2] = hand->faces[f][1];
    }
    *out = face;
    return LT_OK;
}

lt_status predict_hand_mesh(lt_arena *arena, const predict_case *s, lt_mesh *out)
{
    lt_mesh mesh = { .n_vertices = LT_HAND_VERTICES, .n_faces = LT_HAND_FACES };
    const lt_status st = hand_faces(arena, s, &mesh.face);

    if (st)
        return st;
    mesh.vertex = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*mesh.vertex));
    if (!mesh.vertex)
        return lt_error(LT_ENOMEM, "no memory for a hand");
    memcpy(mesh.vertex, s->r->e.vertices, sizeof(s->r->e.vertices));
    *out = mesh;
    return LT_OK;
}

static lt_status pose_object(lt_arena *arena, const predict_case *s, lt_mesh *out)
{
    const double *R = s->r->e.object.R, *t = s->r->e.object.t;
    const lt_mesh *from = &s->object->mesh;

    *out = *from;
    out->normal = NULL;
    out->vertex = lt_arena_array(arena, (size_t)from->n_vertices, sizeof(*out->vertex));
    if (!out->vertex)
        return lt_error(LT_ENOMEM, "no memory for an object of %d vertices", from->n_vertices);
    for (int i = 0; i < from->n_vertices; i++)
        for (int d = 0; d < 3; d++)
            out->vertex[i][d] = (float)(R[3 * d] * from->vertex[i][0] + R[3 * d + 1] * from->vertex[i][1] +
                                        R[3 * d + 2] * from->vertex[i][2] + t[d]);
    return LT_OK;
}

/* A file for each: NAME.hand.obj, NAME.object.ply. */
static lt_status mesh_path(lt_arena *arena, const predict_case *s, const char *what, const char **name,
                           const char **path)
{
    const char *ending = lt_arena_printf(arena, ".%s.%s", what, s->o->format == PREDICT_OBJ ? "obj" : "ply");

    return ending ? predict_file_name(arena, s, ending, name, path) : lt_error(LT_ENOMEM, "%s: no memory", s->v->path);
}

static lt_status write_alone(lt_arena *arena, const predict_case *s, const char *what, const lt_mesh *mesh,
                             const char **name)
{
    const char *path;
    const lt_status st = mesh_path(arena, s, what, name, &path);

    if (st)
        return st;
    return s->o->format == PREDICT_OBJ ? lt_obj_write(path, mesh, NULL) : lt_ply_write_mesh(path, mesh);
}

/* What an earlier prediction of the same image left, where this one finds no object */
static lt_status remove_object(lt_arena *arena, const predict_case *s)
{
    const char *name, *path;
    const lt_status st = mesh_path(arena, s, "object", &name, &path);

    if (!st && unlink(path) && errno != ENOENT)
        return lt_error(lt_errno_status(errno), "%s: %s", path, strerror(errno));
    return st;
}

/* Both in one scene. object: NULL where it was not found */
static lt_status write_scene(lt_arena *arena, const predict_case *s, const lt_mesh *hand, const lt_mesh *object,
                             predict_mesh_files *out)
{
    const lt_glb_part part[2] = {
        { "hand", hand, { 0.80f, 0.50f, 0.38f, 1 } },
        { object ? s->object->name : NULL, object, { 0.55f, 0.62f, 0.75f, 1 } },
    };
    const char *path;
    const lt_status st = predict_file_name(arena, s, ".glb", &out->hand, &path);

    out->object = object ? out->hand : NULL;
    return st ? st : lt_glb_write(path, part, object ? 2 : 1);
}

lt_status predict_write_meshes(lt_arena *arena, const predict_case *s, const lt_mesh *hand, predict_mesh_files *out)
{
    const bool found = s->r->object_found;
    lt_mesh object;
    lt_status st = found ? pose_object(arena, s, &object) : LT_OK;

    *out = (predict_mesh_files){ NULL, NULL };
    if (!st && s->o->format == PREDICT_GLB)
        return write_scene(arena, s, hand, found ? &object : NULL, out);
    st = st ? st : write_alone(arena, s, "hand", hand, &out->hand);
    if (st)
        return st;
    return found ? write_alone(arena, s, "object", &object, &out->object) : remove_object(arena, s);
}

lt_status predict_file_name(lt_arena *arena, const predict_case *s, const char *ending, const char **name,
                            const char **path)
{
    *name = lt_arena_printf(arena, "%s%s", s->v->name, ending);
    *path = *name ? lt_path_join(arena, s->o->out, *name) : NULL;
    return *path ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", s->v->path);
}
