/* SPDX-License-Identifier: Apache-2.0 */
/* All that is written for one image. */
#include "pipeline/internal.h"

lt_status predict_write_files(lt_arena *arena, const predict_case *s)
{
    const char *json, *json_path, *png, *png_path;
    predict_mesh_files *files = lt_arena_array(arena, (size_t)s->n, sizeof(*files));
    lt_mesh *hand = lt_arena_array(arena, (size_t)s->n, sizeof(*hand));
    lt_status st = files && hand ? predict_file_name(arena, s, ".json", &json, &json_path)
                                 : lt_error(LT_ENOMEM, "%s: no memory", s->view->path);

    st = st ? st : predict_file_name(arena, s, ".overlay.png", &png, &png_path);
    for (int i = 0; i < s->n && !st; i++)
        st = predict_hand_mesh(arena, s, i, &hand[i]);
    st = st ? st : predict_write_overlay(arena, s, hand, png_path);
    st = st ? st : predict_write_meshes(arena, s, hand, files);
    return st ? st : predict_write_json(s, files, json_path);
}
