// SPDX-License-Identifier: Apache-2.0
// saddle_refine_opencv.cc - the corner refinement through OpenCV: the one file that includes it.
//
// What cornerSubPix would refuse is checked before, since OpenCV prints what it throws.
#include "calib/saddle_refine.h"

#include <cmath>
#include <exception>
#include <vector>

#include <opencv2/imgproc.hpp>

sheen_status sheen_saddle_refine(double q_px[2], const uint8_t *grey, int width_px, int height_px,
                                 int half_px, sheen_err *err)
try {
    if (half_px < 1 || half_px > SHEEN_SADDLE_MAX_HALF_PX)
        return sheen_fail(err, SHEEN_EARG, "a window of %d px to each side is out of range", half_px);
    const double margin = half_px + 3;
    if (!(q_px[0] >= margin && q_px[1] >= margin && q_px[0] <= width_px - 1 - margin &&
          q_px[1] <= height_px - 1 - margin))
        return sheen_fail(err, SHEEN_EDATA, "a corner lies at the edge of the picture");

    const cv::Mat image(height_px, width_px, CV_8UC1, const_cast<uint8_t *>(grey));
    std::vector<cv::Point2f> corner{cv::Point2f(float(q_px[0]), float(q_px[1]))};
    const cv::TermCriteria criteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 1e-3);
    cv::cornerSubPix(image, corner, cv::Size(half_px, half_px), cv::Size(-1, -1), criteria);
    const double x = double(corner[0].x), y = double(corner[0].y);
    // OpenCV puts a corner that runs away, or lies in a flat place, back to where it was
    const bool moved = corner[0] != cv::Point2f(float(q_px[0]), float(q_px[1]));
    if (!(moved && std::fabs(x - q_px[0]) < half_px && std::fabs(y - q_px[1]) < half_px))
        return sheen_fail(err, SHEEN_EDATA, "a corner ran out of its window");
    q_px[0] = x;
    q_px[1] = y;
    return SHEEN_OK;
} catch (const std::exception &e) {
    return sheen_fail(err, SHEEN_ENOMEM, "OpenCV failed to refine a corner: %s", e.what());
}
