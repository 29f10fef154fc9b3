# SPDX-License-Identifier: Apache-2.0
uwv_add_test(geometry_layers
  SOURCES
    layers/background_completion_test.cpp
    layers/background_from_views_test.cpp
    layers/foreground_propagation_test.cpp
    layers/foreground_test.cpp
    layers/planar_prior_layout_test.cpp
    layers/planar_prior_test.cpp
    layers/saliency_test.cpp
    layers/view_sightings_test.cpp
  LIBS uwv::geometry uwv::eval opencv_core)
target_include_directories(uwv_geometry_layers_test SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
target_compile_definitions(uwv_geometry_layers_test PRIVATE UWV_MODELS="${uwv_SOURCE_DIR}/.cache/models")
