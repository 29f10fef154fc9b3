# SPDX-License-Identifier: Apache-2.0
# Finds libtorch and makes the imported target uwv_torch of it; without one, UWV_TORCH_MISSING says why. Looked at are
# UWV_TORCH_DIR (a folder with torch/include or include in it: a Python package, or the archive of libtorch) and what
# scripts/setup fetched. torch's own package file is not used: it insists on CUDA where the build knows CUDA.
set(UWV_TORCH_DIR "" CACHE PATH "libtorch; empty: what scripts/setup fetched")
set(UWV_TORCH_MISSING "")

# uwv_compile_with_torch(<source>...): these of a target's sources see torch's headers, without their warnings.
function(uwv_compile_with_torch)
  get_target_property(folders uwv_torch INTERFACE_INCLUDE_DIRECTORIES)
  get_target_property(definitions uwv_torch INTERFACE_COMPILE_DEFINITIONS)
  list(TRANSFORM folders PREPEND "-isystem")
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "${folders}" COMPILE_DEFINITIONS "${definitions}")
endfunction()

# uwv_use_torch(<target>): all of a target's sources see torch's headers, ATen precompiled.
function(uwv_use_torch target)
  target_link_libraries(${target} PRIVATE uwv_torch)
  target_precompile_headers(${target} PRIVATE <ATen/ATen.h>)
  # Without these ccache refuses every file that uses a precompiled header.
  get_target_property(launcher ${target} CXX_COMPILER_LAUNCHER)
  if(launcher MATCHES "ccache")
    set_target_properties(${target} PROPERTIES CXX_COMPILER_LAUNCHER
      "${CMAKE_COMMAND};-E;env;CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime;${launcher}")
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
  endif()
endfunction()

if(TARGET uwv_torch)
  return()
endif()
if(UWV_TORCH_DIR)
  set(uwv_torch_from "${UWV_TORCH_DIR}")
else()
  set(uwv_torch_from "${UWV_TORCH_DEFAULT_DIR}")
endif()
unset(uwv_torch_root)
foreach(root IN ITEMS "${uwv_torch_from}/torch" "${uwv_torch_from}")
  if(EXISTS "${root}/include/torch/script.h" AND EXISTS "${root}/lib/libtorch_cpu.so")
    set(uwv_torch_root "${root}")
    break()
  endif()
endforeach()
if(NOT uwv_torch_root)
  set(UWV_TORCH_MISSING "no include/torch/script.h and lib/libtorch_cpu.so in '${uwv_torch_from}'")
  return()
endif()
# The string class of the C++ library, on which OpenCV and fmt were built, must be torch's too.
file(STRINGS "${uwv_torch_root}/lib/libc10.so" uwv_torch_new_strings REGEX "__cxx11" LIMIT_COUNT 1)
if(NOT uwv_torch_new_strings)
  set(UWV_TORCH_MISSING "the libtorch in '${uwv_torch_root}' was built with the C++ ABI from before 2011")
  return()
endif()

# A libtorch for GPUs has what runs there in libraries of their own, which nothing refers to by name: they register
# themselves when they are loaded.
set(uwv_torch_devices "")
foreach(name IN ITEMS torch_cuda torch_hip torch_xpu)
  if(EXISTS "${uwv_torch_root}/lib/lib${name}.so")
    list(APPEND uwv_torch_devices
      "-Wl,--push-state,--no-as-needed,${uwv_torch_root}/lib/lib${name}.so,--pop-state")
  endif()
endforeach()

add_library(uwv_torch INTERFACE IMPORTED GLOBAL)
set_target_properties(uwv_torch PROPERTIES
  UWV_ROOT "${uwv_torch_root}"
  # torch brings a copy of fmt's headers without a library to link; what includes torch carries that fmt inside.
  INTERFACE_COMPILE_DEFINITIONS "_GLIBCXX_USE_CXX11_ABI=1;FMT_HEADER_ONLY=1"
  INTERFACE_INCLUDE_DIRECTORIES "${uwv_torch_root}/include;${uwv_torch_root}/include/torch/csrc/api/include"
  INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${uwv_torch_root}/include;${uwv_torch_root}/include/torch/csrc/api/include"
  INTERFACE_LINK_LIBRARIES "${uwv_torch_root}/lib/libtorch_cpu.so;${uwv_torch_root}/lib/libc10.so;${uwv_torch_devices}"
  # Programs find torch where it is; its CUDA helpers are found by torch's own search path only. libtorch comes before all
  # other libraries, as an option: the loader gives its matrix products to the first BLAS it meets, and behind the
  # system's they take ten times as long (uwv/core/matrix_library.h).
  INTERFACE_LINK_OPTIONS "-Wl,-rpath,${uwv_torch_root}/lib;-Wl,--allow-shlib-undefined;SHELL:-Wl,--push-state,--no-as-needed \"${uwv_torch_root}/lib/libtorch_cpu.so\" -Wl,--pop-state")
