# SPDX-License-Identifier: Apache-2.0
uwv_add_test(geometry_sfm
  SOURCES
    sfm/extremes_test.cpp
    sfm/lens_test.cpp
    sfm/motion_kind_test.cpp
    sfm/moving_test.cpp
  LIBS uwv::geometry uwv::eval)
