/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/write/coco.h"

#include "libtensor/io/image/coco_rle.h"
#include "libtensor/io/text/json.h"

enum { LEAST = 16 };                            /* pixels of a thing that is annotated */

static const double LEAST_SHARE = 0.1;          /* visible of it */

lt_status synth_coco_open(synth_coco *c, const char *file)
{
    lt_status st;

    *c = (synth_coco){ .file = file };
    st = synth_growing_open(&c->images, "a list of images");
    return st ? st : synth_growing_open(&c->annotations, "a list of annotations");
}

void synth_coco_fini(synth_coco *c)
{
    synth_growing_fini(&c->images);
    synth_growing_fini(&c->annotations);
}

/* ---- an image ---- */

bool synth_coco_counts(const synth_seen *seen)
{
    return synth_seen_share(seen) >= LEAST_SHARE && seen->visible >= LEAST;
}

lt_status synth_coco_see(lt_arena *arena, const synth_thing *thing, const synth_seen *seen, const uint8_t *whole,
                         synth_coco_image *image)
{
    const int i = image->n;

    image->seen[i].thing = *thing;
    image->seen[i].box = seen->box;
    image->seen[i].area = seen->visible;
    image->seen[i].visible = synth_seen_share(seen);
    image->seen[i].counts = lt_rle_encode(arena, seen->mask, image->height, image->width);
    image->seen[i].whole_box = seen->whole_box;
    image->seen[i].whole_area = seen->whole;
    image->seen[i].whole_counts = whole ? lt_rle_encode(arena, whole, image->height, image->width) : NULL;
    if (!image->seen[i].counts || (whole && !image->seen[i].whole_counts))
        return lt_error(LT_ENOMEM, "synth: no memory for masks");
    image->n++;
    return LT_OK;
}

static void put_box(FILE *f, const synth_pixels *b, int64_t area)
{
    fprintf(f, "\"bbox\": [%d, %d, %d, %d], \"area\": %lld, ", b->x0, b->y0, b->x1 - b->x0, b->y1 - b->y0,
            (long long)area);
}

static void put_mask(FILE *f, const synth_coco_image *image, const char *counts)
{
    fprintf(f, "\"segmentation\": {\"size\": [%d, %d], \"counts\": ", image->height, image->width);
    lt_json_print_string(f, counts);
    fprintf(f, "}");
}

/* An annotation's keys behind its ids */
static void put_thing(FILE *f, const synth_coco_image *image, int i)
{
    const synth_thing *t = &image->seen[i].thing;

    put_box(f, &image->seen[i].box, image->seen[i].area);
    fprintf(f, "\"iscrowd\": 0, ");
    if (t->kind == SYNTH_HAND_THING)
        fprintf(f, "\"side\": \"%s\", ", t->left ? "left" : "right");
    if (image->camera)
        fprintf(f, "\"track_id\": %d, ", t->identity);
    fprintf(f, "\"visible\": %.4f, ", image->seen[i].visible);
    put_mask(f, image, image->seen[i].counts);
    if (image->seen[i].whole_counts) {
        fprintf(f, ", \"amodal\": {");
        put_box(f, &image->seen[i].whole_box, image->seen[i].whole_area);
        put_mask(f, image, image->seen[i].whole_counts);
        fprintf(f, "}");
    }
}

void synth_coco_add(synth_coco *c, const synth_coco_image *image)
{
    FILE *f = c->images.stream;

    fprintf(f, "%s\n{\"id\": %lld, \"file_name\": \"%s\", \"width\": %d, \"height\": %d", c->n_images ? "," : "",
            (long long)c->n_images + 1, image->file, image->width, image->height);
    if (image->camera)
        fprintf(f, ", \"camera\": \"%s\", \"frame\": %d", image->camera, image->frame);
    fprintf(f, "}");
    c->n_images++;
    f = c->annotations.stream;
    for (int i = 0; i < image->n; i++) {
        fprintf(f, "%s\n{\"id\": %lld, \"image_id\": %lld, \"category_id\": %d, ", c->n_annotations ? "," : "",
                (long long)c->n_annotations + 1, (long long)c->n_images, image->seen[i].thing.kind + 1);
        put_thing(f, image, i);
        fprintf(f, "}");
        c->n_annotations++;
    }
}

/* ---- the file ---- */

static void print_categories(FILE *f)
{
    for (int k = 0; k < SYNTH_CLASSES; k++)
        fprintf(f, "%s\n{\"id\": %d, \"name\": \"%s\", \"supercategory\": \"%s\"}", k ? "," : "", k + 1,
                synth_class_name(k), k == SYNTH_PERSON_THING ? "person" : k == SYNTH_HAND_THING ? "hand" : "object");
}

lt_status synth_coco_close(synth_coco *c, const char *root, synth_manifest *manifest)
{
    synth_growing all;
    lt_status st = synth_growing_open(&all, "annotations");

    if (st)
        return st;
    fflush(c->images.stream);
    fflush(c->annotations.stream);
    fprintf(all.stream, "{\"info\": {\"description\": \"synthetic, made by palmar synth\", \"synthetic\": true},"
            " \"licenses\": [],\n"
            "\"images\": [%s],\n\"annotations\": [%s],\n\"categories\": [", c->images.text, c->annotations.text);
    print_categories(all.stream);
    fprintf(all.stream, "]}\n");
    return synth_growing_write(&all, root, c->file, manifest);
}
