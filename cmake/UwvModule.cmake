# SPDX-License-Identifier: Apache-2.0

# uwv_add_module(<name> [APART] SOURCES ... [MODULES lower modules...] [PUBLIC libs...] [PRIVATE libs...])
# One static library `uwv_<name>`, alias `uwv::<name>`, per module; its headers are include/uwv/<name>/.
# APART keeps a module with uncommon needs out of uwv::uwv; UwvInstall.cmake exports it as a component of its own.
function(uwv_add_module name)
  cmake_parse_arguments(ARG "APART" "" "SOURCES;MODULES;PUBLIC;PRIVATE" ${ARGN})
  add_library(uwv_${name} STATIC ${ARG_SOURCES})
  add_library(uwv::${name} ALIAS uwv_${name})
  set_target_properties(uwv_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_compile_features(uwv_${name} PUBLIC cxx_std_20)
  target_include_directories(uwv_${name}
    PUBLIC $<BUILD_INTERFACE:${uwv_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${uwv_SOURCE_DIR}/src)
  target_link_libraries(uwv_${name} PUBLIC ${ARG_PUBLIC} PRIVATE $<BUILD_INTERFACE:uwv_build_options> ${ARG_PRIVATE})
  foreach(lower ${ARG_MODULES})
    target_link_libraries(uwv_${name} PUBLIC uwv_${lower})
  endforeach()
  if(NOT ARG_APART)
    set_property(GLOBAL APPEND PROPERTY UWV_MODULES uwv_${name})
  endif()
endfunction()

# uwv_add_test(<module> SOURCES ... [LIBS ...] [LABELS ...])
# A GoogleTest program `uwv_<module>_test`, each of its tests registered as "<module>.<suite>.<test>".
function(uwv_add_test module)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS;LABELS" ${ARGN})
  set(target uwv_${module}_test)
  add_executable(${target} ${ARG_SOURCES})
  target_include_directories(${target} PRIVATE ${uwv_SOURCE_DIR}/tests ${uwv_SOURCE_DIR}/src)
  target_link_libraries(${target} PRIVATE uwv_build_options ${ARG_LIBS} GTest::gtest GTest::gmock GTest::gtest_main)
  # What is tested is compiled as users have it; the tests around it, much of all there is to compile, need not be fast.
  target_compile_options(${target} PRIVATE $<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU,Clang>>:-O1>
    # So compiled, GCC does not follow Eigen's storage far enough to see that it is set.
    $<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU>>:-Wno-maybe-uninitialized>)
  target_compile_definitions(${target} PRIVATE UWV_TEST_DATA="${uwv_SOURCE_DIR}/tests/data")
  set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${uwv_BINARY_DIR}/tests)
  # Tests run beside each other: threads that wait for work by spinning would take the processors from the others, and a
  # test of two threads then takes three times as long.
  set(properties TIMEOUT 600 ENVIRONMENT OMP_WAIT_POLICY=passive)
  if(ARG_LABELS)
    list(APPEND properties LABELS ${ARG_LABELS})
  endif()
  gtest_discover_tests(${target} TEST_PREFIX ${module}. DISCOVERY_TIMEOUT 60 PROPERTIES ${properties})
endfunction()
