# SPDX-License-Identifier: Apache-2.0
# Installs the build `build`, moves the installation (it must not remember where it was), and uses it from the project
# `source`. CMakeLists.txt here passes the other settings.
cmake_minimum_required(VERSION 3.25)

# Runs a command; everything it printed comes back in `output`.
function(run wanted_result)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if((wanted_result STREQUAL success) AND NOT (result EQUAL 0))
    message(FATAL_ERROR "this failed (${result}): ${ARGN}\n${text}")
  elseif((wanted_result STREQUAL failure) AND (result EQUAL 0))
    message(FATAL_ERROR "this should have failed: ${ARGN}\n${text}")
  endif()
  string(REGEX REPLACE "[ \n]+" " " text "${text}") # CMake wraps its messages
  set(output "${text}" PARENT_SCOPE)
endfunction()

function(expect_output text)
  if(NOT output MATCHES "${text}")
    message(FATAL_ERROR "expected '${text}' in the output, which was:\n${output}")
  endif()
endfunction()

set(prefix ${work}/moved)
set(configure ${CMAKE_COMMAND} -S ${source} -G ${generator} -DCMAKE_MAKE_PROGRAM=${make_program}
  -DCMAKE_CXX_COMPILER=${compiler} -DCMAKE_CXX_COMPILER_LAUNCHER=${launcher} -DCMAKE_CXX_FLAGS=${flags}
  -DCMAKE_PREFIX_PATH=${prefix})

file(REMOVE_RECURSE ${work})
run(success ${CMAKE_COMMAND} --install ${build} --prefix ${work}/first)
file(RENAME ${work}/first ${prefix})

run(success ${configure} -B ${work}/build)
run(success ${CMAKE_COMMAND} --build ${work}/build)
run(success ${work}/build/consumer)
expect_output("pixel 42.00 24.00, 2592 pixels covered")

run(success ${configure} -B ${work}/build -Dwanted_component=core)
if(with_model)
  run(success ${configure} -B ${work}/build -Dwanted_component=model)
  run(success ${CMAKE_COMMAND} --build ${work}/build --target model_consumer)
  run(success ${work}/build/model_consumer)
  expect_output("no-such-folder: is no folder")
  run(failure ${configure} -B ${work}/build -Dwanted_component=model -DUWV_TORCH_DIR=${work})
  expect_output("uwv's component model needs libtorch")
endif()
run(failure ${configure} -B ${work}/build -Dwanted_component=nonsense)
expect_output("this uwv has no component 'nonsense'; it has uwv, core")
file(REMOVE_RECURSE ${work})
