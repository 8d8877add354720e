# Runs PROGRAM with ARGUMENTS and fails unless it ends with code 2 and one line on stderr that matches SENTENCE.
#   cmake -D PROGRAM=... -D ARGUMENTS=... -D SENTENCE=... -P check_refused.cmake
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND ${PROGRAM} ${ARGUMENTS} OUTPUT_VARIABLE output ERROR_VARIABLE error RESULT_VARIABLE code)
if(NOT code EQUAL 2 OR NOT error MATCHES "^${SENTENCE}\n$")
  message(FATAL_ERROR "${PROGRAM} ${ARGUMENTS} ended with ${code} and said\n${error}")
endif()
