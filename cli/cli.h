/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the subcommands of `palmar` share. Each is a function over its own arguments that returns the
 * process's exit code: 0 done, 1 bad input or failed work, 2 bad usage, 3 numerical stop, 4 no resources,
 * 128 and its number stopped by a signal after saving.
 */
#ifndef CLI_CLI_H
#define CLI_CLI_H

#include "data/kind.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/hand/model.h"
#include "models/model.h"
#include "train/config.h"

#include <argp.h>

struct cJSON;

int cmd_synth(int argc, char **argv);
int cmd_train(int argc, char **argv);
int cmd_eval(int argc, char **argv);
int cmd_predict(int argc, char **argv);
int cmd_watch(int argc, char **argv);
int cmd_bench(int argc, char **argv);
int cmd_export(int argc, char **argv);
int cmd_report(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_gradcheck(int argc, char **argv);

/* cli_parse - argp over a subcommand's arguments, known to people as "palmar NAME" */
void cli_parse(const char *name, const struct argp *argp, int argc, char **argv, void *input);

/* cli_exit_code - what a command ends with: 0; 1 input; 2 usage; 3 not finite; 4 disk or memory; 128 + signal where
 * one stopped it */
int cli_exit_code(lt_status status, int signal);

/* cli_fail - print "palmar: " and the last error's line; the exit code that goes with the status */
int cli_fail(lt_status status);

/* cli_real - a number between lo and hi, or a usage error naming the option, which is given without its dashes */
double cli_real(struct argp_state *state, const char *option, const char *text, double lo, double hi);

/* cli_whole, cli_number - a whole one, likewise */
double cli_whole(struct argp_state *state, const char *option, const char *text, double lo, double hi);
int cli_number(struct argp_state *state, const char *option, const char *text, int lo, int hi);

/* What is said of a config on the command line. */
typedef struct {
    const char *set[128];           /* "key=value" */
    int n;
    char variant[64];               /* room for one of them */
} cli_overrides;

/* cli_override - one more, borrowed; cli_override_variant - "model.variant=NAME" */
void cli_override(struct argp_state *state, cli_overrides *o, const char *text);
void cli_override_variant(struct argp_state *state, cli_overrides *o, const char *name);

/* cli_threads - the --threads option: sets the number of threads */
void cli_threads(struct argp_state *state, const char *text);

/* In the text of an option these stand for what the table of dataset kinds says (dataset_list_kinds): "HO3D or DexYCB",
 * "DexYCB: s0, s1 ...". cli_help_kinds puts it there, where it is the argp's help_filter. */
#define CLI_KINDS "@kinds"
#define CLI_SETUPS "@setups"
#define CLI_FILTERS "@filters"
char *cli_help_kinds(int key, const char *text, void *input);

/* cli_begin - before anything else: standard streams are open, what was printed is checked at exit, signals and
 * limits leave no temporary files */
void cli_begin(void);

/* cli_stop_requested - SIGINT or SIGTERM arrived; its number, or 0. cli_catch_signals makes it so; a
 * second signal ends the process at once, and so does a second without an end. */
int cli_stop_requested(void);
void cli_catch_signals(void);

/* cli_progress - a line "what 12/96" on stderr, redrawn on a terminal, now and then elsewhere */
void cli_progress(const char *what, int64_t done, int64_t total);

/* cli_print_json - one line of JSON on stdout; takes root. NULL: LT_ENOMEM, "no memory for WHAT" */
lt_status cli_print_json(struct cJSON *root, const char *what);

/* What a model needs to be built: the hand it poses. */
typedef struct {
    lt_arena *arena;
    lt_hand_model *model, *left;    /* the right hand; the left one's file, or NULL */
    lt_hand_layer *layer;
    const char *name;               /* "embedded synthetic hand", or the file's name */
} cli_hand;

/**
 * cli_hand_open - hands_open, and the layer that poses the right hand
 *
 * tips NULL: HO3D's. cli_hand_close frees it.
 */
lt_status cli_hand_open(const char *path, const int *tips, cli_hand *out);
void cli_hand_close(cli_hand *h);

/* cli_root - the folder of what comes with palmar: of a program that lies where it was built, its own tree; else what
 * was installed with it */
void cli_root(char *out, size_t n);

/* cli_find_config - the config that a user means: a file, the one in a run's folder, or by its name ("hocat-tiny") one
 * that comes with palmar; a usage error when there is none. Valid until called again. */
const char *cli_find_config(struct argp_state *state, const char *name);

/**
 * cli_model_new - a model with a config, initialised from seed 0
 *
 * config is a file with a "model" group, or NULL; name NULL: of that group, else HOCAT; cls is a model that is not in
 * the zoo, or NULL. What `over` says goes on top. *params is the caller's to free.
 */
lt_status cli_model_new(const model_class *cls, const char *name, const char *config, const cli_overrides *over,
                        const cli_hand *hand, lt_params **params, model *out);

/* A trained model, and what it was trained with. */
typedef struct {
    lt_arena *arena;
    const char *path;               /* the checkpoint file */
    const char *run;                /* the folder of its run, or the one it lies in */
    train_config config;
    cli_hand hand;
    lt_params *params;
    model m;
    int64_t step;
    int tips[5];                    /* vertices that its hand layer took for finger tips */
} cli_checkpoint;

/**
 * cli_checkpoint_open - a checkpoint file, or the last one of a run's folder
 *
 * hand as in cli_hand_open; NULL: what the run was trained with. cli_checkpoint_close frees it, also
 * after a failure.
 */
lt_status cli_checkpoint_open(const char *path, const char *hand, cli_checkpoint *out);

/* cli_checkpoint_find, cli_checkpoint_load - the two halves of it: what the file says of itself, for a model of any
 * task; then hand and model, of one that looks at a crop with a hand and an object. Errors: another task's. */
lt_status cli_checkpoint_find(const char *path, cli_checkpoint *out);

/* cli_checkpoint_find_with - the same, with keys of its configuration said anew. Errors: those of keys, LT_EUSAGE */
lt_status cli_checkpoint_find_with(const char *path, const cli_overrides *over, cli_checkpoint *out);
lt_status cli_checkpoint_load(cli_checkpoint *c, const char *hand);
void cli_checkpoint_close(cli_checkpoint *c);

/* cli_checkpoint_want_hands - LT_EINVAL where the model is trained for something else than hand and object in a crop */
lt_status cli_checkpoint_want_hands(const cli_checkpoint *c);

/* cli_checkpoint_data - a split of the dataset in root as the run read its own: objects' models (where they still are),
 * DexYCB's setup and filter, both hands */
dataset_options cli_checkpoint_data(const cli_checkpoint *c, const char *root, const char *split);

#endif
