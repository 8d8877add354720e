# Half of a file's compile time was what it includes of the standard library, Eigen and GoogleTest: that is read once per
# target, where it has a few files at least. Files go on to include what they need: consumer.add_subdirectory compiles the
# solver without this.
# Usage: graphsolve_precompile(TARGET [EIGEN] [FMT] [GTEST] [JSON] [CLI])
option(GRAPHSOLVE_PRECOMPILE "Precompile the headers that most files include" ${PROJECT_IS_TOP_LEVEL})

function(graphsolve_precompile target)
  get_target_property(sources ${target} SOURCES)
  list(LENGTH sources files)
  if(NOT GRAPHSOLVE_PRECOMPILE OR files LESS 4)
    return()
  endif()
  set(headers <algorithm> <array> <cmath> <functional> <map> <memory> <optional> <span> <stdexcept> <string> <vector>)
  set(of_EIGEN <Eigen/Dense> <Eigen/SparseCore>)
  set(of_FMT <fmt/format.h>)
  set(of_GTEST <gtest/gtest.h>)
  set(of_JSON <nlohmann/json.hpp>)
  set(of_CLI <CLI/CLI.hpp>)
  foreach(package IN LISTS ARGN)
    list(APPEND headers ${of_${package}})
  endforeach()
  target_precompile_headers(${target} PRIVATE ${headers})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # For ccache (with CCACHE_SLOPPINESS=pch_defines,time_macros); and false alarms on string concatenation, which GCC 12
    # keeps to itself in system headers, but not in precompiled ones.
    target_compile_options(${target} PRIVATE -fpch-preprocess -Wno-stringop-overflow -Wno-array-bounds)
  endif()
  # Kernels have options of their own, which a precompiled header would have to share.
  list(FILTER sources INCLUDE REGEX "_kernels\\.cpp$")
  set_source_files_properties(${sources} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
endfunction()
