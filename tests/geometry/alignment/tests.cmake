# SPDX-License-Identifier: Apache-2.0
uwv_add_test(geometry_alignment
  SOURCES
    alignment/alignment_extremes_test.cpp
    alignment/alignment_test.cpp
    alignment/composite_test.cpp
  LIBS uwv::geometry uwv::eval)
uwv_add_test(geometry_alignment_parity
  SOURCES alignment/alignment_parity_test.cpp
  LIBS uwv::geometry uwv::render uwv::io
  LABELS parity)
