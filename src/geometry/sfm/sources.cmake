# SPDX-License-Identifier: Apache-2.0
target_sources(uwv_geometry PRIVATE
  sfm/bundle_adjustment.cpp
  sfm/feature_tracks.cpp
  sfm/motion_kind.cpp
  sfm/reconstruction.cpp
  sfm/sfm_result.cpp
  sfm/structure_from_motion.cpp
  sfm/two_view.cpp)
