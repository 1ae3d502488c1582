/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/write/model.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/mesh/obj.h"

lt_status synth_write_model(const char *root, const char *name, const lt_mesh *mesh,
                            const uint8_t (*rgb)[3], int side, const float (*points)[3], int n_points,
                            synth_file *files)
{
    static const char *const file[] = { "textured_simple.obj", "textured_simple.mtl", "texture_map.png",
                                        "points.xyz" };
    const lt_image texture = { side, side, 3, 8, (uint8_t *)rgb };
    lt_arena *arena = lt_arena_new();
    const char *path[4], *folder = arena ? lt_arena_printf(arena, "%s/models/%s", root, name) : NULL;
    lt_status st = folder ? lt_make_dirs(folder) : lt_error(LT_ENOMEM, "%s: no memory", name);

    for (int i = 0; !st && i < 4; i++)
        if (!(path[i] = lt_path_join(arena, folder, file[i])))
            st = lt_error(LT_ENOMEM, "%s: no memory", name);
    if (!st)
        st = lt_obj_write(path[0], mesh, file[2]);
    if (!st)
        st = lt_png_write(path[2], &texture);
    if (!st)
        st = lt_xyz_write(path[3], points, (size_t)n_points);
    for (int i = 0; !st && i < 4; i++) {
        const char *within = lt_arena_printf(arena, "models/%s/%s", name, file[i]);
        st = within ? synth_describe_file(root, within, &files[i]) : lt_error(LT_ENOMEM, "%s: no memory", name);
    }
    lt_arena_free(arena);
    return st;
}
