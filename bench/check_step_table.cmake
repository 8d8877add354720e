# cmake -D BENCH=... -D PYTHON=... -D TABLE=... -D JSON=... -P check_step_table.cmake
# Short benchmarks through the table: figure, mean, bar and verdict are there.
execute_process(COMMAND ${BENCH} "--benchmark_filter=^step/disc" --benchmark_min_time=0.01 --benchmark_out=${JSON}
  --benchmark_out_format=json OUTPUT_QUIET ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${PYTHON} ${TABLE} ${JSON} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
if(NOT text MATCHES "\\| disc c=100, us/step \\| [0-9.]+ \\| [0-9.]+ \\| 10 \\| 6 \\| (aim|bar|misses the bar) \\|")
  message(FATAL_ERROR "no row for the disc in:\n${text}")
endif()
if(NOT text MATCHES "unit [0-9]+ ns .*commit [0-9a-f]+")
  message(FATAL_ERROR "not said what the figures were measured with:\n${text}")
endif()
