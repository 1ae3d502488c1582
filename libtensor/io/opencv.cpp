/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The one door to OpenCV. Exceptions end here.
 */
#include "libtensor/io/opencv.h"

#include <config.h>
#include "libtensor/io/codec.h"

#ifdef HAVE_OPENCV

#include <climits>
#include <cstring>
#include <exception>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

static cv::Mat to_rgb(const cv::Mat &bgr)
{
    cv::Mat rgb = bgr;

    if (bgr.channels() == 3)
        cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
    else if (bgr.channels() == 4)
        cv::cvtColor(bgr, rgb, cv::COLOR_BGRA2RGBA);
    return rgb;
}

static lt_status decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_image *out)
{
    const cv::Mat packed(1, static_cast<int>(n), CV_8U, const_cast<uint8_t *>(bytes));
    const cv::Mat bgr = cv::imdecode(packed, cv::IMREAD_UNCHANGED);
    lt_image img;
    lt_status st;

    if (bgr.empty())
        return lt_error(LT_EFORMAT, "%s: not an image that can be read", name);
    if ((bgr.depth() != CV_8U && bgr.depth() != CV_16U) || bgr.channels() == 2 || bgr.channels() > 4)
        return lt_error(LT_EFORMAT, "%s: samples of a kind that is not read", name);
    st = lt_image_check(name, static_cast<uint64_t>(bgr.cols), static_cast<uint64_t>(bgr.rows));
    if (st)
        return st;
    st = lt_image_init(arena, bgr.cols, bgr.rows, bgr.channels(), bgr.depth() == CV_8U ? 8 : 16, &img);
    if (st)
        return st;
    const cv::Mat rgb = to_rgb(bgr);
    const size_t row = rgb.cols * rgb.elemSize();
    for (int y = 0; y < rgb.rows; y++)
        std::memcpy(img.data + y * row, rgb.ptr(y), row);
    *out = img;
    return LT_OK;
}

lt_status lt_opencv_decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                           lt_image *out)
{
    if (n > INT_MAX)
        return lt_error(LT_EFORMAT, "%s: %zu bytes are too many for an image", name, n);
    try {
        cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
        return decode(arena, name, bytes, n, out);
    } catch (const std::exception &e) {
        return lt_error(LT_EFORMAT, "%s: not an image that can be read: %s", name, e.what());
    } catch (...) {
        return lt_error(LT_EFORMAT, "%s: not an image that can be read", name);
    }
}

#else

lt_status lt_opencv_decode(lt_arena *, const char *name, const uint8_t *, size_t, lt_image *)
{
    return lt_error(LT_EFORMAT, "%s: neither PNG nor JPEG; other formats need a build with OpenCV", name);
}

#endif
