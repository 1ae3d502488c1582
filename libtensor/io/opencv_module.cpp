/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The module that reads images through OpenCV. It is loaded when the first such image comes, because OpenCV
 * brings a hundred libraries along. Exceptions end here.
 */
#include "libtensor/io/opencv_module.h"

#include <climits>
#include <cstdio>
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

static int refuse(char error[256], const char *why)
{
    std::snprintf(error, 256, "%s", why);
    return 1;
}

static int decode(const uint8_t *bytes, size_t n, lt_opencv_room room, void *ctx, char error[256])
{
    const cv::Mat packed(1, static_cast<int>(n), CV_8U, const_cast<uint8_t *>(bytes));
    const cv::Mat bgr = cv::imdecode(packed, cv::IMREAD_UNCHANGED);

    if (bgr.empty())
        return refuse(error, "not an image that can be read");
    if ((bgr.depth() != CV_8U && bgr.depth() != CV_16U) || bgr.channels() == 2 || bgr.channels() > 4)
        return refuse(error, "samples of a kind that is not read");
    const cv::Mat rgb = to_rgb(bgr);
    const size_t row = rgb.cols * rgb.elemSize();
    uint8_t *out = room(ctx, rgb.cols, rgb.rows, rgb.channels(), rgb.depth() == CV_8U ? 8 : 16);
    for (int y = 0; out && y < rgb.rows; y++)
        std::memcpy(out + y * row, rgb.ptr(y), row);
    return out ? 0 : 1;
}

extern "C" __attribute__((visibility("default"))) int images_opencv_decode(const uint8_t *bytes, size_t n,
                                                                           lt_opencv_room room, void *ctx,
                                                                           char error[256]);

int images_opencv_decode(const uint8_t *bytes, size_t n, lt_opencv_room room, void *ctx, char error[256])
{
    error[0] = '\0';
    if (n > INT_MAX)
        return refuse(error, "too many bytes for an image");
    try {
        cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
        return decode(bytes, n, room, ctx, error);
    } catch (const std::exception &e) {
        std::snprintf(error, 256, "not an image that can be read: %s", e.what());
    } catch (...) {
        refuse(error, "not an image that can be read");
    }
    return 1;
}
