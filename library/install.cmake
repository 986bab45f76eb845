# Installed by component, each a Debian package (packages.cmake):
#   program   the program, its parts, manual page, completion, pages     data     scenes, lessons, recordings, tissues
#   dev       headers, archives, find_package(Limberg), examples         python   import limberg
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The program.
if(LIMBERG_APP)
  install(TARGETS limberg RUNTIME COMPONENT program)
  install(FILES ${PROJECT_BINARY_DIR}/app/limberg.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
  install(FILES ${PROJECT_BINARY_DIR}/app/limberg.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
    RENAME limberg COMPONENT program)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/NOTICE ${PROJECT_SOURCE_DIR}/README.md
    ${PROJECT_SOURCE_DIR}/CONTRIBUTING.md TYPE DOC COMPONENT program)
  # README and docs show their pictures from where they lie.
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs TYPE DOC COMPONENT program PATTERN "*.json" EXCLUDE)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/recordings/pictures DESTINATION ${CMAKE_INSTALL_DOCDIR}/recordings COMPONENT program)
endif()

# What is shipped.
set(share ${CMAKE_INSTALL_DATADIR}/limberg)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/app/scenes ${PROJECT_SOURCE_DIR}/app/lessons DESTINATION ${share}/app COMPONENT data)
file(GLOB tables_of_words CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/app/words/*.po ${PROJECT_SOURCE_DIR}/app/words/*.pot)
install(FILES ${tables_of_words} DESTINATION ${share}/app/words COMPONENT data)
install(FILES ${PROJECT_SOURCE_DIR}/app/scene/tissues.toml DESTINATION ${share}/app/scene COMPONENT data)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/app/study/ranges DESTINATION ${share}/app/study COMPONENT data)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/recordings DESTINATION ${share} COMPONENT data PATTERN pictures EXCLUDE)

# The library. Headers keep their places: sim/patient/world.h is include/limberg/sim/patient/world.h.
install(TARGETS ${limberg_targets} EXPORT LimbergTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
set(config ${CMAKE_INSTALL_LIBDIR}/cmake/Limberg)
install(EXPORT LimbergTargets NAMESPACE Limberg:: DESTINATION ${config} COMPONENT dev)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/cmake/LimbergConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/LimbergConfig.cmake
  INSTALL_DESTINATION ${config} PATH_VARS share)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/LimbergConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/LimbergConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/LimbergConfigVersion.cmake
  ${CMAKE_CURRENT_LIST_DIR}/cmake/LimbergSuiteSparse.cmake DESTINATION ${config} COMPONENT dev)
set(headers ${CMAKE_INSTALL_INCLUDEDIR}/limberg)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/limberg/limberg.h DESTINATION ${headers} COMPONENT dev)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/sim DESTINATION ${headers} COMPONENT dev FILES_MATCHING PATTERN "*.h"
  PATTERN examples EXCLUDE PATTERN testing EXCLUDE PATTERN bullet EXCLUDE PATTERN gdcm EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/calibration ${PROJECT_SOURCE_DIR}/devices DESTINATION ${headers} COMPONENT dev
  FILES_MATCHING PATTERN "*.h" PATTERN messages EXCLUDE PATTERN message_codec.h EXCLUDE
  PATTERN heard_streams.h EXCLUDE PATTERN lcm_force_port.h EXCLUDE PATTERN toml.h EXCLUDE)
foreach(header scene/scene scene/scene_head scene/tissues assembly/bundle assembly/operation assembly/patient_of_scene assembly/world_patient head/build program/places
    program/shipped program/version session/lattice_shown session/patient session/story session/thread session/workers_pool)
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${PROJECT_SOURCE_DIR}/app/${header}.h DESTINATION ${headers}/app/${folder} COMPONENT dev)
endforeach()
install(DIRECTORY ${CMAKE_CURRENT_LIST_DIR}/examples DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/liblimberg-dev COMPONENT dev)

if(PROJECT_IS_TOP_LEVEL)
  include(${CMAKE_CURRENT_LIST_DIR}/packages.cmake)
endif()
