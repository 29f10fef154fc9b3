# SPDX-License-Identifier: Apache-2.0
target_sources(uwv_geometry PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/bundle_adjustment.cpp
  ${CMAKE_CURRENT_LIST_DIR}/feature_tracking.cpp
  ${CMAKE_CURRENT_LIST_DIR}/hypotheses.cpp
  ${CMAKE_CURRENT_LIST_DIR}/incremental.cpp
  ${CMAKE_CURRENT_LIST_DIR}/lens_check.cpp
  ${CMAKE_CURRENT_LIST_DIR}/motion_kind.cpp
  ${CMAKE_CURRENT_LIST_DIR}/resection.cpp
  ${CMAKE_CURRENT_LIST_DIR}/result.cpp
  ${CMAKE_CURRENT_LIST_DIR}/structure_from_motion.cpp
  ${CMAKE_CURRENT_LIST_DIR}/track_refinement.cpp
  ${CMAKE_CURRENT_LIST_DIR}/tracks.cpp
  ${CMAKE_CURRENT_LIST_DIR}/triangulation.cpp
  ${CMAKE_CURRENT_LIST_DIR}/turning.cpp
  ${CMAKE_CURRENT_LIST_DIR}/two_view.cpp
)
