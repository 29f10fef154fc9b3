# SPDX-License-Identifier: Apache-2.0
# Installs the headers, the module libraries and a package file, so that find_package(uwv) gives uwv::uwv.
include(CMakePackageConfigHelpers)

get_property(modules GLOBAL PROPERTY UWV_MODULES)
list(TRANSFORM modules REPLACE "^uwv_" "" OUTPUT_VARIABLE uwv_component_names)
list(JOIN uwv_component_names " " uwv_component_names)
add_library(uwv INTERFACE)
add_library(uwv::uwv ALIAS uwv)
target_link_libraries(uwv INTERFACE ${modules})

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/uwv)
install(DIRECTORY include/uwv DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(TARGETS uwv ${modules} EXPORT uwvTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT uwvTargets NAMESPACE uwv:: DESTINATION ${package_dir})
configure_package_config_file(cmake/uwvConfig.cmake.in ${uwv_BINARY_DIR}/uwvConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${uwv_BINARY_DIR}/uwvConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${uwv_BINARY_DIR}/uwvConfig.cmake ${uwv_BINARY_DIR}/uwvConfigVersion.cmake DESTINATION ${package_dir})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
