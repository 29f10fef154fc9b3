# SPDX-License-Identifier: Apache-2.0
# The OpenGL renderer. Only headers are needed to build it: libEGL and libOSMesa are opened at run time.
include(${uwv_SOURCE_DIR}/cmake/UwvEmbed.cmake)
target_sources(uwv_render PRIVATE
  gl_api.cpp
  gl_compute.cpp
  gl_context.cpp
  gl_egl.cpp
  gl_objects.cpp
  gl_osmesa.cpp
  gl_path.cpp
  gl_rasterizer.cpp
  gl_sprites.cpp
  gl_state_guard.cpp)
uwv_embed_shaders(uwv_render
  coverage.comp coverage.frag footprint.glsl nearest.frag nearest.vert nearest_code.comp nearest_depth.comp soft.frag
  soft.glsl soft.vert soft_splat.comp sprite.glsl warp.glsl)
target_link_libraries(uwv_render PRIVATE ${CMAKE_DL_LIBS})
