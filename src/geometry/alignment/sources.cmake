# SPDX-License-Identifier: Apache-2.0
target_sources(uwv_geometry PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/composite.cpp
  ${CMAKE_CURRENT_LIST_DIR}/depth_alignment.cpp
  ${CMAKE_CURRENT_LIST_DIR}/frame_fit.cpp
  ${CMAKE_CURRENT_LIST_DIR}/joint.cpp
  ${CMAKE_CURRENT_LIST_DIR}/line_fit.cpp
  ${CMAKE_CURRENT_LIST_DIR}/robust_start.cpp
  ${CMAKE_CURRENT_LIST_DIR}/samples.cpp
)
