# SPDX-License-Identifier: Apache-2.0
uwv_add_test(render_gl
  SOURCES gl_context_test.cpp gl_leaks.cpp gl_rasterizer_test.cpp
  LIBS uwv_render)
