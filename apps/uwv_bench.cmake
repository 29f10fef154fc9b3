# SPDX-License-Identifier: Apache-2.0
find_package(CLI11 REQUIRED)
add_executable(uwv_bench
  uwv_bench.cpp
  bench/accuracy.cpp
  bench/child_process.cpp
  bench/colmap.cpp
  bench/alignment_accuracy.cpp
  bench/alignment_flicker.cpp
  bench/depth_width.cpp
  bench/dungeon_clip.cpp
  bench/geometry.cpp
  bench/geometry_camera_options.cpp
  bench/geometry_cameras.cpp
  bench/geometry_choices.cpp
  bench/geometry_depth.cpp
  bench/geometry_moving.cpp
  bench/geometry_scores.cpp
  bench/geometry_views.cpp
  bench/long_paths.cpp
  bench/option_accuracy.cpp
  bench/plot.cpp
  bench/real_pairs.cpp
  bench/real_views.cpp
  bench/render_speed.cpp
  bench/rendered.cpp
  bench/resolution_accuracy.cpp
  bench/save_clip.cpp
  bench/save_scene.cpp
  bench/skipped_passes.cpp
  bench/smeared_depth.cpp
  bench/stereo_depth.cpp
  bench/stereo_pairs.cpp
  bench/table.cpp
  bench/true_clip.cpp)
target_include_directories(uwv_bench PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(uwv_bench PRIVATE uwv_build_options uwv::render uwv::eval uwv::io CLI11::CLI11 nlohmann_json::nlohmann_json)

# Weights and speed of the video model, where the library was built with it.
if(TARGET uwv_model)
  target_sources(uwv_bench PRIVATE
    bench/model_commands.cpp
    bench/model_ladder.cpp
    bench/model_shapes.cpp
    bench/model_weights.cpp
    bench/model_windows.cpp)
  target_compile_definitions(uwv_bench PRIVATE UWV_BENCH_MODEL)
  target_include_directories(uwv_bench PRIVATE ${uwv_SOURCE_DIR}/src)

  # The files that see torch's headers, apart from those that link fmt; they share one precompiled ATen.
  add_library(uwv_bench_tensors OBJECT
    bench/model_known.cpp
    bench/model_text.cpp
    bench/model_transformer.cpp
    bench/model_vae.cpp)
  target_include_directories(uwv_bench_tensors PRIVATE ${CMAKE_CURRENT_SOURCE_DIR} ${uwv_SOURCE_DIR}/src)
  target_link_libraries(uwv_bench_tensors
    PRIVATE uwv_build_options uwv::model uwv::io CLI11::CLI11 nlohmann_json::nlohmann_json)
  uwv_use_torch(uwv_bench_tensors)
  target_link_libraries(uwv_bench PRIVATE uwv::model $<LINK_ONLY:uwv_torch> uwv_bench_tensors)
endif()
