# SPDX-License-Identifier: Apache-2.0
uwv_add_test(geometry_mvs
  SOURCES
    mvs/multi_view_stereo_extremes_test.cpp
    mvs/multi_view_stereo_test.cpp
    mvs/mvs_parts_test.cpp
  LIBS uwv::geometry uwv::eval)
