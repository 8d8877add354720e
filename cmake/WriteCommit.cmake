# Run at every build: cmake -D SOURCE=... -D HEADER=... -P WriteCommit.cmake
# Writes the commit that is being built, "-dirty" with changes on it; touches the header only when it differs.
find_program(git git)
set(commit "unknown")
if(git)
  execute_process(COMMAND ${git} -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
    OUTPUT_VARIABLE output RESULT_VARIABLE code ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(code EQUAL 0)
    set(commit "${output}")
  endif()
endif()
file(CONFIGURE OUTPUT ${HEADER} CONTENT "#pragma once\n#define GRAPHSOLVE_COMMIT \"${commit}\"\n")
