/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "cli/predict_film.h"
#include "cli/vision_models.h"
#include "estimate/starter.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "pipeline/calibration/calibration.h"
#include "pipeline/predict.h"
#include "tasks/body/task.h"
#include "tasks/detect/task.h"
#include "tasks/hand_object/config.h"
#include "train/task.h"

#include <stdio.h>
#include <string.h>

enum { MAX_INPUTS = 4096 };
enum {
    HAND_BOX = 256, OBJECT_BOX, OBJECT, MODELS, CAMERA, LENS, HAND, SIDE, FPS, DEPTH, DEPTH_SCALE, NUMBERS, MESH, BOXES,
    DETECTOR, JSON, TRACK, REID, FILM, TURN, BODY, PERSON_BOX,
};

typedef struct {
    const char *checkpoint;             /* NULL: none */
    cli_vision_names vision;
    bool starter;                       /* no model is named: take those that come with palmar */
    const char *hand, *out, *object, *models, *depth, *boxes, *camera, *lens;
    const char *path[MAX_INPUTS + 1], *const *inputs;       /* as they stand; n_inputs of them, without the model */
    int n_paths, n_inputs;
    crop_box hand_box, object_box, person_box;
    predict_format format;
    bool has_hand_box, has_object_box, has_person_box, has_mesh, has_side, left;
    bool pipe;                          /* "-": frames come through standard input */
    double fps, depth_scale;
    cli_film film;                      /* of a model of Gaussians */
    bool numbers, quiet, json, has_track;
    track_method track;
} predict_args;

static const struct argp_option options[] = {
    { "detector", DETECTOR, "RUN|FILE", 0, "finds hands, objects and people: a run of csp_seg, its weights, or those "
      "of YOLOv8n-seg (.pt). Hands are what it calls hand, left_hand or right_hand; a list of boxes goes before it. "
      "Without RUN what it finds is all there is", 0 },
    { "body", BODY, "RUN|FILE", 0, "whole bodies of the people that the detector finds: a run of osx, or its "
      "checkpoint. RUN itself may be one", 0 },
    { "person-box", PERSON_BOX, "X0,Y0,X1,Y1", 0, "where the person is, pixels, without a detector; default the whole "
      "image", 0 },
    { "hand-box", HAND_BOX, "X0,Y0,X1,Y1", 0, "where the hand is, pixels; default the middle of the image", 0 },
    { "object-box", OBJECT_BOX, "X0,Y0,X1,Y1", 0, "where the object is, pixels; default around the hand box", 0 },
    { "boxes", BOXES, "FILE", 0, "boxes image by image, as a detector left them: CSV with the columns image, hand_x0, "
      "hand_y0, hand_x1, hand_y1, and if known object_x0 to object_y1, object_name and side; a line for each hand. An "
      "image is a file's name, a film's frame film.mp4#12. What is not in it --hand-box, --object-box, --object and "
      "--side say", 0 },
    { "object", OBJECT, "NAME", 0, "which object, as 006_mustard_bottle, or any folder of --models; default none: no "
      "object pose", 0 },
    { "models", MODELS, "DIR", 0, "a dataset's models/ folder, or one with objects of your own: a folder for each, "
      "with a mesh in it; default the embedded stand-ins", 0 },
    { "K", CAMERA, "FX,FY,CX,CY|FILE", 0, "the camera, pixels of the upright image: four numbers, the nine of a "
      "matrix, or a file of either, JSON or YAML, OpenCV's too; default from EXIF, else a guess", 0 },
    { "distortion", LENS, "K1,K2,P1,P2[,K3[,K4,K5,K6]]", 0, "the lens, as OpenCV calibrates it: it is taken out of the "
      "images first. Default what the file of --K says, else none", 0 },
    { "depth", DEPTH, "FILE|DIR", 0, "the image's depth, or a folder with NAME.png for NAME.jpg and NAME-000001.png "
      "for a film's first frame: as large as the image, 16 bits in millimetres or as HO3D packs it; default none", 0 },
    { "depth-scale", DEPTH_SCALE, "METRES", 0, "what a step of a 16-bit depth image is; default 0.001, RealSense's "
      "L515 has 0.00025", 0 },
    { "fps", FPS, "N", 0, "the images are a film's frames, N a second: smooth them, and bridge frames where hand or "
      "object are lost; default unrelated images. A film says it by itself", 0 },
    { "mesh", MESH, "FORMAT", 0, "obj (default), ply, or glb: hand and object in one scene", 0 },
    { "side", SIDE, "SIDE", 0, "right or left hand, where neither --boxes nor the detector says; default: what it "
      "looks most like, in films right", 0 },
    { "hand", HAND, "FILE", 0, "hand model (MANO_RIGHT.pkl, npz or embedded); default the one of the training", 0 },
    { "film", FILM, "FILE", 0, "of a run of hogs or splats: a film (.mp4) of the frames of FOLDER, or without one of "
      "those that it is validated on, the truth beside the rendering, 10 a second or --fps; needs OpenCV", 0 },
    { "turn", TURN, NULL, 0, "with --film: once around the first frame, 30 views a second", 0 },
    { "json", JSON, NULL, 0, "a line of JSON for each image on standard output; no files, unless --out names a folder",
      0 },
    { "track", TRACK, "METHOD", 0, "how what a detector finds gets the numbers that it keeps through a film: byte, by "
      "overlap, that of less sure boxes too; iou, by the overlap of sure ones; deepsort, by looks. Default byte, with "
      "a network for looks deepsort", 0 },
    { "reid", REID, "RUN|FILE", 0, "the network that tells how things look: a run of reid, or its checkpoint", 0 },
    { "numbers", NUMBERS, NULL, 0, "JSON alone: no overlays and no meshes, which take longer than the estimate", 0 },
    { "quiet", 'q', NULL, 0, "no notes, which are in the JSON, but of what was skipped", 0 },
    { "out", 'o', "DIR", 0, "where the results go; default predictions; frames from a pipe leave none", 0 },
    { "threads", 't', "N", 0, "default: the CPUs this process may use", 0 },
    { 0 },
};

static void add_path(predict_args *a, struct argp_state *state, const char *path)
{
    if (a->n_paths > MAX_INPUTS)
        argp_error(state, "at most %d images and folders; put them in a folder", MAX_INPUTS);
    a->path[a->n_paths++] = path;
}

static bool is_run(const char *path)
{
    lt_arena *arena = lt_arena_new();
    const char *folder = arena ? lt_path_join(arena, path, "checkpoints") : NULL;
    const bool is = folder && lt_is_folder(folder);

    lt_arena_free(arena);
    return is;
}

static bool is_picture(const char *path)
{
    const lt_kind kind = lt_kind_of_file(path);

    return (kind >= LT_KIND_PNG && kind <= LT_KIND_AVI) || strcmp(path, "-") == 0;
}

/* The first of the paths is a model; it need not be with a detector or a body estimator, or where there is nothing but
 * pictures. */
static void take_model(predict_args *a)
{
    const char *first = a->path[0];
    const bool is_model = first && (is_run(first) || lt_kind_of_file(first) == LT_KIND_SAFETENSORS);
    int models;

    a->starter = first && !is_model && !a->vision.detector && !a->vision.body && (is_picture(first) || a->n_paths == 1);
    models = first && (is_model || (!a->vision.detector && !a->vision.body && !a->starter));
    a->checkpoint = models ? first : NULL;
    a->inputs = a->path + models;
    a->n_inputs = a->n_paths - models;
    for (int i = 0; i < a->n_inputs; i++)
        a->pipe = a->pipe || strcmp(a->inputs[i], "-") == 0;
}

/* Frames from a pipe are JSON on standard output, and nothing else. */
static void check_pipe(const predict_args *a, struct argp_state *state)
{
    if (a->n_inputs > 1)
        argp_error(state, "-: frames from a pipe go alone, without other images");
    if (a->out || a->has_mesh || a->depth)
        argp_error(state, "%s: does not go with frames from a pipe, whose results are JSON on standard output",
                   a->out ? "--out" : a->depth ? "--depth" : "--mesh");
}

static void parse_side(predict_args *a, struct argp_state *state, const char *text)
{
    a->has_side = true;
    a->left = strcmp(text, "left") == 0;
    if (!a->left && strcmp(text, "right") != 0)
        argp_error(state, "--side: found \"%s\", want right or left", text);
}

static void parse_track(predict_args *a, struct argp_state *state, const char *text)
{
    int k = 0;

    while (k < TRACK_METHODS && strcmp(text, track_method_names[k]) != 0)
        k++;
    if (k == TRACK_METHODS)
        argp_error(state, "--track: found \"%s\", want deepsort, byte or iou", text);
    a->has_track = true;
    a->track = (track_method)k;
}

/* Looks are of use where a method goes by them, and DeepSORT cannot do without. */
static void check_track(predict_args *a, struct argp_state *state)
{
    if (!a->has_track)
        a->track = a->vision.reid ? TRACK_DEEPSORT : TRACK_BYTE;
    if (a->track == TRACK_DEEPSORT && !a->vision.reid)
        argp_error(state, "--track deepsort: goes by looks; want --reid, a run of the network that tells them");
    if (a->track == TRACK_IOU && a->vision.reid)
        argp_error(state, "--reid: --track iou does not go by looks");
}

/* A film is of a model of Gaussians alone, which is named. */
static void check_film(predict_args *a, struct argp_state *state)
{
    if (a->film.turn && !a->film.path)
        argp_error(state, "--turn: goes with --film");
    if (a->film.path && !a->checkpoint)
        argp_error(state, "--film: want a run of hogs or splats, or its checkpoint");
    if (a->film.path && (a->n_inputs > 1 || a->out))
        argp_error(state, "--film: want one folder of frames at most, and no --out");
    a->film.fps = a->fps;
}

/* An option whose text is wrong is a usage error that says what the parser said. */
static void must(struct argp_state *state, lt_status st)
{
    if (st)
        argp_error(state, "%s", lt_last_error());
}

static error_t parse(int key, char *arg, struct argp_state *state)
{
    predict_args *a = state->input;

    switch (key) {
    case 'o': a->out = arg; break;
    case 't': cli_threads(state, arg); break;
    case OBJECT: a->object = arg; break;
    case MODELS: a->models = arg; break;
    case 'q': a->quiet = true; break;
    case NUMBERS: a->numbers = true; break;
    case DEPTH: a->depth = arg; break;
    case DEPTH_SCALE: a->depth_scale = cli_real(state, "depth-scale", arg, 1e-6, 10); break;
    case BOXES: a->boxes = arg; break;
    case CAMERA: a->camera = arg; break;
    case LENS: a->lens = arg; break;
    case HAND: a->hand = arg; break;
    case FPS: a->fps = cli_real(state, "fps", arg, 1, 1000); break;
    case SIDE: parse_side(a, state, arg); break;
    case MESH:
        must(state, predict_parse_format("--mesh", arg, &a->format));
        a->has_mesh = true;
        break;
    case HAND_BOX:
        must(state, predict_parse_box("--hand-box", arg, &a->hand_box));
        a->has_hand_box = true;
        break;
    case OBJECT_BOX:
        must(state, predict_parse_box("--object-box", arg, &a->object_box));
        a->has_object_box = true;
        break;
    case PERSON_BOX:
        must(state, predict_parse_box("--person-box", arg, &a->person_box));
        a->has_person_box = true;
        break;
    case DETECTOR: a->vision.detector = arg; break;
    case BODY: a->vision.body = arg; break;
    case FILM: a->film.path = arg; break;
    case TURN: a->film.turn = true; break;
    case JSON: a->json = true; break;
    case TRACK: parse_track(a, state, arg); break;
    case REID: a->vision.reid = arg; break;
    case ARGP_KEY_ARG: add_path(a, state, arg); break;
    case ARGP_KEY_END:
        take_model(a);
        check_film(a, state);
        if (!a->n_inputs && !a->film.path)
            argp_error(state, "want images or films, and before them a checkpoint or a run's folder, if not those that "
                       "come with palmar");
        if (a->vision.detector && (a->has_hand_box || a->has_object_box || a->has_person_box))
            argp_error(state, "--%s-box: --detector finds where they are", a->has_hand_box ? "hand"
                       : a->has_object_box ? "object" : "person");
        check_track(a, state);
        if (a->depth_scale > 0 && !a->depth)
            argp_error(state, "--depth-scale: goes with --depth");
        if (a->lens && !a->camera)
            argp_error(state, "--distortion: goes with --K, which it was calibrated with");
        if (a->pipe)
            check_pipe(a, state);
        else if (!a->out && !a->json && !a->film.path)
            a->out = "predictions";
        break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static const struct argp argp = {
    options, parse, "CHECKPOINT|RUN IMAGE|FILM|FOLDER...\nCHECKPOINT|RUN -\n"
    "[CHECKPOINT|RUN] IMAGE|FILM|FOLDER... [--detector=RUN|FILE]",
    "Estimate hands, objects and bodies in images and films: an overlay, JSON and meshes for each.\v"
    "The networks look where a detector or the boxes say. What is not given is assumed, and said. In place of "
    "images - reads PPM, PNG or JPEG pictures one behind the other from standard input, and prints a line of JSON for "
    "each.\n\n"
    "  palmar predict photo.jpg                      by the small models that come with palmar, where they do\n"
    "  palmar predict runs/tiny photo.jpg --detector runs/detect\n"
    "  palmar predict photo.jpg --detector yolov8n-seg.pt --json\n"
    "  palmar predict runs/tiny photo.jpg --hand-box 210,120,420,330 --object mug\n"
    "  palmar predict runs/tiny film.mp4 --boxes boxes.csv\n"
    "  palmar predict photo.jpg --body runs/body --detector runs/detect\n"
    "  palmar predict runs/hogs data/hogs            renderings of frames that a HOGS model has not seen\n"
    "  palmar predict runs/hogs --film turn.mp4 --turn\n"
    "  ffmpeg -i film.mp4 -f image2pipe -c:v ppm - | palmar predict runs/tiny - --fps 30",
    NULL, NULL, NULL,
};

static bool stop(void)
{
    return cli_stop_requested();
}

/* A file may hold both, and an option goes before the file. */
static lt_status read_camera(const predict_args *a, calibration *out)
{
    lt_status st = a->camera ? calibration_read("--K", a->camera, out) : LT_OK;

    return st || !a->lens ? st : calibration_parse_lens("--distortion", a->lens, &out->lens);
}

/* c: the model's, or NULL */
static lt_status run(const predict_args *a, const calibration *camera, const cli_checkpoint *c,
                     const cli_vision_models *by)
{
    predict_options o = {
        .detector = by->detector, .body = by->body, .track = a->track, .embedder = by->embedder,
        .inputs = a->inputs, .n_inputs = a->n_inputs, .pipe = a->pipe, .out = a->out,
        .lines = a->pipe || a->json ? stdout : NULL,
        .hand_box = a->has_hand_box ? &a->hand_box : NULL,
        .object_box = a->has_object_box ? &a->object_box : NULL,
        .person_box = a->has_person_box ? &a->person_box : NULL,
        .camera = a->camera ? &camera->camera : NULL, .camera_width = camera->width, .camera_height = camera->height,
        .camera_skew = camera->skew, .lens = &camera->lens, .boxes = a->boxes, .depth = a->depth,
        .depth_scale = a->depth_scale,
        .object = a->object, .models = a->models, .left = a->left, .any_side = !a->has_side,
        .any_way_up = true, .format = a->format, .fps = a->fps,
        .alone = true, .stop = stop,
        .messages = stderr, .quiet = a->quiet, .numbers = a->numbers,
    };
    predict_summary sum = { 0, 0 };
    lt_status st;

    if (c) {
        o.m = &c->m;
        o.bilinear = hand_object_config_of(&c->config)->bilinear;
        o.hand = c->hand.model;
        o.checkpoint = c->path;
        o.trained_on = c->config.data->dir;
    }
    st = predict_images(&o, &sum);
    if (!a->quiet && a->out && !a->json)
        printf("%d %s written to %s, %d skipped\n", sum.written, sum.written == 1 ? "image" : "images", a->out,
               sum.skipped);
    return st;
}

/* A model of a task that makes something else of its inputs */
static lt_status run_task(const predict_args *a, cli_checkpoint *c)
{
    const task_prediction p = {
        .arena = c->arena, .config = &c->config, .checkpoint = c->path, .hand = a->hand, .inputs = a->inputs,
        .n_inputs = a->n_inputs, .out = a->out, .messages = a->quiet ? NULL : stderr, .stop = stop,
    };
    int64_t written = 0;
    lt_status st;

    if (a->pipe || a->has_hand_box || a->has_object_box || a->boxes || a->depth || a->object || a->camera ||
        a->has_mesh || a->vision.detector || a->json || a->has_track || a->vision.reid || a->vision.body ||
        a->has_person_box)
        return lt_error(LT_EUSAGE, "%s: a model of %s takes folders, and of the options --hand, --out, --quiet and "
                        "--threads", c->path, c->config.task->name);
    if (a->film.path) {
        st = cli_film_write(&a->film, c, a->hand, a->n_inputs ? a->inputs[0] : NULL, &written);
        if (!st && !a->quiet)
            printf("%s: %lld frames\n", a->film.path, (long long)written);
        return st;
    }
    st = c->config.task->predict(&p, &written);
    if (!a->quiet)
        printf("%lld %s written to %s\n", (long long)written, written == 1 ? "frame" : "frames", a->out);
    return st;
}

/* What is asked for, and nothing is there to do it */
static lt_status check_asked(const predict_args *a, const cli_checkpoint *c)
{
    if ((a->has_track || a->vision.reid) && !a->vision.detector)
        return lt_error(LT_EUSAGE, "--%s: goes with --detector, which finds what is tracked",
                        a->vision.reid ? "reid" : "track");
    if (a->has_person_box && !a->vision.body)
        return lt_error(LT_EUSAGE, "--person-box: goes with --body, which looks at it");
    if ((a->boxes || a->has_hand_box || a->has_object_box) && !c)
        return lt_error(LT_EUSAGE, "--%s: goes with a model that looks at them", a->boxes ? "boxes"
                        : a->has_hand_box ? "hand-box" : "object-box");
    return LT_OK;
}

/* c: of a model of hands, found but not loaded; NULL: none */
static lt_status run_hands(const predict_args *a, const calibration *camera, cli_checkpoint *c)
{
    cli_vision_models by = { .detector = NULL };
    lt_status st = check_asked(a, c);

    if (st == LT_OK && c)
        st = cli_checkpoint_load(c, a->hand);
    if (st == LT_OK && c)
        st = cli_checkpoint_want_hands(c);
    if (st == LT_OK)
        st = cli_vision_models_open(&a->vision, &by);
    if (st == LT_OK)
        st = run(a, camera, c, &by);
    cli_vision_models_close(&by);
    return st;
}

/* What comes with palmar finds hands and objects, and looks at them, with depth where that is given. Where only the
 * detector came along, that finds them alone. */
static lt_status take_starter(lt_arena *arena, predict_args *a)
{
    lt_status st = a->has_hand_box ? LT_OK : cli_starter_find(arena, STARTER_DETECTOR, &a->vision.detector);

    if (!st)
        st = cli_starter_find(arena, a->depth ? STARTER_DEPTH : STARTER_COLOUR, &a->checkpoint);
    if (st == LT_EIO && a->vision.detector)
        st = LT_OK;
    if (!st && !a->quiet && a->checkpoint)
        fprintf(stderr, "no model is named: %s%s%s look at it, small ones that were trained on drawn pictures alone "
                "(palmar info starter)\n", a->checkpoint, a->vision.detector ? " and " : "",
                a->vision.detector ? a->vision.detector : "");
    else if (!st && !a->quiet)
        fprintf(stderr, "no model is named: %s looks for hands and objects, a small one that was trained on drawn "
                "pictures alone (palmar info starter); poses take a model\n", a->vision.detector);
    return st;
}

/* c: found where the arguments name a model; a detector or a body estimator alone may stand in its place. */
static lt_status run_model(predict_args *a, const calibration *camera, cli_checkpoint *c)
{
    if (!a->checkpoint)
        return run_hands(a, camera, NULL);
    if (c->config.task->predict || a->film.path)
        return run_task(a, c);
    if (c->config.task == &detect_task && !a->vision.detector)
        a->vision.detector = a->checkpoint;
    else if (c->config.task == &body_task && !a->vision.body)
        a->vision.body = a->checkpoint;
    else
        return run_hands(a, camera, c);
    return run_hands(a, camera, NULL);
}

int cmd_predict(int argc, char **argv)
{
    static predict_args a;
    calibration camera = { .width = 0 };
    cli_checkpoint c = { .path = NULL };
    lt_arena *arena = lt_arena_new();
    lt_status st;

    cli_parse("predict", &argp, argc, argv, &a);
    cli_catch_signals();
    st = arena ? read_camera(&a, &camera) : lt_error(LT_ENOMEM, "no memory to begin");
    if (st == LT_OK && a.starter)
        st = take_starter(arena, &a);
    if (st == LT_OK && a.checkpoint)
        st = cli_checkpoint_find(a.checkpoint, &c);
    if (st == LT_OK)
        st = run_model(&a, &camera, &c);
    cli_checkpoint_close(&c);
    lt_arena_free(arena);
    return st ? cli_fail(st) : 0;
}
