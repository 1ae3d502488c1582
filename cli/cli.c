/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "assets/hands.h"
#include "estimate/checkpoint/checkpoint.h"
#include "libtensor/base/clock.h"
#include "libtensor/base/parallel.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- arguments ---------------------------------------------------------------------------------------- */

/* argp looks at few of its allocations: an assertion or a fault is what becomes of the others. */
static void without_memory(int number)
{
    static const char line[] = "palmar: no memory for the command line\n";
    ssize_t written = write(STDERR_FILENO, line, sizeof(line) - 1);

    (void)number, (void)written;
    _exit(4);
}

void cli_parse(const char *name, const struct argp *argp, int argc, char **argv, void *input)
{
    static char full[64];

    snprintf(full, sizeof(full), "palmar %s", name);
    argv[0] = full;
    for (int i = 1; i < argc; i++)          /* argp knows -? alone */
        if (strcmp(argv[i], "-h") == 0)
            argv[i] = "--help";
    argp_err_exit_status = 2;
    signal(SIGABRT, without_memory);
    signal(SIGSEGV, without_memory);
    if (argp_parse(argp, argc, argv, 0, NULL, input))
        without_memory(0);
    signal(SIGABRT, SIG_DFL);
    signal(SIGSEGV, SIG_DFL);
}

double cli_real(struct argp_state *state, const char *option, const char *text, double lo, double hi)
{
    char *end;
    const double x = strtod(text, &end);

    if (end == text || *end || !(x >= lo && x <= hi))
        argp_error(state, "--%s: found \"%s\", want a number from %g to %g", option, text, lo, hi);
    return x;
}

double cli_whole(struct argp_state *state, const char *option, const char *text, double lo, double hi)
{
    const double x = cli_real(state, option, text, lo, hi);

    if (x != floor(x))
        argp_error(state, "--%s: found \"%s\", want a whole number", option, text);
    return x;
}

int cli_number(struct argp_state *state, const char *option, const char *text, int lo, int hi)
{
    return (int)cli_whole(state, option, text, lo, hi);
}

void cli_override(struct argp_state *state, cli_overrides *o, const char *text)
{
    if (o->n == LT_COUNT(o->set))
        argp_error(state, "at most %zu overrides", LT_COUNT(o->set));
    o->set[o->n++] = text;
}

void cli_override_variant(struct argp_state *state, cli_overrides *o, const char *name)
{
    snprintf(o->variant, sizeof(o->variant), "model.variant=%s", name);
    cli_override(state, o, o->variant);
}

void cli_threads(struct argp_state *state, const char *text)
{
    lt_set_threads(cli_number(state, "threads", text, 1, 1024));
}

/* argp frees what is another text than the one it gave. */
char *cli_help_kinds(int key, const char *text, void *input)
{
    static const struct { const char *word; dataset_list list; } known[] = {
        { CLI_KINDS, DATASET_TITLES }, { CLI_SETUPS, DATASET_SETUPS }, { CLI_FILTERS, DATASET_FILTERS },
    };

    (void)key, (void)input;
    for (size_t i = 0; text && i < LT_COUNT(known); i++) {
        const char *at = strstr(text, known[i].word);
        char list[DATASET_LIST], *filled = at ? malloc(strlen(text) + sizeof(list)) : NULL;
        if (!filled)
            continue;
        dataset_list_kinds(known[i].list, list);
        sprintf(filled, "%.*s%s%s", (int)(at - text), text, list, at + strlen(known[i].word));
        return filled;
    }
    return (char *)text;
}

/* ---- beginning and leaving ------------------------------------------------------------------------------ */

/* A closed one's number would go to a file, and what is printed with it. */
static void open_standard_streams(void)
{
    int fd;

    do
        fd = open("/dev/null", O_RDWR);
    while (fd >= 0 && fd <= STDERR_FILENO);
    if (fd >= 0)
        close(fd);
}

/* What was printed must have arrived. _exit: libraries' threads are not waited for. */
static void leave(int code, void *nothing)
{
    (void)nothing;
    if ((fflush(stdout) != 0 || ferror(stdout)) && code == 0) {
        fprintf(stderr, "palmar: standard output: %s\n", strerror(errno));
        code = 4;
    }
    fflush(NULL);
    _exit(code);
}

static void on_fatal_signal(int number)
{
    lt_atomic_unlink_all();
    signal(number, SIG_DFL);
    raise(number);
}

/* What is ignored, as nohup has it, stays so; and a command may catch it later. */
static void leave_nothing_on(int number)
{
    if (signal(number, SIG_IGN) != SIG_IGN)
        signal(number, on_fatal_signal);
}

void cli_begin(void)
{
    open_standard_streams();
    lt_json_watch_memory();
    on_exit(leave, NULL);
    signal(SIGXFSZ, SIG_IGN);           /* then it is an error of write */
    leave_nothing_on(SIGINT);
    leave_nothing_on(SIGTERM);
    leave_nothing_on(SIGHUP);
}

/* ---- failing and stopping ------------------------------------------------------------------------------ */

static volatile sig_atomic_t stop_signal;

static void end_at_once(int number)
{
    (void)number;
    lt_atomic_unlink_all();
    _exit(128 + stop_signal);
}

/* Work that has not come to an end in time is ended: nothing half written gets its name. */
static void on_signal(int number)
{
    if (stop_signal)
        end_at_once(number);
    stop_signal = number;
    alarm(1);
}

void cli_catch_signals(void)
{
    struct sigaction a = { .sa_handler = on_signal };

    sigaction(SIGINT, &a, NULL);
    sigaction(SIGTERM, &a, NULL);
    a.sa_handler = end_at_once;
    sigaction(SIGALRM, &a, NULL);
}

int cli_stop_requested(void)
{
    return stop_signal;
}

int cli_exit_code(lt_status status, int signal)
{
    switch (status) {
    case LT_OK:
        return 0;
    case LT_EUSAGE:
        return 2;
    case LT_ENUMERIC:
        return 3;
    case LT_ENOMEM:
    case LT_ENOSPC:
        return 4;
    case LT_ESTOPPED:
        return signal ? 128 + signal : 1;
    default:
        return 1;
    }
}

int cli_fail(lt_status status)
{
    fprintf(stderr, "palmar: %s\n", lt_last_error());
    return cli_exit_code(status, stop_signal);
}

void cli_progress(const char *what, int64_t done, int64_t total)
{
    static double last;
    const bool terminal = lt_is_terminal(STDERR_FILENO);

    if (done < total && lt_clock() - last < (terminal ? 0.2 : 10))
        return;
    last = lt_clock();
    fprintf(stderr, terminal ? "\r\033[K%s %lld/%lld" : "%s %lld/%lld\n", what, (long long)done, (long long)total);
    if (terminal && done >= total)
        fputc('\n', stderr);
}

lt_status cli_print_json(cJSON *root, const char *what)
{
    if (!root || lt_json_lacked_memory())
        return lt_error(LT_ENOMEM, "no memory for %s", what);
    lt_json_print(stdout, root);
    putchar('\n');
    cJSON_Delete(root);
    return LT_OK;
}

/* ---- hands and models ----------------------------------------------------------------------------------- */

lt_status cli_hand_open(const char *path, const int *tips, cli_hand *h)
{
    hands both;
    lt_status st;

    *h = (cli_hand){ .arena = lt_arena_new() };
    if (!h->arena)
        return lt_error(LT_ENOMEM, "no memory for the hand model");
    st = hands_open(h->arena, path, &both);
    if (st == LT_OK) {
        h->model = both.right;
        h->left = both.left;
        h->name = both.name;
        st = lt_hand_layer_new(h->arena, h->model, tips ? tips : lt_hand_tips_ho3d, &h->layer);
    }
    if (st)
        cli_hand_close(h);
    return st;
}

void cli_hand_close(cli_hand *h)
{
    lt_arena_free(h->arena);
    h->arena = NULL;
}

void cli_root(char *out, size_t n)
{
    char built[4096];

    if (lt_program_folder(out, n) && snprintf(built, sizeof(built), "%s/config.status", out) < (int)sizeof(built)
        && access(built, F_OK) == 0)
        snprintf(out, n, "%s", PALMAR_SRCDIR);
    else
        lt_installed(PALMAR_DATADIR, out, n);
}

const char *cli_find_config(struct argp_state *state, const char *name)
{
    static char path[8192];
    const char *dash = strchr(name, '-'), *own = dash ? dash + 1 : name;
    const int folder = (int)(own == name ? strlen(name) : (size_t)(dash - name));
    char root[4096];

    if (lt_is_folder(name)) {
        snprintf(path, sizeof(path), "%s/config.json", name);
        return path;
    }
    if (access(name, F_OK) == 0 || strchr(name, '/'))
        return name;
    cli_root(root, sizeof(root));
    if (snprintf(path, sizeof(path), "%s/models/%.*s/configs/%s.json", root, folder, name, own) < (int)sizeof(path)
        && access(path, R_OK) == 0)
        return path;
    argp_error(state, "no config \"%s\": neither a file nor one that comes with palmar, as hocat-tiny does", name);
    return NULL;
}

/* The config that a checkpoint carries */
static lt_status config_of_checkpoint(const char *path, cJSON **root)
{
    lt_arena *arena = lt_arena_new();
    checkpoint_head head;
    lt_status st = arena ? checkpoint_head_read(arena, path, &head) : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (st == LT_OK)
        st = lt_json_parse(path, head.config, strlen(head.config), root);
    lt_arena_free(arena);
    return st;
}

static lt_status read_config(const char *config, cJSON **root)
{
    if (config && lt_kind_of_file(config) == LT_KIND_SAFETENSORS)
        return config_of_checkpoint(config, root);
    if (config)
        return lt_json_read(config, root);
    *root = cJSON_CreateObject();
    return *root ? LT_OK : lt_error(LT_ENOMEM, "no memory for a config");
}

/* Whose config it is: a model of another name would find its keys strange. */
static lt_status find_model(const char *name, const char *config, const char *where, cJSON *group,
                            const model_class **out)
{
    const char *own = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(group, "name"));

    if (name && own && strcmp(name, own))
        return lt_error(LT_EUSAGE, "%s: a config of %s, but --model is %s", config, own, name);
    if (model_find(name ? name : own ? own : "hocat", out) == LT_OK)
        return LT_OK;
    return name ? lt_error_prefix(LT_EUSAGE, "--model") : lt_error_prefix(LT_EINVAL, "%s.name", where);
}

/* Here a config is its model alone: a key of another group would change nothing. */
static lt_status set_key(cJSON *root, const char *assignment)
{
    if (strncmp(assignment, "model.", 6) != 0)
        return lt_error(LT_EUSAGE, "--set %s: want model.KEY=VALUE, as only the model is read here", assignment);
    return lt_config_set(root, "--set", assignment);
}

lt_status cli_model_new(const model_class *cls, const char *name, const char *config, const cli_overrides *over,
                        const cli_hand *hand, lt_params **params, model *out)
{
    cJSON *root = NULL, *group;
    char where[4200];
    lt_status st = read_config(config, &root);

    snprintf(where, sizeof(where), "%s%smodel", config ? config : "", config ? ": " : "");
    *params = NULL;
    for (int i = 0; st == LT_OK && i < over->n; i++)
        st = set_key(root, over->set[i]);
    group = cJSON_GetObjectItemCaseSensitive(root, "model");
    if (st == LT_OK && !cls)
        st = find_model(name, config, where, group, &cls);
    if (st == LT_OK) {
        cJSON_DeleteItemFromObjectCaseSensitive(group, "name");
        *params = lt_params_new();
        st = *params ? model_create(cls, where, group, hand->layer, *params, out)
                     : lt_error(LT_ENOMEM, "no memory for the model");
    }
    if (st == LT_OK)
        cls->init(out, 0);
    cJSON_Delete(root);
    return st ? lt_config_blame(config ? config : "", "--set", over->set, over->n, st) : LT_OK;
}
