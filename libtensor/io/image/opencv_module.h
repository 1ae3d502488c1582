/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the library and its module for OpenCV say to each other: images and films. The module stands alone: it
 * knows no other name of the library's, and the library links no name of OpenCV's.
 */
#ifndef LT_IO_IMAGE_OPENCV_MODULE_H
#define LT_IO_IMAGE_OPENCV_MODULE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LT_OPENCV_MODULE "images-opencv.so"
#define LT_OPENCV_SYMBOL "images_opencv"        /* an lt_opencv */

/* Room for a picture of 8 or 16 bits a sample; NULL when it is not wanted. */
typedef uint8_t *(*lt_opencv_room)(void *ctx, int width, int height, int channels, int bits);

/*
 * decode      n bytes as an image into the room that it asks for, RGB or RGBA. Returns 0; or not 0 and why in
 *             error, which stays empty when no room was given
 * film_open   a film, its frames per second and their number, 0 where it does not say; NULL, and why in error
 * camera_open a camera by its number, as a film that does not end; NULL, and why in error
 * film_next   its next frame, RGB, as it is stored. Returns 0; or not 0, and error stays empty at the end too
 * film_close
 * film_create a film to write, by the ending of its name; NULL, and why in error
 * film_put    one more frame, RGB. Returns 0; or not 0, and why in error
 * film_finish
 *
 * No exception leaves them.
 */
typedef struct {
    int (*decode)(const uint8_t *bytes, size_t n, lt_opencv_room room, void *ctx, char error[256]);
    void *(*film_open)(const char *path, double *fps, double *frames, char error[256]);
    void *(*camera_open)(int number, char error[256]);
    int (*film_next)(void *film, lt_opencv_room room, void *ctx, char error[256]);
    void (*film_close)(void *film);
    void *(*film_create)(const char *path, int width, int height, double fps, char error[256]);
    int (*film_put)(void *film, int width, int height, const uint8_t *rgb, char error[256]);
    void (*film_finish)(void *film);
} lt_opencv;

#ifdef __cplusplus
}
#endif
#endif
