# SPDX-License-Identifier: Apache-2.0
# Everything here comes from the distribution's packages; scripts/setup installs them.
find_package(Threads REQUIRED)
find_package(fmt 8 REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(nlohmann_json 3.9 REQUIRED)
find_package(ZLIB REQUIRED)
find_package(Ceres 2.0 REQUIRED)
find_package(OpenCV 4.5 REQUIRED COMPONENTS core imgproc imgcodecs photo calib3d features2d video dnn)
find_package(PkgConfig REQUIRED)
pkg_check_modules(UWV_FFMPEG REQUIRED IMPORTED_TARGET libavformat libavcodec libavutil libswscale)
pkg_check_modules(UWV_TINYGLTF REQUIRED tinygltf)
