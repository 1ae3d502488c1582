/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "data/hands.h"
#include "libtensor/io/file.h"
#include "train/checkpoint.h"
#include "train/checkpoint_folder.h"

#include <stdio.h>
#include <string.h>

/* runs/x -> runs/x/checkpoints/last.safetensors, of run runs/x; a file in a folder called checkpoints
 * belongs to the run above it. */
static lt_status find_file(const char *path, cli_checkpoint *c)
{
    static const char folder[] = "/checkpoints";
    const char *slash = strrchr(path, '/');
    char *run;
    size_t n;

    c->run = path;
    c->path = checkpoint_last(c->arena, path);
    if (c->path != path)
        return c->path ? LT_OK : lt_error(LT_ENOMEM, "no memory to open %s", path);
    run = lt_arena_strdup(c->arena, slash ? path : ".");
    c->run = run;
    if (!run || !slash)
        return run ? LT_OK : lt_error(LT_ENOMEM, "no memory to open %s", path);
    run[slash - path] = '\0';
    n = strlen(run);
    if (n > sizeof(folder) - 1 && strcmp(run + n - (sizeof(folder) - 1), folder) == 0)
        run[n - (sizeof(folder) - 1)] = '\0';
    return LT_OK;
}

static lt_status read_model(cli_checkpoint *c, const char *hand)
{
    const char *text;
    lt_status st = checkpoint_config(c->arena, c->path, &text, &c->step);

    if (st == LT_OK)
        st = train_config_parse(c->arena, c->path, text, NULL, 0, &c->config);
    if (st)
        return st;
    if (!hand && *c->config.data.hand)
        hand = c->config.data.hand;
    st = cli_hand_open(hand, NULL, &c->hand);
    if (st)
        return st;
    if (c->hand.model->synthetic)
        fprintf(stderr, "hand: %s\n", hands_note());
    c->params = lt_params_new();
    st = c->params ? train_config_model(&c->config, c->hand.layer, c->params, &c->m)
                   : lt_error(LT_ENOMEM, "no memory for the model");
    return st ? st : checkpoint_load_model(c->path, &c->m);
}

lt_status cli_checkpoint_open(const char *path, const char *hand, cli_checkpoint *out)
{
    lt_status st;

    *out = (cli_checkpoint){ .arena = lt_arena_new() };
    if (!out->arena)
        return lt_error(LT_ENOMEM, "no memory to open %s", path);
    st = find_file(path, out);
    return st ? st : read_model(out, hand);
}

void cli_checkpoint_close(cli_checkpoint *c)
{
    lt_params_free(c->params);
    cli_hand_close(&c->hand);
    train_config_fini(&c->config);
    lt_arena_free(c->arena);
}
