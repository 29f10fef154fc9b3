# SPDX-License-Identifier: Apache-2.0
uwv_add_test(geometry_moving
  SOURCES
    moving/decimation_test.cpp
    moving/grouping_test.cpp
    moving/linked_pieces_test.cpp
    moving/moving_depth_test.cpp
    moving/moving_pixels_test.cpp
    moving/scene_profile_test.cpp
  LIBS uwv::geometry uwv::eval opencv_core)
target_include_directories(uwv_geometry_moving_test SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
