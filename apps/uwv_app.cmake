# SPDX-License-Identifier: Apache-2.0
find_package(CLI11 2.1 REQUIRED)
add_executable(uwv_app
  uwv_app.cpp
  support/command_line.cpp
  support/doctor.cpp
  support/terminal_monitor.cpp)
target_include_directories(uwv_app PRIVATE ${CMAKE_CURRENT_LIST_DIR})
target_link_libraries(uwv_app PRIVATE uwv_build_options uwv::pipeline CLI11::CLI11)
target_compile_definitions(uwv_app PRIVATE UWV_BUILD_TYPE="${CMAKE_BUILD_TYPE}")
if(TARGET uwv_model)
  # --depth-model; without libtorch the program says what is missing.
  target_link_libraries(uwv_app PRIVATE uwv::model)
  target_compile_definitions(uwv_app PRIVATE UWV_APP_WITH_MODEL)
endif()
install(TARGETS uwv_app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
