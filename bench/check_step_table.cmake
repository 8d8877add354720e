# cmake -D BENCH=... -D KERNELS=... -D PYTHON=... -D TABLE=... -D OUT=... -P check_step_table.cmake
# Short benchmarks through the table: figure, mean, bar and verdict are there; with a second instruction set how much longer it
# takes; and what kernels take.
function(measure program filter file)
  execute_process(COMMAND ${program} "--benchmark_filter=${filter}" --benchmark_min_time=0.01 --benchmark_out=${OUT}/${file}
    --benchmark_out_format=json OUTPUT_QUIET ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
endfunction()
measure(${BENCH} "^(step/disc|memory)" disc.json)
measure(${KERNELS} "^kernels/3 with 6/ldlt" kernels.json)
set(ENV{GRAPHSOLVE_SIMD} plain)
measure(${BENCH} "^step/disc" disc-plain.json)
execute_process(COMMAND ${PYTHON} ${TABLE} ${OUT}/disc.json ${OUT}/disc-plain.json ${OUT}/kernels.json OUTPUT_VARIABLE text
  COMMAND_ERROR_IS_FATAL ANY)
foreach(line
    "\\| disc c=100, us/step \\| [0-9.]+ \\| [0-9.]+ \\| 10 \\| 6 \\| (aim|bar|bar without AVX-512|misses the bar) \\|"
    "\\| memory per body with one contact, bytes \\| [0-9]+ \\|"
    "\\| 3 with 6/ldlt \\| [0-9.]+ / [0-9.]+ \\|"
    "unit [0-9]+ ns .*commit [0-9a-f]+")
  if(NOT text MATCHES "${line}")
    message(FATAL_ERROR "no '${line}' in:\n${text}")
  endif()
endforeach()
