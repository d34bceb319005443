// SPDX-License-Identifier: Apache-2.0
// read_opencv.cc - OpenCV as a judge: reads frames of a video node and writes the bytes of each into a file.
//
//     read_opencv NODE FRAMES raw|decoded PREFIX      raw: as delivered; decoded: pictures, blue green red
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include <opencv2/videoio.hpp>

int main(int argc, char **argv)
{
    if (argc != 5)
        return 2;
    cv::VideoCapture camera(argv[1], cv::CAP_V4L2);
    if (!camera.isOpened())
        return 3;
    camera.set(cv::CAP_PROP_CONVERT_RGB, std::strcmp(argv[3], "raw") != 0);
    for (int i = 0; i < std::atoi(argv[2]); i++) { // NOLINT(cert-err34-c)
        cv::Mat frame;
        if (!camera.read(frame) || !frame.isContinuous())
            return 4;
        std::ofstream out(argv[4] + std::to_string(i), std::ios::binary);
        out.write(reinterpret_cast<const char *>(frame.data),
                  static_cast<std::streamsize>(frame.elemSize() * frame.total()));
        if (!out)
            return 5;
    }
    return 0;
}
