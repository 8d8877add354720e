# The same objects for a static and for a shared library: a build that turns from one to the other only links again.
function(graphsolve_library_code target)
  set_target_properties(${target} PROPERTIES DEFINE_SYMBOL "")  # nothing of ours asks which one it is
  # Calls within the library stay calls within the library, as fast as in code that cannot be moved.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU,Clang>:-fno-semantic-interposition>)
endfunction()
