# Runs PROGRAM with OPTION and fails unless it says in two lines what it is, and ends with code 0.
#   cmake -D PROGRAM=... -D OPTION=--help -P check_help.cmake
cmake_minimum_required(VERSION 3.25)
get_filename_component(name ${PROGRAM} NAME)
execute_process(COMMAND ${PROGRAM} ${OPTION} OUTPUT_VARIABLE output ERROR_VARIABLE error RESULT_VARIABLE code)
if(NOT code EQUAL 0 OR NOT error STREQUAL "" OR NOT output MATCHES "^Usage: ${name}\n[^\n]+\n$")
  message(FATAL_ERROR "${PROGRAM} ${OPTION} ended with ${code} and said\n${output}${error}")
endif()
