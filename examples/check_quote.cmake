# Fails unless README contains the file QUOTED, whole, as a C++ block.
file(READ "${README}" readme)
file(READ "${QUOTED}" quoted)
string(FIND "${readme}" "```cpp\n${quoted}```\n" place)
if(place LESS 0)
  message(FATAL_ERROR "${README} does not quote ${QUOTED} as it is: copy the file into its cpp block")
endif()
