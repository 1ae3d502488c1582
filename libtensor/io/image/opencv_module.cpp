/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The module that reads images and films through OpenCV. It is loaded when the first such file comes, because
 * OpenCV brings a hundred libraries along. Exceptions end here.
 */
#include "libtensor/io/image/opencv_module.h"

#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

static cv::Mat to_rgb(const cv::Mat &bgr)
{
    cv::Mat rgb = bgr;

    if (bgr.channels() == 3)
        cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
    else if (bgr.channels() == 4)
        cv::cvtColor(bgr, rgb, cv::COLOR_BGRA2RGBA);
    return rgb;
}

static int refuse(char error[256], const char *why)
{
    std::snprintf(error, 256, "%s", why);
    return 1;
}

/* Into the room that is given; 1 when none is. */
static int place(const cv::Mat &rgb, lt_opencv_room room, void *ctx)
{
    const size_t row = rgb.cols * rgb.elemSize();
    uint8_t *out = room(ctx, rgb.cols, rgb.rows, rgb.channels(), rgb.depth() == CV_8U ? 8 : 16);

    for (int y = 0; out && y < rgb.rows; y++)
        std::memcpy(out + y * row, rgb.ptr(y), row);
    return out ? 0 : 1;
}

/* Whatever fn throws becomes a refusal; OpenCV prints nothing. */
template <typename F> static int guarded(char error[256], const char *what, F fn)
{
    error[0] = '\0';
    try {
        cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
        return fn();
    } catch (const std::exception &e) {
        std::snprintf(error, 256, "%s: %s", what, e.what());
    } catch (...) {
        refuse(error, what);
    }
    return 1;
}

/* ---- images ---------------------------------------------------------------------------------------------- */

static const char NO_IMAGE[] = "not an image that can be read";

static int decode_bytes(const uint8_t *bytes, size_t n, lt_opencv_room room, void *ctx, char error[256])
{
    const cv::Mat packed(1, static_cast<int>(n), CV_8U, const_cast<uint8_t *>(bytes));
    const cv::Mat bgr = cv::imdecode(packed, cv::IMREAD_UNCHANGED);

    if (bgr.empty())
        return refuse(error, NO_IMAGE);
    if ((bgr.depth() != CV_8U && bgr.depth() != CV_16U) || bgr.channels() == 2 || bgr.channels() > 4)
        return refuse(error, "samples of a kind that is not read");
    return place(to_rgb(bgr), room, ctx);
}

static int decode(const uint8_t *bytes, size_t n, lt_opencv_room room, void *ctx, char error[256])
{
    if (n > INT_MAX)
        return refuse(error, "too many bytes for an image");
    return guarded(error, NO_IMAGE, [=] { return decode_bytes(bytes, n, room, ctx, error); });
}

/* ---- films ----------------------------------------------------------------------------------------------- */

static const char NO_FILM[] = "not a film that can be read";

/* Frames as they are stored: 4.6 turns them the wrong way, others do not turn them, so that who asks does it. A reader
 * that does not know the property does not turn. */
static bool keep_stored(cv::VideoCapture &film)
{
    film.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
    return film.get(cv::CAP_PROP_ORIENTATION_AUTO) <= 0;
}

/* Of OpenCV's readers those for files: the others look for cameras. FFmpeg would tell its troubles on stderr. */
static void *film_open(const char *path, double *fps, double *frames, char error[256])
{
    std::unique_ptr<cv::VideoCapture> film;
    const int failed = guarded(error, NO_FILM, [&] {
        setenv("OPENCV_FFMPEG_DEBUG", "1", 0);
        setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
        film.reset(new cv::VideoCapture(path, cv::CAP_FFMPEG));
        if (!film->isOpened())
            film->open(path, cv::CAP_OPENCV_MJPEG);
        if (!film->isOpened())
            return refuse(error, NO_FILM);
        if (!keep_stored(*film))
            return refuse(error, "this OpenCV turns frames and cannot be told not to");
        *fps = film->get(cv::CAP_PROP_FPS);
        *frames = film->get(cv::CAP_PROP_FRAME_COUNT);
        return 0;
    });

    return failed ? nullptr : film.release();
}

static const char NO_CAMERA[] = "no camera answers there";

static void *camera_open(int number, char error[256])
{
    std::unique_ptr<cv::VideoCapture> camera;
    const int failed = guarded(error, NO_CAMERA, [&] {
        camera.reset(new cv::VideoCapture(number, cv::CAP_V4L2));
        return camera->isOpened() ? 0 : refuse(error, NO_CAMERA);
    });

    return failed ? nullptr : camera.release();
}

static int film_next(void *film, lt_opencv_room room, void *ctx, char error[256])
{
    return guarded(error, NO_FILM, [=] {
        cv::Mat bgr;

        if (!static_cast<cv::VideoCapture *>(film)->read(bgr) || bgr.empty())
            return 1;
        if (bgr.depth() != CV_8U || bgr.channels() != 3)
            return refuse(error, "frames of a kind that is not read");
        return place(to_rgb(bgr), room, ctx);
    });
}

static void film_close(void *film)
{
    char error[256];

    guarded(error, NO_FILM, [=] {
        delete static_cast<cv::VideoCapture *>(film);
        return 0;
    });
}

/* ---- films to write ---------------------------------------------------------------------------------------- */

static const char CANNOT_WRITE[] = "not a film that can be written";

/* H.264, which browsers play; MPEG-4 where FFmpeg has no encoder for it */
static void *film_create(const char *path, int width, int height, double fps, char error[256])
{
    std::unique_ptr<cv::VideoWriter> film;
    const int failed = guarded(error, CANNOT_WRITE, [&] {
        setenv("OPENCV_FFMPEG_DEBUG", "1", 0);
        setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
        film.reset(new cv::VideoWriter);
        for (const char *codec : { "avc1", "mp4v" })
            if (film->open(path, cv::CAP_FFMPEG, cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]), fps,
                           cv::Size(width, height)))
                return 0;
        return refuse(error, "no film can be written there; want a name that ends in .mp4, in a folder that is there");
    });

    return failed ? nullptr : film.release();
}

static int film_put(void *film, int width, int height, const uint8_t *rgb, char error[256])
{
    return guarded(error, CANNOT_WRITE, [=] {
        const cv::Mat frame(height, width, CV_8UC3, const_cast<uint8_t *>(rgb));
        cv::Mat bgr;

        cv::cvtColor(frame, bgr, cv::COLOR_RGB2BGR);
        static_cast<cv::VideoWriter *>(film)->write(bgr);
        return 0;
    });
}

static void film_finish(void *film)
{
    char error[256];

    guarded(error, CANNOT_WRITE, [=] {
        delete static_cast<cv::VideoWriter *>(film);
        return 0;
    });
}

extern "C" __attribute__((visibility("default"))) const lt_opencv images_opencv = {
    decode, film_open, camera_open, film_next, film_close, film_create, film_put, film_finish,
};
