# SPDX-License-Identifier: Apache-2.0
uwv_add_test(geometry_moving
  SOURCES
    moving/decimation_test.cpp
    moving/moving_depth_test.cpp
    moving/moving_pixels_test.cpp
    moving/scene_profile_test.cpp
  LIBS uwv::geometry uwv::eval)
