# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
# Installs a room's headers under octant/; what they include of Octant is spelled octant/ too, so that no folder of the user's
# own (models/, io/) comes before. Headers that say that they are private to io stay behind, and the insides of vector kernels
# (-inl.h): they need what users need not have.
file(GLOB_RECURSE headers RELATIVE ${octant_source} ${octant_source}/${octant_room}/*.h ${octant_source}/${octant_room}/*.inc)
foreach(header ${headers})
  file(READ ${octant_source}/${header} text)
  if(text MATCHES "Private to io" OR header MATCHES "-inl[.]h$")
    continue()
  endif()
  string(REGEX REPLACE "#include \"(models|io|calib|survey)/" "#include \"octant/\\1/" text "${text}")
  set(target $ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/${octant_include}/octant/${header})
  set(before "")
  if(EXISTS ${target})
    file(READ ${target} before)
  endif()
  if(NOT before STREQUAL text)
    file(WRITE ${target} "${text}")
  endif()
  list(APPEND CMAKE_INSTALL_MANIFEST_FILES ${CMAKE_INSTALL_PREFIX}/${octant_include}/octant/${header})
endforeach()
