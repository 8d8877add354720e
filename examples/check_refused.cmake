# Runs PROGRAM with ARGUMENTS and fails unless it ends with CODE (2 if not given) and one line on stderr that matches
# SENTENCE.
#   cmake -D PROGRAM=... -D ARGUMENTS=... -D SENTENCE=... [-D CODE=...] -P check_refused.cmake
cmake_minimum_required(VERSION 3.25)
if(NOT DEFINED CODE)
  set(CODE 2)
endif()
execute_process(COMMAND ${PROGRAM} ${ARGUMENTS} OUTPUT_VARIABLE output ERROR_VARIABLE error RESULT_VARIABLE code)
if(NOT code EQUAL ${CODE} OR NOT error MATCHES "^${SENTENCE}\n$")
  message(FATAL_ERROR "${PROGRAM} ${ARGUMENTS} ended with ${code} and said\n${error}")
endif()
