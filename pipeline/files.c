/* SPDX-License-Identifier: Apache-2.0 */
/* All that is written for one image. */
#include "pipeline/internal.h"

/* What there is to look at */
static lt_status write_pictures(lt_arena *arena, const predict_case *s, predict_mesh_files *files)
{
    const char *png, *path;
    lt_mesh *hand = lt_arena_array(arena, (size_t)s->n, sizeof(*hand));
    lt_status st = hand ? predict_file_name(arena, s, ".overlay.png", &png, &path)
                        : lt_error(LT_ENOMEM, "%s: no memory", s->view->path);

    for (int i = 0; i < s->n && !st; i++)
        st = predict_hand_mesh(arena, s, i, &hand[i]);
    st = st ? st : predict_write_overlay(arena, s, hand, path);
    return st ? st : predict_write_meshes(arena, s, hand, files);
}

lt_status predict_write_files(lt_arena *arena, const predict_case *s)
{
    const char *json, *path;
    predict_mesh_files *files = lt_arena_array(arena, (size_t)s->n, sizeof(*files));
    lt_status st = files ? predict_file_name(arena, s, ".json", &json, &path)
                         : lt_error(LT_ENOMEM, "%s: no memory", s->view->path);

    if (!st && !s->o->numbers)
        st = write_pictures(arena, s, files);
    return st ? st : predict_write_json(s, files, path);
}
