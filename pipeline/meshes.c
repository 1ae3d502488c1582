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
static lt_status hand_faces(const predict_frame *f, int i, int32_t (**out)[3])
{
    const lt_hand_model *hand = f->o->hand;
    int32_t (*face)[3] = lt_arena_array(f->arena, LT_HAND_FACES, sizeof(*face));

    if (!face)
        return lt_error(LT_ENOMEM, "no memory for a hand");
    memcpy(face, hand->faces, sizeof(hand->faces));
    for (int k = 0; k < LT_HAND_FACES && f->view[i].left; k++) {
        face[k][1] = hand->faces[k][2];
        face[k][2] = hand->faces[k][1];
    }
    *out = face;
    return LT_OK;
}

lt_status predict_hand_mesh(const predict_frame *f, int i, lt_mesh *out)
{
    lt_mesh mesh = { .n_vertices = LT_HAND_VERTICES, .n_faces = LT_HAND_FACES };
    const lt_status st = hand_faces(f, i, &mesh.face);

    if (st)
        return st;
    mesh.vertex = lt_arena_array(f->arena, LT_HAND_VERTICES, sizeof(*mesh.vertex));
    if (!mesh.vertex)
        return lt_error(LT_ENOMEM, "no memory for a hand");
    memcpy(mesh.vertex, f->result[i].e.vertices, sizeof(f->result[i].e.vertices));
    *out = mesh;
    return LT_OK;
}

static lt_status pose_object(const predict_frame *f, int i, lt_mesh *out)
{
    const double *R = f->result[i].e.object.R, *t = f->result[i].e.object.t;
    const lt_mesh *from = &f->view[i].object->mesh;

    *out = *from;
    out->normal = NULL;
    out->vertex = lt_arena_array(f->arena, (size_t)from->n_vertices, sizeof(*out->vertex));
    if (!out->vertex)
        return lt_error(LT_ENOMEM, "no memory for an object of %d vertices", from->n_vertices);
    for (int k = 0; k < from->n_vertices; k++)
        for (int d = 0; d < 3; d++)
            out->vertex[k][d] = (float)(R[3 * d] * from->vertex[k][0] + R[3 * d + 1] * from->vertex[k][1] +
                                        R[3 * d + 2] * from->vertex[k][2] + t[d]);
    return LT_OK;
}

/* "hand" for the first, "hand-2" for the second */
static const char *numbered(lt_arena *arena, const char *what, int i)
{
    return i ? lt_arena_printf(arena, "%s-%d", what, i + 1) : what;
}

/* A file for each: NAME.hand.obj, NAME.object-2.ply. */
static lt_status mesh_path(const predict_frame *f, const char *what, int i, const char **name,
                           const char **path)
{
    const char *which = numbered(f->arena, what, i), *kind = f->o->format == PREDICT_OBJ ? "obj" : "ply";
    const char *ending = which ? lt_arena_printf(f->arena, ".%s.%s", which, kind) : NULL;

    return ending ? predict_file_name(f, ending, name, path)
                  : lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
}

static lt_status write_alone(const predict_frame *f, const char *what, int i, const lt_mesh *mesh,
                             const char **name)
{
    const char *path;
    const lt_status st = mesh_path(f, what, i, name, &path);

    if (st)
        return st;
    return f->o->format == PREDICT_OBJ ? lt_obj_write(path, mesh, NULL) : lt_ply_write_mesh(path, mesh);
}

/* What an earlier prediction of the same image left, where this one finds none. *removed: there was a file */
static lt_status remove_mesh(const predict_frame *f, const char *what, int i, bool *removed)
{
    const char *name, *path;
    const lt_status st = mesh_path(f, what, i, &name, &path);

    *removed = !st && unlink(path) == 0;
    return st || *removed || errno == ENOENT ? st : lt_error(lt_errno_status(errno), "%s: %s", path, strerror(errno));
}

/* One hand's files of its own */
static lt_status write_pair(const predict_frame *f, int i, predict_mesh_files *out)
{
    bool removed;
    lt_mesh object;
    lt_status st = write_alone(f, "hand", i, &f->hand[i], &out->hand);

    if (st || !f->result[i].object_found)
        return st ? st : remove_mesh(f, "object", i, &removed);
    st = pose_object(f, i, &object);
    return st ? st : write_alone(f, "object", i, &object, &out->object);
}

/* The hands behind the last one, of an earlier prediction that had more */
static lt_status remove_others(const predict_frame *f)
{
    bool hand = true, object;
    lt_status st = LT_OK;

    for (int i = f->n; hand && !st; i++) {
        st = remove_mesh(f, "hand", i, &hand);
        st = st ? st : remove_mesh(f, "object", i, &object);
    }
    return st;
}

/* All in one scene */
static lt_status write_scene(const predict_frame *f, predict_mesh_files *out)
{
    static const float skin[4] = { 0.80f, 0.50f, 0.38f, 1 }, thing[4] = { 0.55f, 0.62f, 0.75f, 1 };
    lt_glb_part *part = lt_arena_array(f->arena, 2 * (size_t)f->n, sizeof(*part));
    lt_mesh *object = lt_arena_array(f->arena, (size_t)f->n, sizeof(*object));
    const char *name, *path;
    size_t n = 0;
    lt_status st = part && object ? predict_file_name(f, ".glb", &name, &path)
                                  : lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);

    for (int i = 0; i < f->n && !st; i++) {
        const char *which = numbered(f->arena, "hand", i);

        st = which ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
        out[i].hand = name;
        part[n++] = (lt_glb_part){ .name = which, .mesh = &f->hand[i],
                                   .color = { skin[0], skin[1], skin[2], skin[3] } };
        if (st || !f->result[i].object_found)
            continue;
        out[i].object = name;
        st = pose_object(f, i, &object[i]);
        part[n++] = (lt_glb_part){ .name = f->view[i].object->name, .mesh = &object[i],
                                   .color = { thing[0], thing[1], thing[2], thing[3] } };
    }
    return st ? st : lt_glb_write(path, part, (int)n);
}

lt_status predict_write_meshes(const predict_frame *f)
{
    lt_status st = LT_OK;

    if (f->o->format == PREDICT_GLB)
        return write_scene(f, f->files);
    for (int i = 0; i < f->n && !st; i++)
        st = write_pair(f, i, &f->files[i]);
    return st ? st : remove_others(f);
}

lt_status predict_file_name(const predict_frame *f, const char *ending, const char **name, const char **path)
{
    *name = lt_arena_printf(f->arena, "%s%s", f->scene.name, ending);
    *path = *name ? lt_path_join(f->arena, f->o->out, *name) : NULL;
    return *path ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
}
