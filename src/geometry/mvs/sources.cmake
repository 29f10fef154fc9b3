# SPDX-License-Identifier: Apache-2.0
target_sources(uwv_geometry PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/carry.cpp
  ${CMAKE_CURRENT_LIST_DIR}/completion.cpp
  ${CMAKE_CURRENT_LIST_DIR}/consistency.cpp
  ${CMAKE_CURRENT_LIST_DIR}/edge_snapping.cpp
  ${CMAKE_CURRENT_LIST_DIR}/multi_view_stereo.cpp
  ${CMAKE_CURRENT_LIST_DIR}/plane_sweep.cpp
  ${CMAKE_CURRENT_LIST_DIR}/reprojection.cpp
  ${CMAKE_CURRENT_LIST_DIR}/semi_global.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sweep_kernels.cpp
  ${CMAKE_CURRENT_LIST_DIR}/view.cpp
  ${CMAKE_CURRENT_LIST_DIR}/view_selection.cpp
)
