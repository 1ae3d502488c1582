/* SPDX-License-Identifier: Apache-2.0 */
/* The mesh and the control points of a model, of whatever names its files have. */
#include "pipeline/objects/mesh.h"

#include "assets/ycb/objects.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/mesh/ply.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

/* The datasets' name, then that of YCB's own folders; any other file must be the only mesh. */
static const char *const preferred[] = { "textured_simple.obj", "textured.obj" };

static bool has_ending(const char *name, const char *ending)
{
    const size_t n = strlen(name), e = strlen(ending);

    return n > e && strcasecmp(name + n - e, ending) == 0;
}

static int is_mesh_name(const struct dirent *e)
{
    return e->d_name[0] != '.' && (has_ending(e->d_name, ".obj") || has_ending(e->d_name, ".ply"));
}

/* Of the names of meshes the one to read; NULL where several might be meant. */
static const char *choose(struct dirent **entry, int n)
{
    for (size_t k = 0; k < LT_COUNT(preferred); k++)
        for (int i = 0; i < n; i++)
            if (strcmp(entry[i]->d_name, preferred[k]) == 0)
                return entry[i]->d_name;
    return n == 1 ? entry[0]->d_name : NULL;
}

static lt_status find_mesh(lt_arena *arena, const char *folder, const char **out)
{
    struct dirent **entry;
    const int n = scandir(folder, &entry, is_mesh_name, alphasort);
    const char *name;
    lt_status st = LT_OK;

    if (n < 0)
        return lt_error(errno == ENOMEM ? LT_ENOMEM : LT_EIO, "%s: %s", folder, strerror(errno));
    name = choose(entry, n);
    *out = name ? lt_path_join(arena, folder, name) : NULL;
    if (n == 0)
        st = lt_error(LT_EFORMAT, "%s: no mesh; want textured_simple.obj, or another .obj or .ply", folder);
    else if (!name)
        st = lt_error(LT_EFORMAT, "%s: %d meshes, as %s and %s; call the one that is meant textured_simple.obj", folder,
                      n, entry[0]->d_name, entry[1]->d_name);
    else if (!*out)
        st = lt_error(LT_ENOMEM, "%s: no memory", folder);
    for (int i = 0; i < n; i++)
        free(entry[i]);
    free(entry);
    return st;
}

static lt_status read_mesh(lt_arena *arena, const char *path, lt_mesh *out)
{
    const lt_kind kind = lt_kind_of_file(path);
    lt_ply ply;
    lt_status st;

    if (kind == LT_KIND_PLY) {
        st = lt_ply_read(arena, path, &ply);
        st = st ? st : lt_ply_mesh(arena, &ply, out);
    } else {
        st = lt_obj_read(arena, path, out, NULL);
    }
    if (!st && out->n_faces < 1)                /* any text is an OBJ, of lines that mean nothing */
        return lt_error(LT_EFORMAT, "%s: %d vertices and 0 triangles, want a mesh%s%s", path, out->n_vertices,
                        kind && kind != LT_KIND_PLY ? "; it is " : "",
                        kind && kind != LT_KIND_PLY ? lt_kind_name(kind) : "");
    return st;
}

/* Those beside the mesh, else a draw of its surface as they are made. */
static lt_status read_points(lt_arena *arena, const char *folder, const lt_mesh *mesh, float (**point)[3], size_t *n)
{
    const char *path = lt_path_join(arena, folder, "points.xyz");

    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", folder);
    if (access(path, F_OK) == 0)
        return lt_xyz_read(arena, path, point, n);
    *n = SYNTH_POINTS;
    return synth_object_points(arena, mesh, point);
}

lt_status object_mesh_read(lt_arena *arena, const char *folder, lt_mesh *mesh, lt_box *points)
{
    const char *path = folder;
    float (*point)[3];
    size_t n;
    lt_status st = find_mesh(arena, folder, &path);

    st = st ? st : read_mesh(arena, path, mesh);
    if (st)
        return st;
    st = read_points(arena, folder, mesh, &point, &n);
    if (st)                                     /* no area to draw points from */
        return st == LT_EINVAL ? lt_error_prefix(LT_EFORMAT, "%s", path) : st;
    if (n > INT_MAX || lt_box_from_points((int)n, point[0], points))
        return lt_error(LT_EFORMAT, "%s/points.xyz: %zu points, or one that is not finite", folder, n);
    return LT_OK;
}
