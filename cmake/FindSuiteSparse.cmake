# SuiteSparse, by component.
#
#   find_package(SuiteSparse COMPONENTS AMD COLAMD CHOLMOD)
#     ->  targets SuiteSparse::AMD ..., SuiteSparse_FOUND, SuiteSparse_AMD_FOUND ..., SuiteSparse_VERSION
#
# Components: AMD CAMD COLAMD CHOLMOD KLU UMFPACK; without a list, all. Upstream's CMake packages (SuiteSparse 7) are
# preferred where there are any; Debian 12 (5.12) has none.
# Licences differ: AMD, CAMD, COLAMD are BSD-3; CHOLMOD and KLU LGPL-2.1+; UMFPACK and parts of CHOLMOD (in the same
# library file) GPL-2+.

set(_suitesparse_known AMD CAMD COLAMD CHOLMOD KLU UMFPACK)
if(NOT SuiteSparse_FIND_COMPONENTS)
  set(SuiteSparse_FIND_COMPONENTS ${_suitesparse_known})
endif()
# What each needs besides itself; `config` is libsuitesparseconfig.
set(_suitesparse_AMD_needs config)
set(_suitesparse_CAMD_needs config)
set(_suitesparse_COLAMD_needs config)
set(_suitesparse_CCOLAMD_needs config)
set(_suitesparse_BTF_needs config)
set(_suitesparse_CHOLMOD_needs AMD CAMD COLAMD CCOLAMD config)
set(_suitesparse_KLU_needs AMD COLAMD BTF config)
set(_suitesparse_UMFPACK_needs AMD CHOLMOD config)

find_path(SuiteSparse_INCLUDE_DIR SuiteSparse_config.h PATH_SUFFIXES suitesparse)
find_library(SuiteSparse_config_LIBRARY suitesparseconfig)
mark_as_advanced(SuiteSparse_INCLUDE_DIR SuiteSparse_config_LIBRARY)
if(SuiteSparse_INCLUDE_DIR)
  file(STRINGS ${SuiteSparse_INCLUDE_DIR}/SuiteSparse_config.h _suitesparse_lines
    REGEX "^ *#define +SUITESPARSE_(MAIN|SUB|SUBSUB)_VERSION")
  string(REGEX REPLACE "[^0-9]+([0-9]+)" "\\1." SuiteSparse_VERSION "${_suitesparse_lines}")
  string(REGEX REPLACE "\\.$" "" SuiteSparse_VERSION "${SuiteSparse_VERSION}")
endif()

# Sets SuiteSparse_<component>_FOUND and makes the imported target, and those of what it needs.
function(_suitesparse_component component)
  set(target SuiteSparse::${component})
  if(TARGET ${target})
    set(SuiteSparse_${component}_FOUND TRUE PARENT_SCOPE)
    return()
  endif()
  if(component STREQUAL config)
    set(header SuiteSparse_config.h)
  else()
    find_package(${component} CONFIG QUIET)
    if(TARGET ${target})
      set(SuiteSparse_${component}_FOUND TRUE PARENT_SCOPE)
      return()
    endif()
    string(TOLOWER ${component} library)
    set(header ${library}.h)
    find_library(SuiteSparse_${component}_LIBRARY ${library})
    mark_as_advanced(SuiteSparse_${component}_LIBRARY)
  endif()
  set(SuiteSparse_${component}_FOUND FALSE PARENT_SCOPE)
  if(NOT SuiteSparse_${component}_LIBRARY OR NOT EXISTS "${SuiteSparse_INCLUDE_DIR}/${header}")
    return()
  endif()
  set(needed)
  foreach(need IN LISTS _suitesparse_${component}_needs)
    _suitesparse_component(${need})
    if(NOT SuiteSparse_${need}_FOUND)
      return()
    endif()
    list(APPEND needed SuiteSparse::${need})
  endforeach()
  add_library(${target} UNKNOWN IMPORTED)
  set_target_properties(${target} PROPERTIES
    IMPORTED_LOCATION ${SuiteSparse_${component}_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${SuiteSparse_INCLUDE_DIR}
    INTERFACE_LINK_LIBRARIES "${needed}")
  set(SuiteSparse_${component}_FOUND TRUE PARENT_SCOPE)
endfunction()

foreach(_component IN LISTS SuiteSparse_FIND_COMPONENTS)
  if(_component IN_LIST _suitesparse_known)
    _suitesparse_component(${_component})
  else()
    message(AUTHOR_WARNING "SuiteSparse has no component ${_component} here (known: ${_suitesparse_known})")
    set(SuiteSparse_${_component}_FOUND FALSE)
  endif()
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(SuiteSparse
  REQUIRED_VARS SuiteSparse_INCLUDE_DIR
  VERSION_VAR SuiteSparse_VERSION
  HANDLE_COMPONENTS)
unset(_component)
unset(_suitesparse_known)
unset(_suitesparse_lines)
