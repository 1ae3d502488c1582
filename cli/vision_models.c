/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/vision_models.h"

#include "cli/cli.h"
#include "estimate/starter.h"

lt_status cli_vision_models_open(const cli_vision_names *names, cli_vision_models *out)
{
    lt_status st = LT_OK;

    if (names->detector) {
        st = detector_open(names->detector, &out->own_detector);
        out->detector = &out->own_detector;
    }
    if (!st && names->body) {
        st = body_estimator_open(names->body, &out->own_body);
        out->body = &out->own_body;
    }
    if (!st && names->reid)
        st = embedder_open(names->reid, &out->embedder);
    return st;
}

void cli_vision_models_close(cli_vision_models *m)
{
    embedder_free(m->embedder);
    body_estimator_close(&m->own_body);
    detector_close(&m->own_detector);
}

lt_status cli_starter_find(lt_arena *arena, const char *role, const char **out)
{
    char root[4096];
    const char *folder;

    cli_root(root, sizeof(root));
    folder = starter_folder(arena, root);
    return folder ? starter_find(arena, folder, role, out) : lt_error(LT_ENOMEM, "no memory for the starter models");
}
