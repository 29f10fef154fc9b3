# SPDX-License-Identifier: Apache-2.0
target_sources(uwv_geometry PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/background_completion.cpp
  ${CMAKE_CURRENT_LIST_DIR}/background_from_views.cpp
  ${CMAKE_CURRENT_LIST_DIR}/colour_model.cpp
  ${CMAKE_CURRENT_LIST_DIR}/completion_parts.cpp
  ${CMAKE_CURRENT_LIST_DIR}/contrast_finder.cpp
  ${CMAKE_CURRENT_LIST_DIR}/foreground.cpp
  ${CMAKE_CURRENT_LIST_DIR}/foreground_propagation.cpp
  ${CMAKE_CURRENT_LIST_DIR}/horizon.cpp
  ${CMAKE_CURRENT_LIST_DIR}/planar_prior.cpp
  ${CMAKE_CURRENT_LIST_DIR}/prior_backdrop.cpp
  ${CMAKE_CURRENT_LIST_DIR}/prior_contour.cpp
  ${CMAKE_CURRENT_LIST_DIR}/prior_foreground.cpp
  ${CMAKE_CURRENT_LIST_DIR}/prior_sky.cpp
  ${CMAKE_CURRENT_LIST_DIR}/saliency_network.cpp
  ${CMAKE_CURRENT_LIST_DIR}/smooth_fill.cpp
  ${CMAKE_CURRENT_LIST_DIR}/view_sightings.cpp
)
