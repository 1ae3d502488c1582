/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/write/coco.h"

#include "libtensor/io/text/json.h"

lt_status synth_coco_open(synth_coco *c, const char *split)
{
    lt_status st;

    *c = (synth_coco){ .split = split };
    st = synth_growing_open(&c->images, "a list of images");
    return st ? st : synth_growing_open(&c->annotations, "a list of annotations");
}

void synth_coco_fini(synth_coco *c)
{
    synth_growing_fini(&c->images);
    synth_growing_fini(&c->annotations);
}

void synth_coco_add(synth_coco *c, const synth_coco_image *image)
{
    FILE *f = c->annotations.stream;

    fprintf(c->images.stream, "%s\n{\"id\": %lld, \"file_name\": \"%s\", \"width\": %d, \"height\": %d}",
            c->n_images ? "," : "", (long long)c->n_images + 1, image->file, image->width, image->height);
    c->n_images++;
    for (int i = 0; i < image->n; i++) {
        const synth_thing *t = &image->seen[i].thing;
        const synth_pixels *b = &image->seen[i].box;

        fprintf(f, "%s\n{\"id\": %lld, \"image_id\": %lld, \"category_id\": %d, ", c->n_annotations ? "," : "",
                (long long)c->n_annotations + 1, (long long)c->n_images, t->kind + 1);
        fprintf(f, "\"bbox\": [%d, %d, %d, %d], \"area\": %lld, \"iscrowd\": 0, ", b->x0, b->y0, b->x1 - b->x0,
                b->y1 - b->y0, (long long)image->seen[i].area);
        if (t->kind == SYNTH_HAND_THING)
            fprintf(f, "\"side\": \"%s\", ", t->left ? "left" : "right");
        fprintf(f, "\"visible\": %.4f, \"segmentation\": {\"size\": [%d, %d], \"counts\": ", image->seen[i].visible,
                image->height, image->width);
        lt_json_print_string(f, image->seen[i].counts);
        fprintf(f, "}}");
        c->n_annotations++;
    }
}

static void print_categories(FILE *f)
{
    for (int k = 0; k < SYNTH_CLASSES; k++)
        fprintf(f, "%s\n{\"id\": %d, \"name\": \"%s\", \"supercategory\": \"%s\"}", k ? "," : "", k + 1,
                synth_class_name(k), k == SYNTH_PERSON_THING ? "person" : k == SYNTH_HAND_THING ? "hand" : "object");
}

lt_status synth_coco_close(synth_coco *c, const char *root, synth_manifest *manifest)
{
    synth_growing all;
    char within[96];
    lt_status st = synth_growing_open(&all, "annotations");

    if (st)
        return st;
    fflush(c->images.stream);
    fflush(c->annotations.stream);
    fprintf(all.stream, "{\"info\": {\"description\": \"synthetic, made by palmar synth\"}, \"licenses\": [],\n"
            "\"images\": [%s],\n\"annotations\": [%s],\n\"categories\": [", c->images.text, c->annotations.text);
    print_categories(all.stream);
    fprintf(all.stream, "]}\n");
    snprintf(within, sizeof(within), "annotations/instances_%s.json", c->split);
    return synth_growing_write(&all, root, within, manifest);
}
