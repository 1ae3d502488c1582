/* pose RUN PICTURE.ppm: where a hand is that is held before the camera. */
#include <palmar.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    FILE *f = argc == 3 ? fopen(argv[2], "rb") : NULL;
    palmar_image image = { .rgb = NULL };               /* without a camera: one is assumed */
    palmar_query where = { .left = 0 };                 /* without a box: the middle */
    palmar_hand hand;
    palmar *p;

    if (!f || fscanf(f, "P6 %d %d 255", &image.width, &image.height) != 2 || fgetc(f) == EOF)
        return fprintf(stderr, "usage: pose RUN PICTURE.ppm\n"), 2;
    size_t n = 3 * (size_t)image.width * (size_t)image.height;
    uint8_t *rgb = malloc(n);
    if (!rgb || fread(rgb, 1, n, f) != n)
        return fprintf(stderr, "%s: cut off\n", argv[2]), 1;
    image.rgb = rgb;
    if (palmar_open(argv[1], NULL, &p) || palmar_load_object(p, "mug", NULL, &where.object) ||
        palmar_estimate(p, &image, 1, &where, &hand))
        return fprintf(stderr, "%s\n", palmar_last_error()), 1;
    printf("wrist %.4f %.4f %.4f m, %s; mug %s\n", hand.translation[0], hand.translation[1], hand.translation[2],
           hand.trusted ? "trusted" : "doubtful", hand.object_found ? "found" : "not found");
    palmar_close(p);
    free(rgb);
    fclose(f);
}
