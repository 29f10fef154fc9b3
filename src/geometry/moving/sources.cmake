# SPDX-License-Identifier: Apache-2.0
target_sources(uwv_geometry PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/decimation.cpp
  ${CMAKE_CURRENT_LIST_DIR}/dense_flow.cpp
  ${CMAKE_CURRENT_LIST_DIR}/motion_evidence.cpp
  ${CMAKE_CURRENT_LIST_DIR}/grouping.cpp
  ${CMAKE_CURRENT_LIST_DIR}/linked_pieces.cpp
  ${CMAKE_CURRENT_LIST_DIR}/moving_depth.cpp
  ${CMAKE_CURRENT_LIST_DIR}/moving_pixels.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pieces.cpp
  ${CMAKE_CURRENT_LIST_DIR}/regions.cpp
  ${CMAKE_CURRENT_LIST_DIR}/scene_profile.cpp
)
