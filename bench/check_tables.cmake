# cmake -D BENCH=... -D PYTHON=... -D TABLES=... -D JSON=... -P check_tables.cmake
# The smallest problem through the benchmark and the tables, with a solver of each sort: every table that has figures is
# there.
execute_process(COMMAND ${BENCH}
  "--benchmark_filter=^(speed|batch of 8)/quadruped/(graphsolve ld(u|lt)( packs)?|CHOLMOD simplicial|KLU|Eigen SimplicialLDLT)/"
  --benchmark_out=${JSON} --benchmark_out_format=json
  OUTPUT_QUIET ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${PYTHON} ${TABLES} ${JSON} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
foreach(title "Symmetric values" "times faster: pivots one by one" "Fill and analysis" "in packs against the fastest package"
    "Batch of 8 equal systems")
  string(FIND "${text}" "${title}" at)
  if(at LESS 0)
    message(FATAL_ERROR "no table '${title}' in:\n${text}")
  endif()
endforeach()
if(NOT text MATCHES "\\| quadruped \\| [0-9.]+ / [0-9.]+ ")
  message(FATAL_ERROR "no times of graphsolve in:\n${text}")
endif()
