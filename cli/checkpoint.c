/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "assets/hand_file.h"
#include "assets/hands.h"
#include "estimate/checkpoint/checkpoint.h"
#include "estimate/checkpoint/folder.h"
#include "libtensor/io/file.h"
#include "tasks/hand_object/config.h"
#include "tasks/hand_object/task.h"
#include "tasks/tasks.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

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
    if (!strcmp(run, folder + 1))
        c->run = ".";
    else if (n > sizeof(folder) - 1 && strcmp(run + n - (sizeof(folder) - 1), folder) == 0)
        run[n - (sizeof(folder) - 1)] = '\0';
    return LT_OK;
}

/* Whether the run was trained with hands, and its config says with which */
static bool has_hands(const cli_checkpoint *c)
{
    return c->config.task == &hand_object_task;
}

/* As given, else as the run had them */
static lt_status open_hands(cli_checkpoint *c, const char *hand, const int tips[5])
{
    const hand_object_config *d = hand_object_config_of(&c->config);
    lt_status st;

    if (!has_hands(c))
        return cli_hand_open(hand, NULL, &c->hand);
    st = cli_hand_open(hand || !*d->hand ? hand : d->hand, tips, &c->hand);

    if (st == LT_OK && !hand && *d->hand_left)
        st = hand_file_read(c->arena, d->hand_left, &c->hand.left);
    return st;
}

/* A run that was trained with the embedded hand has said so then. */
static bool known_embedded(const cli_checkpoint *c, const char *hand)
{
    return !hand && strcmp(hand_object_config_of(&c->config)->hand, "embedded") == 0;
}

lt_status cli_checkpoint_find_with(const char *path, const cli_overrides *over, cli_checkpoint *out)
{
    checkpoint_head head;
    lt_status st;

    *out = (cli_checkpoint){ .arena = lt_arena_new() };
    if (!out->arena)
        return lt_error(LT_ENOMEM, "no memory to open %s", path);
    st = find_file(path, out);
    if (st == LT_OK)
        st = checkpoint_head_read(out->arena, out->path, &head);
    if (st == LT_OK)
        st = train_config_parse(out->arena, tasks, out->path, head.config, over->set, over->n, &out->config);
    if (st)
        return st;
    out->step = head.step;
    memcpy(out->tips, head.tips, sizeof(out->tips));
    return LT_OK;
}

lt_status cli_checkpoint_find(const char *path, cli_checkpoint *out)
{
    return cli_checkpoint_find_with(path, &(cli_overrides){ .n = 0 }, out);
}

lt_status cli_checkpoint_load(cli_checkpoint *c, const char *hand)
{
    lt_status st = open_hands(c, hand, c->tips);

    if (st)
        return st;
    if (has_hands(c) && c->hand.model->synthetic && !known_embedded(c, hand))
        fprintf(stderr, "hand: %s\n", hands_note());
    c->params = lt_params_new();
    st = c->params ? train_config_model(&c->config, c->hand.layer, c->params, &c->m)
                   : lt_error(LT_ENOMEM, "no memory for the model");
    return st ? st : checkpoint_load_model(c->path, &c->m);
}

lt_status cli_checkpoint_open(const char *path, const char *hand, cli_checkpoint *out)
{
    const lt_status st = cli_checkpoint_find(path, out);

    return st ? st : cli_checkpoint_load(out, hand);
}

lt_status cli_checkpoint_want_hands(const cli_checkpoint *c)
{
    return has_hands(c) ? LT_OK : lt_error(LT_EINVAL, "%s: %s is trained for %s, want a model for %s", c->path,
                                           c->m.cls->name, c->config.task->name, hand_object_task.name);
}

dataset_options cli_checkpoint_data(const cli_checkpoint *c, const char *root, const char *split)
{
    const hand_object_config *d = hand_object_config_of(&c->config);
    const char *objects = d->objects;

    return (dataset_options){
        .root = root, .split = split, .models = *objects && access(objects, R_OK) == 0 ? objects : NULL,
        .setup = hand_object_setup(d), .filter = hand_object_filter(d),
        .hand = c->hand.model, .left = c->hand.left,
    };
}

void cli_checkpoint_close(cli_checkpoint *c)
{
    lt_params_free(c->params);
    cli_hand_close(&c->hand);
    train_config_fini(&c->config);
    lt_arena_free(c->arena);
}
