# SPDX-License-Identifier: Apache-2.0
# Compile flags shared by everything of ours; consumers of the installed library get none of them but C++20.
add_library(uwv_build_options INTERFACE)
target_compile_features(uwv_build_options INTERFACE cxx_std_20)
target_compile_options(uwv_build_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  # The CPU renderer promises the GL renderer's arithmetic: no fused multiply-add behind our back.
  -ffp-contract=off
  # We never look at errno or floating-point traps; without these two, loops with sqrt or a select stay scalar.
  -fno-math-errno -fno-trapping-math)
# Part of the key under which finished stages are found again: see build_id().
target_link_options(uwv_build_options INTERFACE -Wl,--build-id=sha1)
if(UWV_WERROR)
  target_compile_options(uwv_build_options INTERFACE -Werror)
endif()
if(UWV_SANITIZE)
  target_compile_options(uwv_build_options INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(uwv_build_options INTERFACE -fsanitize=address,undefined)
  target_compile_definitions(uwv_build_options INTERFACE UWV_SANITIZED=1)
endif()
if(UWV_COVERAGE)
  target_compile_options(uwv_build_options INTERFACE --coverage -O0)
  target_link_options(uwv_build_options INTERFACE --coverage)
endif()

find_program(UWV_CCACHE ccache)
if(UWV_CCACHE AND PROJECT_IS_TOP_LEVEL)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${UWV_CCACHE})
endif()
