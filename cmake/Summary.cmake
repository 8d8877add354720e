# Says at configure time what was found of the optional packages.
function(graphsolve_summary_line name found version)
  if(found)
    message(STATUS "  ${name}: ${version}")
  else()
    message(STATUS "  ${name}: missing (scripts/setup installs it)")
  endif()
endfunction()

message(STATUS "graphsolve ${PROJECT_VERSION}, ${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}, "
  "build type ${CMAKE_BUILD_TYPE}; optional packages:")
graphsolve_summary_line("METIS" "${METIS_FOUND}" "${METIS_VERSION}, 32-bit indices")
foreach(component AMD CAMD COLAMD CHOLMOD KLU UMFPACK)
  graphsolve_summary_line("SuiteSparse ${component}" "${SuiteSparse_${component}_FOUND}"
    "of SuiteSparse ${SuiteSparse_VERSION}")
endforeach()
graphsolve_summary_line("Boost.Graph" "${Boost_FOUND}" "of Boost ${Boost_VERSION_STRING}")
