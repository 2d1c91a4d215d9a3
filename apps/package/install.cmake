# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` leaves behind: components `tools` (the program), `runtime` (liboctant.so), `dev` (headers, libraries,
# CMake and pkg-config files) and `python`. CPack makes Debian packages of them.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(OCTANT_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/octant)
if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # packages do not wait for the tests
endif()

# <octant/models/fix.h> before installation too.
foreach(room models io calib survey)
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/include/octant)
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${room} ${PROJECT_BINARY_DIR}/include/octant/${room} SYMBOLIC)
endforeach()

# octant_install_pc(NAME DESCRIPTION LIBS REQUIRES CFLAGS): a pkg-config file.
function(octant_install_pc name description libs requires cflags)
  set(PC_NAME ${name})
  set(PC_DESCRIPTION ${description})
  set(PC_LIBS ${libs})
  set(PC_REQUIRES ${requires})
  set(PC_CFLAGS ${cflags})
  file(RELATIVE_PATH PC_UP /x/${CMAKE_INSTALL_LIBDIR}/pkgconfig /x)  # where it is moved to, its files are too
  configure_file(${PROJECT_SOURCE_DIR}/apps/package/octant.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
endfunction()

# octant_install_room(models): its library with an exported target, its headers, its pkg-config file.
function(octant_install_room room)
  install(TARGETS octant_${room} EXPORT octant-${room} COMPONENT dev INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT octant-${room} NAMESPACE octant:: FILE octant-${room}-targets.cmake DESTINATION ${OCTANT_CMAKE_DIR} COMPONENT dev)
  install(CODE "set(octant_room ${room})\nset(octant_source \"${PROJECT_SOURCE_DIR}\")\nset(octant_include \"${CMAKE_INSTALL_INCLUDEDIR}\")"
    COMPONENT dev)
  install(SCRIPT ${PROJECT_SOURCE_DIR}/apps/package/install_headers.cmake COMPONENT dev)
  set(requires_models "eigen3")
  set(requires_io "octant-models yaml-0.1 fmt libcrypto liblz4 libpng libzstd pugixml sqlite3 zlib")
  if(OCTANT_POSTGRESQL)
    string(APPEND requires_io " libpq")
  endif()
  set(requires_calib "octant-models fmt libhwy")
  set(requires_survey "octant-models fmt libhwy nlopt libqrencode")
  set(libs_calib " -lceres -lcholmod")
  set(cflags "")
  if(room STREQUAL "models")
    set(cflags "-DEIGEN_MAX_ALIGN_BYTES=16 -DEIGEN_MALLOC_ALREADY_ALIGNED=1")
  endif()
  octant_install_pc(octant-${room} "Octant's ${room}" "-loctant_${room}${libs_${room}}" "${requires_${room}}" "${cflags}")
endfunction()

configure_package_config_file(${PROJECT_SOURCE_DIR}/apps/package/octant-config.cmake.in ${PROJECT_BINARY_DIR}/octant-config.cmake
  INSTALL_DESTINATION ${OCTANT_CMAKE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/octant-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/octant-config.cmake ${PROJECT_BINARY_DIR}/octant-config-version.cmake
  DESTINATION ${OCTANT_CMAKE_DIR} COMPONENT dev)

# The licence where Debian looks for it, in each package.
set(OCTANT_RUNTIME_PACKAGE liboctant${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
foreach(package tools=octant runtime=${OCTANT_RUNTIME_PACKAGE} dev=liboctant-dev python=python3-octant)
  string(REPLACE "=" ";" package ${package})
  list(GET package 0 component)
  list(GET package 1 name)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} RENAME copyright COMPONENT ${component})
endforeach()

if(PROJECT_IS_TOP_LEVEL)
  set(CPACK_GENERATOR DEB)
  set(CPACK_PACKAGE_CONTACT "Octant developers <octant@localhost>")
  set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_DEB_COMPONENT_INSTALL ON)
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PACKAGE_SECTION science)
  # octant: the program; liboctant0.2: the library for robots' own programs; liboctant-dev; python3-octant.
  set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
  set(CPACK_COMPONENT_TOOLS_GROUP octant)
  set(CPACK_COMPONENT_RUNTIME_GROUP runtime)
  set(CPACK_COMPONENT_DEV_GROUP dev)
  set(CPACK_COMPONENT_PYTHON_GROUP python)
  set(CPACK_COMPONENTS_ALL tools runtime dev python)
  set(CPACK_DEBIAN_OCTANT_PACKAGE_NAME octant)
  set(CPACK_DEBIAN_OCTANT_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME ${OCTANT_RUNTIME_PACKAGE})
  set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
  set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_DEV_PACKAGE_NAME liboctant-dev)
  set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
  set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "${OCTANT_RUNTIME_PACKAGE} (= ${PROJECT_VERSION}), libeigen3-dev, libexpected-dev")
  set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "libceres-dev, libfmt-dev, libhwy-dev, liblz4-dev, libnlopt-cxx-dev, libnlopt-dev, libpng-dev, libpugixml-dev, libqrencode-dev, libsqlite3-dev, libssl-dev, libsuitesparse-dev, libyaml-dev, libzstd-dev, nlohmann-json3-dev, zlib1g-dev")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-octant)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, python3-numpy")
  include(CPack)
endif()
