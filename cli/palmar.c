/* SPDX-License-Identifier: Apache-2.0 */
/*
 * palmar: one command for data, training, scoring, timing and looking.
 */
#include "cli/cli.h"

#include <config.h>
#include "libtensor/io/text/nearest.h"
#include "libtensor/kernels/kernels.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *what;
} command;

static const command commands[] = {
    { "synth", cmd_synth, "make a synthetic dataset" },
    { "train", cmd_train, "train a model from a config" },
    { "eval", cmd_eval, "score a model; print the paper's tables with our rows" },
    { "predict", cmd_predict, "images, folders, films -> overlays, JSON, meshes" },
    { "watch", cmd_watch, "cameras or recordings, live -> who does what with what" },
    { "bench", cmd_bench, "latency, throughput, memory, per-layer profile" },
    { "export", cmd_export, "ONNX or safetensors for other programs, read back and compared" },
    { "report", cmd_report, "one HTML page of a run" },
    { "info", cmd_info, "what is in this model, checkpoint, dataset, hand file, machine" },
    { "gradcheck", cmd_gradcheck, "check the gradients of ops in double precision" },
};

static void print_help(FILE *f)
{
    fprintf(f, "Usage: palmar COMMAND [OPTION...]\n"
            "  or:  palmar help COMMAND\n"
            "  or:  palmar --version\n\n"
            "Hand-object pose on a CPU: train the models from scratch, score them, time them.\n\n");
    for (size_t i = 0; i < LT_COUNT(commands); i++)
        fprintf(f, "  %-10s %s\n", commands[i].name, commands[i].what);
    fprintf(f, "\nThree lines that run as they are:\n"
            "  palmar synth --preset tiny --out data/tiny\n"
            "  palmar train --config hocat-tiny --data data/tiny --out runs/tiny\n"
            "  palmar eval runs/tiny --data data/tiny\n\n"
            "Exit codes: 0 done, 1 bad input or failed work, 2 bad usage, 3 numbers went bad,\n"
            "4 no memory or disk, 128 and its number after a signal (130, 143), when all is saved.\n");
}

static const command *find(const char *name)
{
    for (size_t i = 0; i < LT_COUNT(commands); i++)
        if (strcmp(commands[i].name, name) == 0)
            return &commands[i];
    return NULL;
}

static int unknown(const char *name)
{
    const char *names[LT_COUNT(commands)];

    for (size_t i = 0; i < LT_COUNT(commands); i++)
        names[i] = commands[i].name;
    lt_unknown_name(name, names, LT_COUNT(commands), "palmar help lists them", "no such command \"%s\"", name);
    fprintf(stderr, "palmar: %s\n", lt_last_error());
    return 2;
}

static int help(int argc, char **argv)
{
    const command *c = argc > 2 ? find(argv[2]) : NULL;
    char *args[] = { argv[0], "--help", NULL };

    if (argc > 2 && !c)
        return unknown(argv[2]);
    if (c)
        return c->run(2, args);
    print_help(stdout);
    return 0;
}

static int run(int argc, char **argv)
{
    const command *c;

    if (argc < 2) {
        print_help(stderr);
        return 2;
    }
    if (strcmp(argv[1], "help") == 0 || strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)
        return help(argc, argv);
    if (strcmp(argv[1], "--version") == 0) {
        printf("palmar %s\n", PACKAGE_VERSION);
        return 0;
    }
    c = find(argv[1]);
    if (!c)
        return unknown(argv[1]);
    if (lt_kernels_init())
        return cli_fail(LT_EINVAL);
    return c->run(argc - 1, argv + 1);
}

int main(int argc, char **argv)
{
    cli_begin();
    return run(argc, argv);
}
