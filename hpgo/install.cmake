# Installs the program, the layers and their headers, and exports hpgo::hpgo (all layers) and
# hpgo::LAYER for find_package(hpgo).
include(CMakePackageConfigHelpers)

get_property(layers GLOBAL PROPERTY HPGO_LAYERS)
add_library(hpgo INTERFACE)
target_link_libraries(hpgo INTERFACE ${layers})
add_library(hpgo::hpgo ALIAS hpgo)

set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/hpgo)
install(TARGETS hpgo ${layers} EXPORT hpgoTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT hpgoTargets NAMESPACE hpgo:: DESTINATION ${config_dir})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/ceres_costs ${PROJECT_SOURCE_DIR}/hpgo
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.h")
if(TARGET hpgo_program)
  install(TARGETS hpgo_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/hpgoConfig.cmake.in
  ${PROJECT_BINARY_DIR}/hpgoConfig.cmake INSTALL_DESTINATION ${config_dir})
# Below 1.0 a new minor version may break callers.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/hpgoConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/hpgoConfig.cmake ${PROJECT_BINARY_DIR}/hpgoConfigVersion.cmake
        DESTINATION ${config_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/third_party_notes.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR})
