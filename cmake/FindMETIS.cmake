# METIS, graph partitioning and nested dissection.
#
#   find_package(METIS)   ->   target METIS::METIS, METIS_FOUND, METIS_VERSION
#
# Upstream's CMake package is preferred where there is one; Debian's has none. METIS can be built with 32-bit or
# 64-bit indices and the library does not say which; the header does. Only idx_t of 32 bits is accepted here.

find_package(METIS CONFIG QUIET)
if(NOT METIS_FOUND AND NOT TARGET METIS::METIS)
  find_package(metis CONFIG QUIET)  # METIS 5.2 and vcpkg: target metis
endif()

if(TARGET METIS::METIS)
  get_target_property(METIS_INCLUDE_DIR METIS::METIS INTERFACE_INCLUDE_DIRECTORIES)
  set(METIS_LIBRARY METIS::METIS)
elseif(TARGET metis)
  add_library(METIS::METIS ALIAS metis)
  get_target_property(METIS_INCLUDE_DIR metis INTERFACE_INCLUDE_DIRECTORIES)
  set(METIS_LIBRARY metis)
else()
  find_path(METIS_INCLUDE_DIR metis.h)
  find_library(METIS_LIBRARY metis)
  mark_as_advanced(METIS_INCLUDE_DIR METIS_LIBRARY)
endif()

set(_metis_reason)
if(METIS_INCLUDE_DIR AND METIS_LIBRARY)
  find_file(METIS_HEADER metis.h PATHS ${METIS_INCLUDE_DIR} NO_DEFAULT_PATH)
  mark_as_advanced(METIS_HEADER)
  if(METIS_HEADER)
    file(STRINGS ${METIS_HEADER} _metis_lines REGEX "^#define +METIS_VER_(MAJOR|MINOR|SUBMINOR)")
    string(REGEX REPLACE "[^0-9]+([0-9]+)" "\\1." METIS_VERSION "${_metis_lines}")
    string(REGEX REPLACE "\\.$" "" METIS_VERSION "${METIS_VERSION}")
  endif()
  include(CheckCXXSourceCompiles)
  set(CMAKE_REQUIRED_INCLUDES ${METIS_INCLUDE_DIR})
  set(CMAKE_REQUIRED_QUIET ON)
  check_cxx_source_compiles("#include <metis.h>
static_assert(sizeof(idx_t) == 4);
int main() {}" METIS_HAS_32_BIT_INDICES)
  unset(CMAKE_REQUIRED_INCLUDES)
  unset(CMAKE_REQUIRED_QUIET)
  if(NOT METIS_HAS_32_BIT_INDICES)
    set(_metis_reason REASON_FAILURE_MESSAGE "idx_t of ${METIS_HEADER} is not 32 bits wide")
  endif()
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(METIS
  REQUIRED_VARS METIS_LIBRARY METIS_INCLUDE_DIR METIS_HAS_32_BIT_INDICES
  VERSION_VAR METIS_VERSION ${_metis_reason})
unset(_metis_reason)
unset(_metis_lines)

if(METIS_FOUND AND NOT TARGET METIS::METIS)
  add_library(METIS::METIS UNKNOWN IMPORTED)
  set_target_properties(METIS::METIS PROPERTIES
    IMPORTED_LOCATION ${METIS_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${METIS_INCLUDE_DIR})
endif()
