# SPDX-License-Identifier: Apache-2.0
# Installs the headers, the module libraries and a package file, so that find_package(uwv) gives uwv::uwv.
include(CMakePackageConfigHelpers)

get_property(modules GLOBAL PROPERTY UWV_MODULES)
list(TRANSFORM modules REPLACE "^uwv_" "" OUTPUT_VARIABLE uwv_component_names)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/uwv)
if(TARGET uwv_model)
  # Not among uwv::uwv's modules, and with targets of its own: who does not ask for it needs no libtorch.
  list(APPEND uwv_component_names model)
  get_target_property(uwv_torch_used_dir uwv_torch UWV_ROOT)
  install(TARGETS uwv_model EXPORT uwvModelTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(EXPORT uwvModelTargets NAMESPACE uwv:: DESTINATION ${package_dir})
  install(FILES cmake/UwvTorch.cmake DESTINATION ${package_dir})
endif()
list(JOIN uwv_component_names " " uwv_component_names)
add_library(uwv INTERFACE)
add_library(uwv::uwv ALIAS uwv)
target_link_libraries(uwv INTERFACE ${modules})

install(DIRECTORY include/uwv DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(TARGETS uwv ${modules} EXPORT uwvTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT uwvTargets NAMESPACE uwv:: DESTINATION ${package_dir})
configure_package_config_file(cmake/uwvConfig.cmake.in ${uwv_BINARY_DIR}/uwvConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${uwv_BINARY_DIR}/uwvConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${uwv_BINARY_DIR}/uwvConfig.cmake ${uwv_BINARY_DIR}/uwvConfigVersion.cmake DESTINATION ${package_dir})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
