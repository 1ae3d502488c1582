/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/export_shapes.h"

#include "libtensor/io/file.h"
#include "tasks/tasks.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <string.h>

static int64_t frame_number(struct argp_state *state, const char *text, size_t n)
{
    char one[32];

    snprintf(one, sizeof(one), "%.*s", (int)(n < sizeof(one) ? n : sizeof(one) - 1), text);
    return (int64_t)cli_whole(state, "frames", one, 0, 1e9);
}

/* Numbers and ranges, "0,10-14" */
void cli_shapes_frames(struct argp_state *state, cli_shapes *s, const char *text)
{
    s->of_frames = true;
    for (s->n_frames = 0; *text; text += *text == ',') {
        const size_t n = strcspn(text, ","), dash = strcspn(text, ",-");
        const int64_t first = frame_number(state, text, dash);
        const int64_t last = dash < n ? frame_number(state, text + dash + 1, n - dash - 1) : first;

        if (last < first)
            argp_error(state, "--frames %.*s: ends before it begins", (int)n, text);
        if (last - first >= CLI_FRAMES - s->n_frames)
            argp_error(state, "--frames: at most %d", CLI_FRAMES);
        for (int64_t i = first; i <= last; i++)
            s->frame[s->n_frames++] = i;
        text += n;
    }
    if (!s->n_frames)
        argp_error(state, "--frames: want numbers from 0, as 0,10 or 0-40");
}

void cli_shapes_rule(struct argp_state *state, cli_shapes *s, const char *text)
{
    s->of_meshes = true;
    for (int i = 0; i < LT_OPACITY_RULES; i++)
        if (strcmp(text, lt_opacity_rule_name((lt_opacity_rule)i)) == 0) {
            s->rule = (lt_opacity_rule)i;
            return;
        }
    argp_error(state, "--rule \"%s\"; want mean or min", text);
}

bool cli_shapes_format(const char *format)
{
    return strcmp(format, "ply") == 0 || strcmp(format, "glb") == 0 || strcmp(format, "splat") == 0;
}

/* Several frames in one file: their surfaces, one after the other */
static bool is_animated(const cli_shapes *s, const char *format)
{
    return !s->folder && s->n_frames > 1 && strcmp(format, "glb") == 0;
}

void cli_shapes_check(struct argp_state *state, const cli_shapes *s, const char *checkpoint, const char *out,
                      const char *format)
{
    const bool gaussians = !s->folder && out && cli_shapes_format(format);

    if (s->folder && out)
        argp_error(state, "--mesh DIR has its files in DIR: no -o");
    if (s->folder && strcmp(format, "ply") != 0 && strcmp(format, "obj") != 0 && strcmp(format, "glb") != 0)
        argp_error(state, "format \"%s\" of meshes; want ply, obj or glb", format);
    if ((s->folder || gaussians) && !checkpoint)
        argp_error(state, "surfaces and Gaussians are those of a checkpoint or a run's folder");
    if (!s->folder && !is_animated(s, format) && s->of_meshes)
        argp_error(state, "--rule and --iso go with --mesh, and with -o of a glb of several frames");
    if (!s->folder && !gaussians && s->of_frames)
        argp_error(state, "--frames goes with --mesh, and with -o of ply, glb or splat");
    if (!gaussians && s->set)
        argp_error(state, "--set-name goes with -o of ply, glb or splat");
    if (s->set && s->of_frames)
        argp_error(state, "--set-name is a set in its canonical place, --frames one as it is posed");
    if (gaussians && s->n_frames > 1 && !is_animated(s, format))
        argp_error(state, "-o %s is one frame's: want one number in --frames, or a glb, which moves", out);
}

typedef struct { bool json; } printer;

static void print_mesh(void *ctx, const task_exported *m)
{
    const printer *p = ctx;
    cJSON *o;

    if (!p->json) {
        printf("%s: %d vertices, %d faces, %s, %d part%s, %.2f s\n", m->file, m->vertices, m->faces,
               m->watertight ? "watertight" : "not watertight", m->components, m->components == 1 ? "" : "s",
               m->seconds);
        return;
    }
    o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "file", m->file);
    cJSON_AddStringToObject(o, "part", m->part);
    cJSON_AddNumberToObject(o, "frame", (double)m->frame);
    cJSON_AddNumberToObject(o, "vertices", m->vertices);
    cJSON_AddNumberToObject(o, "faces", m->faces);
    cJSON_AddBoolToObject(o, "watertight", m->watertight);
    cJSON_AddNumberToObject(o, "components", m->components);
    cJSON_AddNumberToObject(o, "seconds", m->seconds);
    cli_print_json(o, "a mesh");
}

static lt_status print_file(const char *out, const char *format, int animated, bool json)
{
    cJSON *o;

    if (!json && animated)
        printf("%s: surfaces of %d frames, one after the other, %s\n", out, animated, format);
    else if (!json)
        printf("%s: Gaussians, %s\n", out, format);
    if (!json)
        return LT_OK;
    o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "file", out);
    cJSON_AddStringToObject(o, "format", format);
    if (animated)
        cJSON_AddNumberToObject(o, "frames", animated);
    return cli_print_json(o, "the file");
}

lt_status cli_export_shapes(const cli_shapes *s, const char *checkpoint, const char *hand, const char *out,
                            const char *format, bool json)
{
    const int64_t first = 0;
    printer p = { json };
    task_export e = {
        .hand = hand, .frame = s->n_frames ? s->frame : &first, .n_frames = s->n_frames ? s->n_frames : 1,
        .folder = s->folder, .file = out, .format = format, .rule = s->rule, .iso = s->iso > 0 ? s->iso : POSED_ISO,
        .set = s->set, .animated = is_animated(s, format), .made = print_mesh, .ctx = &p,
    };
    cli_checkpoint c;
    lt_status st = cli_checkpoint_find(checkpoint, &c);

    if (!st && !c.config.task->export)
        st = lt_error(LT_EINVAL, "%s: a model of %s, which has neither surfaces nor Gaussians; want one of hogs",
                      c.path, c.config.task->name);
    e.arena = c.arena, e.config = &c.config, e.checkpoint = c.path;
    if (!st)
        st = c.config.task->export(&e);
    if (!st && out)
        st = print_file(out, format, e.animated ? e.n_frames : 0, json);
    cli_checkpoint_close(&c);
    return st;
}
