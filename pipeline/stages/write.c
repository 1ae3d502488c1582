/* SPDX-License-Identifier: Apache-2.0 */
/* write: the overlay and the meshes, where they were drawn, and the numbers, into files of the frame's name. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

#include "libtensor/io/image/write.h"

static lt_status write_pictures(const predict_frame *f)
{
    const char *png, *path;
    lt_status st = predict_file_name(f, ".overlay.png", &png, &path);

    st = st ? st : lt_png_write(path, &f->overlay);
    return st || !(f->has & FRAME_POSES) ? st : predict_write_meshes(f);
}

static lt_status run(void *state, predict_frame *f)
{
    const char *json, *path;
    lt_status st;

    (void)state;
    f->files = lt_arena_array(f->arena, (size_t)f->n, sizeof(*f->files));
    st = f->files ? predict_file_name(f, ".json", &json, &path) : lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
    if (!st && (f->has & FRAME_DRAWING))
        st = write_pictures(f);
    return st ? st : predict_write_json(f, path);
}

/* A name that is too long */
static bool forgives(lt_status st)
{
    return st == LT_EFORMAT || st == LT_EINVAL;
}

const stage write_stage = {
    .name = "write", .needs = FRAME_VIEWS | FRAME_VERDICT, .forgives = forgives, .run = run,
};
