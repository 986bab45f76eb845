# The objects of an instruction set may not define a function that a linker could use for another set's or the program's
# (weak symbols: whatever is inline and was not inlined).
foreach(object ${OBJECTS})
  execute_process(COMMAND ${NM} --defined-only ${object} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^\n]* [WVu] [^\n]*" weak "${symbols}")
  foreach(symbol ${weak})
    message(SEND_ERROR "${object} shares ${symbol}")
  endforeach()
endforeach()
