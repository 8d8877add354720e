# cmake --install: headers, libraries, program, CMake package, pkg-config files. Packages: Packaging.cmake.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(graphsolve_config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/graphsolve)

# What our targets may link, apart from each other. Header-only ones are used in .cpp files alone, unless they are public:
# whoever links the installed library does not need them. Of the others a user of the static library needs the file, and
# CMake the package that knows it.
set(graphsolve_header_only Eigen3::Eigen nlohmann_json::nlohmann_json Boost::boost Boost::headers Boost::graph)
set(graphsolve_package_METIS::METIS "METIS")
set(graphsolve_link_METIS::METIS "-lmetis")
foreach(component AMD CAMD COLAMD)
  string(TOLOWER ${component} library)
  set(graphsolve_package_SuiteSparse::${component} "SuiteSparse COMPONENTS AMD CAMD COLAMD")
  set(graphsolve_link_SuiteSparse::${component} "-l${library}" "-lsuitesparseconfig")
endforeach()
set(graphsolve_package_fmt::fmt "fmt")
set(graphsolve_link_fmt::fmt "-lfmt")
set(graphsolve_package_tomlplusplus::tomlplusplus "tomlplusplus")
set(graphsolve_link_tomlplusplus::tomlplusplus "-ltomlplusplus")
set(graphsolve_package_hwy::hwy "hwy")
set(graphsolve_link_hwy::hwy "-lhwy")
set(graphsolve_package_Threads::Threads "Threads")
set(graphsolve_link_Threads::Threads "-pthread")
set(graphsolve_package_TBB::tbb "TBB")
set(graphsolve_link_TBB::tbb "-ltbb")

# Takes private header-only packages out of what `target` exports. Sets <prefix>_packages, a list of arguments of
# find_dependency, and <prefix>_links, flags for the linker, both for the static library.
function(graphsolve_prepare_export target prefix)
  get_target_property(interface ${target} INTERFACE_LINK_LIBRARIES)
  set(exported)
  set(packages)
  set(links)
  foreach(entry IN LISTS interface)
    string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" library "${entry}")
    if(library STREQUAL "interface-NOTFOUND" OR library MATCHES "^\\$<BUILD_INTERFACE:")
      continue()
    elseif(library STREQUAL "graphsolve::graphsolve" OR library STREQUAL entry)
      list(APPEND exported "${entry}")  # ours, or public: written into the config by hand
      continue()
    elseif(library IN_LIST graphsolve_header_only)
      continue()
    elseif(NOT DEFINED graphsolve_package_${library})
      message(FATAL_ERROR "cmake/Install.cmake does not know which package users of the static library of ${target} have "
        "to find for ${library}: add a line there")
    endif()
    list(APPEND exported "${entry}")
    list(APPEND packages "${graphsolve_package_${library}}")
    list(APPEND links ${graphsolve_link_${library}})
  endforeach()
  list(REMOVE_DUPLICATES packages)
  list(REMOVE_DUPLICATES links)
  list(JOIN links " " links)
  set_property(TARGET ${target} PROPERTY INTERFACE_LINK_LIBRARIES "${exported}")
  set(${prefix}_packages "${packages}" PARENT_SCOPE)
  set(${prefix}_links "${links}" PARENT_SCOPE)
endfunction()

# Before 1.0 every minor version may break the binary interface.
set(libraries graphsolve)
graphsolve_prepare_export(graphsolve solver)
set(physics_packages)
if(TARGET physics)
  list(APPEND libraries physics)
  set_target_properties(physics PROPERTIES OUTPUT_NAME graphsolve_physics)
  graphsolve_prepare_export(physics physics)
endif()
set_target_properties(${libraries} PROPERTIES VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})

foreach(library IN LISTS libraries)
  install(TARGETS ${library} EXPORT ${library}Targets
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT development
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
  install(EXPORT ${library}Targets NAMESPACE graphsolve:: DESTINATION ${graphsolve_config_dir} COMPONENT development)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${library}/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
    COMPONENT development FILES_MATCHING PATTERN "*.hpp")
endforeach()
if(TARGET graphsolve_cli)
  install(TARGETS graphsolve_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
  if(BUILD_SHARED_LIBS)
    file(RELATIVE_PATH to_libraries /${CMAKE_INSTALL_BINDIR} /${CMAKE_INSTALL_LIBDIR})
    set_target_properties(graphsolve_cli PROPERTIES INSTALL_RPATH "$ORIGIN/${to_libraries}")
  endif()
endif()

# CMake package. Find modules go with it where the static library needs what they find.
function(graphsolve_find_commands variable command)
  set(text "")
  foreach(package IN LISTS ARGN)
    string(APPEND text "${command}(${package})\n")
  endforeach()
  set(${variable} "${text}" PARENT_SCOPE)
endfunction()
graphsolve_find_commands(solver_find find_dependency ${solver_packages})
set(without_orderings)
foreach(package METIS SuiteSparse Boost)
  if(NOT ${package}_FOUND)
    list(APPEND without_orderings ${package})
  endif()
endforeach()
set(with_physics OFF)
if(TARGET physics)
  set(with_physics ON)
endif()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/graphsolveConfig.cmake.in
  ${PROJECT_BINARY_DIR}/graphsolveConfig.cmake INSTALL_DESTINATION ${graphsolve_config_dir}
  NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/graphsolveConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/graphsolveConfig.cmake ${PROJECT_BINARY_DIR}/graphsolveConfigVersion.cmake
  DESTINATION ${graphsolve_config_dir} COMPONENT development)
foreach(package METIS SuiteSparse)
  if("${solver_packages}" MATCHES "${package}")
    install(FILES ${CMAKE_CURRENT_LIST_DIR}/Find${package}.cmake DESTINATION ${graphsolve_config_dir}
      COMPONENT development)
  endif()
endforeach()

# pkg-config, relative to where the .pc file lies.
set(pc_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pc_to_prefix /${pc_dir} /)
string(REGEX REPLACE "/$" "" pc_to_prefix "${pc_to_prefix}")
set(pc_files graphsolve)
if(TARGET physics)
  list(APPEND pc_files graphsolve-physics)
endif()
foreach(library IN LISTS pc_files)
  # Where there is no shared library nobody asks for the static one by name: it needs its libraries always.
  if(library STREQUAL graphsolve)
    set(links "${solver_links}")
  else()
    set(links "${physics_links}")
  endif()
  set(static_links "")
  if(NOT BUILD_SHARED_LIBS AND links)
    set(static_links " ${links}")
  endif()
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${library}.pc.in ${PROJECT_BINARY_DIR}/${library}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${library}.pc DESTINATION ${pc_dir} COMPONENT development)
endforeach()
