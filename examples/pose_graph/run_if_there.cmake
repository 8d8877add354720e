# cmake -D PROGRAM=... -D FILE=... -P run_if_there.cmake
if(NOT EXISTS ${FILE})
  message("skipped, no data: ${FILE} is not there")
  return()
endif()
execute_process(COMMAND ${PROGRAM} ${FILE} RESULT_VARIABLE code)
message("ended with ${code}")
